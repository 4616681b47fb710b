"""Python's spelling: an operation as an expression of floats, truths, and whole numbers below 2^64."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping

WORD = 2**64

SPELLING: Mapping[str, str] = {
    "add": "{} + {}",
    "sub": "{} - {}",
    "mul": "{} * {}",
    "div": "divided({}, {})",
    "neg": "-{}",
    "fabs": "abs({})",
    "sqrt": "root({})",
    "floor": "floored({})",
    "trunc": "truncated({})",
    "copysign": "math.copysign({}, {})",
    "lt": "{} < {}",
    "le": "{} <= {}",
    "gt": "{} > {}",
    "ge": "{} >= {}",
    "eq": "{} == {}",
    "ne": "{} != {}",
    "and": "{} and {}",
    "or": "{} or {}",
    "not": "not {}",
    "nonzero": "{} != 0",
    "word_add": "({} + {}) % 2**64",
    "word_mul": "({} * {}) % 2**64",
    "word_and": "{} & {}",
    "word_or": "{} | {}",
    "word_xor": "{} ^ {}",
    "shl": "({} << {}) % 2**64",
    "lshr": "{} >> {}",
    "select": "{1} if {0} else {2}",
    "bits": "bits({})",
    "number": "number({})",
    "signed": "float(({} + 2**63) % 2**64 - 2**63)",
    "fma": "{} * {} + {}",
    "fms": "{} * {} - {}",
    "fnma": "{2} - {0} * {1}",
    "inv": "divided(1.0, {})",
    "if_else": "{1} if {0} else {2}",
    "barrier": "{}",
}
# Python raises an error where IEEE 754 has an infinity or NaN, and its floor and trunc are whole numbers without -0.
HELPERS: Mapping[str, str] = {
    "divided": """
    try:
        return x / y
    except ZeroDivisionError:
        return math.copysign(math.inf, x) * math.copysign(1.0, y) if x > 0.0 or x < 0.0 else math.nan""",
    "root": """
    return math.sqrt(x) if x >= 0.0 else math.nan""",
    "floored": """
    return math.copysign(float(math.floor(x)), x) if abs(x) < 2.0**52 else x""",
    "truncated": """
    return math.copysign(float(int(x)), x) if abs(x) < 2.0**52 else x""",
    "bits": """
    return struct.unpack("<Q", struct.pack("<d", x))[0]""",
    "number": """
    return struct.unpack("<d", struct.pack("<Q", x))[0]""",
}
OF_TWO = {"divided"}


def literal(value: float) -> str:
    """A double as Python reads it to the last bit."""
    if math.isfinite(value):
        return repr(float(value)) if math.copysign(1.0, value) > 0 else f"({value!r})"
    return "math.nan" if math.isnan(value) else "math.inf" if value > 0 else "(-math.inf)"


class PythonLines:
    """The machine that writes each operation as a line of Python, of floats, truths and whole numbers below 2^64."""

    fused_products = False

    def __init__(self, counts: Iterator[int] | None = None) -> None:
        self.lines: list[str] = []
        self.counts = itertools.count(1) if counts is None else counts  # of variables

    def do(self, operation: str, *operands: str) -> str:
        """One assignment; its variable."""
        return self.line(SPELLING[operation].format(*operands))

    def constant(self, value: float) -> str:
        """A float."""
        return literal(value)

    def word(self, value: int) -> str:
        """A whole number below 2^64."""
        return str(value % WORD)

    def line(self, text: str) -> str:
        """One assignment; its variable."""
        name = f"v{next(self.counts)}"
        self.lines.append(f"{name} = {text}")
        return name
