"""Elementary functions in C: the operations of every other machine, and the few for which C has a library."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from string import Template
from typing import Any, NamedTuple

import numpy as np

from workbench.simulate.kernel import elementary_functions as double_functions
from workbench.simulate.kernel.target_operations import Number

NUMBER, WORD, TRUTH = "number", "word", "truth"


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
        """A finite number as C reads it to the last bit."""
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
    return (x - x) == $zero;
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
NEEDS = {
    "fabs": ("bits", "number"),
    "copysign": ("bits", "number"),
    "trunc": ("fabs", "copysign"),
    "floor": ("trunc",),
    "sqrt": ("bits", "number", "finite"),
}
TEXTS = {
    **dict.fromkeys(("add", "word_add"), "{} + {}"),
    **dict.fromkeys(("mul", "word_mul"), "{} * {}"),
    "sub": "{} - {}",
    "div": "{} / {}",
    "neg": "-{}",
    "lt": "{} < {}",
    "le": "{} <= {}",
    "gt": "{} > {}",
    "ge": "{} >= {}",
    "eq": "{} == {}",
    "ne": "{} != {}",
    "and": "{} && {}",
    "or": "{} || {}",
    "not": "!{}",
    "nonzero": "{} != 0u",
    "select": "{} ? {} : {}",
    "word_and": "{} & {}",
    "word_or": "{} | {}",
    "word_xor": "{} ^ {}",
    "shl": "{} << {}",
    "lshr": "{} >> {}",
    "signed": "(REAL)(INTEGER){}",
}
ABOUT = {
    "sin": "The sine; not a number beyond 1e12 rad.",
    "cos": "The cosine; not a number beyond 1e12 rad.",
    "turn": "Sine and cosine of one angle; not a number beyond 1e12 rad.",
    "exp": "The exponential; zero below -708, infinite above 709.",
    "log": "The natural logarithm.",
    "tanh": "The hyperbolic tangent.",
    "atan2": "The angle of the point (x, y).",
    "fmod": "The remainder of x / y, with the sign of x.",
    "fmin": "The smaller number; of a number and what is none, the number.",
    "fmax": "The larger number; of a number and what is none, the number.",
    "sign": "1, -1, or x itself where it is zero.",
}
KINDS = dict.fromkeys(("lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not", "nonzero"), TRUTH)
KINDS |= dict.fromkeys(("bits", "word_add", "word_mul", "word_and", "word_or", "word_xor", "shl", "lshr"), WORD)


@dataclass(frozen=True, eq=False)
class Lines:
    """The machine that writes each operation as a line of C."""

    real: Real
    prefix: str
    calls: set[str]  # primitives
    lines: list[str] = field(default_factory=list)
    fused: bool = False

    def do(self, operation: str, *operands: str) -> str:
        """One operation; its variable."""
        if operation in PRIMITIVES:
            self.calls.add(operation)
            text = f"{self.prefix}_{operation}{self.real.mark}({', '.join(operands)})"
        else:
            text = TEXTS[operation].format(*operands).replace("REAL", self.real.type)
            text = text.replace("INTEGER", self.real.signed)
        kind = KINDS.get(operation, NUMBER)
        name = f"{'vwt'[(NUMBER, WORD, TRUTH).index(kind)]}{len(self.lines)}"
        type_ = {NUMBER: self.real.type, WORD: self.real.word, TRUTH: "bool"}[kind]
        self.lines.append(f"const {type_} {name} = {text};")
        return name

    def constant(self, value: float) -> str:
        """A number."""
        if not math.isfinite(value):
            self.calls.add("number")
            return f"{self.prefix}_number{self.real.mark}({word_text(self.real.pattern(value))})"
        text = self.real.literal(value)
        return f"({text})" if text.startswith("-") else text

    def word(self, value: int) -> str:
        """A whole number of so many bits."""
        return word_text(value % (1 << self.real.bits))


def word_text(value: int) -> str:
    """A word as C reads it: hexadecimal, but for a small one."""
    return f"{value if value < 4096 else hex(value)}u"


def arguments_of(name: str) -> tuple[str, ...]:
    """The arguments of an elementary function."""
    return {"atan2": ("y", "x"), "fmod": ("x", "y"), "fmin": ("a", "b"), "fmax": ("a", "b")}.get(name, ("x",))


def definitions(prefix: str, real: Real, functions: Sequence[str], primitives: Sequence[str] = ()) -> list[str]:
    """The definitions in C of elementary functions and primitives of a format, with all that they call, in order.

    "turn" is the pair of sine and cosine of one angle; "sin" and "cos" are one of the two.
    """
    calls = set(primitives)
    written = [_function(prefix, real, name, calls) for name in functions]
    order: list[str] = []

    def need(name: str) -> None:
        for other in NEEDS.get(name, ()):
            need(other)
        if name not in order:
            order.append(name)

    for name in PRIMITIVES:
        if name in calls:
            need(name)
    return [*(_primitive(prefix, real, name) for name in order), *written]


def _primitive(prefix: str, real: Real, name: str) -> str:
    bias = (1 << (real.bits - real.digits - 2)) - 1
    up = real.digits + 2 - real.digits % 2  # an even power of two, which leaves no subnormal number
    return Template(PRIMITIVES[name]).substitute(
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
        not_a_number=word_text(real.pattern(math.nan)),
    )


def functions_of(real: Real) -> Mapping[str, Callable[..., Any]]:
    """The elementary functions of a format over the operations of a machine."""
    if real is SINGLE:
        raise ValueError("There is no single precision yet.")
    f = double_functions
    return {
        "exp": f.exponential,
        "tanh": f.hyperbolic_tangent,
        "log": f.logarithm,
        "atan2": f.arc_tangent,
        "fmod": f.remainder,
        "fmin": f.smaller,
        "fmax": f.larger,
        "sign": f.sign,
        "angle": f.reduce_angle,
        "sine_or_cosine": f.sine_or_cosine,
    }


def _function(prefix: str, real: Real, name: str, calls: set[str]) -> str:
    machine, functions = Lines(real, prefix, calls), functions_of(real)
    names = arguments_of(name)
    given = [Number(machine, argument) for argument in names]
    returns = real.type
    if name in ("sin", "cos", "turn"):
        angle = functions["angle"](*given)
        quarters = {"sin": (0,), "cos": (1,), "turn": (0, 1)}[name]
        results = [functions["sine_or_cosine"](angle, quarter).value for quarter in quarters]
    else:
        results = [functions[name](*given).value]
    ends = [f"return {results[0]};"]
    if name == "turn":
        returns = f"{prefix}_pair{real.mark}"
        ends = [f"pair.sine = {results[0]};", f"pair.cosine = {results[1]};", "return pair;"]
        machine.lines.insert(0, f"{returns} pair;")
    lines = [f"    {line}" for line in [*machine.lines, *ends]]
    arguments = ", ".join(f"{real.type} {argument}" for argument in names)
    head = [f"typedef struct {{ {real.type} sine; {real.type} cosine; }} {returns};", ""] if name == "turn" else []
    head += [f"/* {ABOUT[name]} */"]
    return "\n".join([*head, f"static {returns} {prefix}_{name}{real.mark}({arguments})", "{", *lines, "}"])
