"""Formats of real numbers in C, and the words that hold their bits."""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np


class Real(NamedTuple):
    """A format of real numbers in C, and the words that hold their bits."""

    type: str
    word: str
    signed_word: str
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


def word_text(value: int) -> str:
    """A word as C reads it: hexadecimal, but for a small one."""
    return f"{value if value < 4096 else hex(value)}u"
