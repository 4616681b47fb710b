"""What a language for formulas must be able to say."""

from __future__ import annotations

import re
import unicodedata
from abc import ABC, abstractmethod
from collections.abc import Sequence
from fractions import Fraction
from typing import ClassVar, Literal, TypeAlias

from workbench.notation.formula import GREEK, Symbol

# Between two factors: nothing to be seen, a thin space beside the name of a function, or a sign.
Space: TypeAlias = Literal["none", "thin", "dot"]
# How a run of characters is set: a number, a slanted letter, a Greek letter by name, or upright words.
Style: TypeAlias = Literal["number", "letter", "greek", "word"]

# Names of functions as they are printed, where that is not the name in the code.
PRINTED = {
    "log": "ln",
    "asin": "arcsin",
    "acos": "arccos",
    "atan": "arctan",
    "asinh": "arsinh",
    "acosh": "arcosh",
    "atanh": "artanh",
}
# Functions for which LaTeX and Typst have a name of their own.
KNOWN = {"sin", "cos", "tan", "sinh", "cosh", "tanh", "arcsin", "arccos", "arctan", "exp", "ln", "min", "max"}


class AbstractMarkup(ABC):
    """A language for formulas: how each part is written, given its own parts already written."""

    # In a flat language a formula is one line of characters, fractions and powers too.
    flat: ClassVar[bool]
    # Whether the entries of a matrix that is too wide become equations of their own.
    names_entries: ClassVar[bool]

    @abstractmethod
    def number(self, value: Fraction | float) -> str:
        """A number that is not negative."""

    @abstractmethod
    def symbol(self, symbol: Symbol, exponent: str = "") -> str:
        """A letter with its dots, accent and index, and its mark or a power."""

    @abstractmethod
    def sign(self, sign: str, *, unary: bool = False) -> str:
        """A plus or minus, or the sign of a relation."""

    @abstractmethod
    def times(self, space: Space) -> str:
        """What stands between two factors."""

    @abstractmethod
    def row(self, parts: Sequence[str]) -> str:
        """Parts side by side."""

    @abstractmethod
    def quotient(self, numerator: str, denominator: str) -> str:
        """A fraction."""

    @abstractmethod
    def power(self, base: str, exponent: str) -> str:
        """A power."""

    @abstractmethod
    def call(self, function: str, arguments: Sequence[str], *, exponent: str = "", bare: bool = False) -> str:
        """A function of its arguments, perhaps to a power; without parentheses if `bare`."""

    @abstractmethod
    def group(self, inner: str) -> str:
        """Parentheses, as tall as what they hold."""

    @abstractmethod
    def opening(self, function: str = "") -> str:
        """A parenthesis that is closed on another line, behind the name of a function perhaps."""

    @abstractmethod
    def closing(self, exponent: str = "") -> str:
        """Its partner, perhaps with a power to which the parentheses are raised."""

    @abstractmethod
    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        """A matrix in brackets."""

    @abstractmethod
    def cases(self, branches: Sequence[tuple[str, str]], otherwise: str) -> str:
        """Values beside their conditions."""


def style(text: str) -> Style:
    """How a letter or a word is set."""
    if text in GREEK:
        return "greek"
    if text.isdecimal() and text.isascii():
        return "number"
    return "letter" if len(text) == 1 and text.isalpha() else "word"


def runs(index: str) -> list[tuple[Style, str]]:
    """An index as runs that are set alike: `max,1` is a word, a comma and a number, `c1` a letter and a number."""
    if not re.fullmatch(r"[A-Za-z0-9,*]+", index):
        return [("word", visible(index))]
    return [(style(run), run) for run in re.findall(r"[A-Za-z]+|\d+|[,*]", index)]


def visible(text: str) -> str:
    """A name without the characters that are not there to be seen: controls, directions, line ends, lone halves."""
    return "".join("\ufffd" if unicodedata.category(c) in HIDDEN else c for c in text)


HIDDEN = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})


def scientific(value: float) -> tuple[str, str]:
    """The digits and the power of ten of a number, as in 1.5 x 10^-5; no power for a plain decimal."""
    digits, _, exponent = repr(value).partition("e")
    return digits.removesuffix(".0"), str(int(exponent)) if exponent else ""
