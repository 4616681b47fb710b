"""Primitives in C: what other languages have as an operation, and C in a library alone; these ask no library."""

from __future__ import annotations

import math
import struct
from collections.abc import Collection
from string import Template
from typing import NamedTuple

import numpy as np


class Real(NamedTuple):
    """A format of real numbers in C, and the words that hold their bits."""

    type: str
    word: str
    signed: str
    bits: int
    digits: int  # binary digits behind the point of the mantissa
    suffix: str

    @property
    def mark(self) -> str:
        """The ending of the names of its functions, as of C's own sinf."""
        return self.suffix

    def literal(self, value: float) -> str:
        """A finite number as C reads it to the last bit; a ValueError if it is none in this format."""
        with np.errstate(over="ignore", under="ignore"):
            held = np.float32(value) if self.suffix else np.float64(value)
        if not np.isfinite(held):
            raise ValueError(
                f"The law has the number {value:g}, which is {held} in {self.bits} bits: export it in double "
                "precision, or change that number."
            )
        text = str(np.float32(value)) if self.suffix else repr(float(value))
        return f"{text}{self.suffix}"

    def pattern(self, value: float) -> int:
        """The bits of a number as a whole number."""
        real, word = ("f", "I") if self.suffix else ("d", "Q")
        return int(struct.unpack(f"<{word}", struct.pack(f"<{real}", value))[0])


DOUBLE = Real("double", "uint64_t", "int64_t", 64, 52, "")
SINGLE = Real("float", "uint32_t", "int32_t", 32, 23, "f")

# Where no processor has an instruction of its own, C asks its library: these ask nobody.
PRIMITIVES = {
    "bits": """static $word ${name}_bits$mark($real x)
{
    union { $real number; $word word; } both;
    both.number = x;
    return both.word;
}""",
    "number": """static $real ${name}_number$mark($word w)
{
    union { $real number; $word word; } both;
    both.word = w;
    return both.number;
}""",
    "finite": """static bool ${name}_finite$mark($real x)
{
    return (${name}_bits$mark(x) & $infinity) != $infinity; /* also under options that assume it */
}""",
    "defined": """static bool ${name}_defined$mark($real x)
{
    return (${name}_bits$mark(x) & ~$sign) <= $infinity; /* it is a number, or infinite */
}""",
    "fabs": """static $real ${name}_fabs$mark($real x)
{
    return ${name}_number$mark(${name}_bits$mark(x) & ~$sign);
}""",
    "copysign": """static $real ${name}_copysign$mark($real x, $real y)
{
    return ${name}_number$mark((${name}_bits$mark(x) & ~$sign) | (${name}_bits$mark(y) & $sign));
}""",
    "trunc": """static $real ${name}_trunc$mark($real x)
{
    return (${name}_fabs$mark(x) < $whole) ? ${name}_copysign$mark(($real)($integer)x, x) : x;
}""",
    "floor": """static $real ${name}_floor$mark($real x)
{
    const $real whole = ${name}_trunc$mark(x);
    return (whole > x) ? (whole - $one) : whole;
}""",
    "sqrt": """/* The correctly rounded square root, digit by digit as on paper. */
static $real ${name}_sqrt$mark($real x)
{
    const $real scaled = (x < $smallest) ? (x * $up) : x;
    const $word pattern = ${name}_bits$mark(scaled);
    const int exponent = (int)(pattern >> ${digits}u) - $bias;
    const unsigned odd = (unsigned)exponent & 1u;
    const int half = (exponent - (int)odd) / 2;
    $word rest = ((pattern & $mantissa) | $hidden) << odd;
    $word root = 0u;
    $word sum = 0u;
    $word digit = $hidden << 1u;
    $real result = x;
    if ((x > $zero) && ${name}_finite$mark(x)) {
        int i;
        rest <<= 1u;
        for (i = 0; i < $steps; ++i) {
            const $word trial = sum + digit;
            if (trial <= rest) {
                sum = trial + digit;
                rest -= trial;
                root += digit;
            }
            rest <<= 1u;
            digit >>= 1u;
        }
        root += (rest != 0u) ? (root & 1u) : 0u;
        root = (root >> 1u) + (($word)half << ${digits}u) + $offset;
        result = ${name}_number$mark(root);
        result = (x < $smallest) ? (result * $down) : result;
    } else if ((x < $zero) || (x != x)) {
        result = ${name}_number$mark($not_a_number);
    } else {
        /* zero and infinity are their own roots */
    }
    return result;
}""",
}
HARDWARE = {  # by C's own library, which compilers turn into an instruction where a processor has one
    "sqrt": """static $real ${name}_sqrt$mark($real x)
{
    return sqrt$mark(x);
}""",
    "fma": """static $real ${name}_fma$mark($real x, $real y, $real z)
{
    return fma$mark(x, y, z);
}""",
}
NEEDS = {
    "finite": ("bits",),
    "defined": ("bits",),
    "fabs": ("bits", "number"),
    "copysign": ("bits", "number"),
    "trunc": ("fabs", "copysign"),
    "floor": ("trunc",),
    "sqrt": ("bits", "number", "finite"),
}


def primitive(prefix: str, real: Real, name: str, hardware: Collection[str] = ()) -> str:
    """The definition of a primitive of a format, of the processor's own where that is asked for."""
    bias = (1 << (real.bits - real.digits - 2)) - 1
    up = real.digits + 2 - real.digits % 2  # an even power of two, which leaves no subnormal number
    return Template(HARDWARE[name] if name in hardware else PRIMITIVES[name]).substitute(
        name=prefix,
        mark=real.mark,
        real=real.type,
        word=real.word,
        integer=real.signed,
        bias=bias,
        digits=real.digits,
        steps=real.digits + 2,
        offset=word_text((bias - 1) << real.digits),
        zero=real.literal(0.0),
        one=real.literal(1.0),
        whole=real.literal(2.0**real.digits),
        smallest=real.literal(2.0 ** (1 - bias)),
        up=real.literal(2.0**up),
        down=real.literal(2.0 ** -(up // 2)),
        sign=word_text(1 << (real.bits - 1)),
        hidden=word_text(1 << real.digits),
        mantissa=word_text((1 << real.digits) - 1),
        infinity=word_text(real.pattern(math.inf)),
        not_a_number=word_text(real.pattern(math.nan)),
    )


def word_text(value: int) -> str:
    """A word as C reads it: hexadecimal, but for a small one."""
    return f"{value if value < 4096 else hex(value)}u"
