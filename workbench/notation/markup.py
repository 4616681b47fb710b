"""The contract of a language for formulas, and the style of letters, words and numbers that all of them share."""

from __future__ import annotations

import re
import unicodedata
from abc import ABC, abstractmethod
from collections.abc import Sequence
from fractions import Fraction
from typing import ClassVar, Literal, TypeAlias

from workbench.notation.formula import GREEK, Symbol

# Between two factors: nothing, a thin space beside the name of a function, or a sign.
Space: TypeAlias = Literal["none", "thin", "dot"]
# A run of characters: a number, a slanted letter, a Greek letter by name, or an upright word.
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
HIDDEN = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})  # categories of Unicode


class AbstractMarkup(ABC):
    """A language for formulas: each method gives the text of one part from the texts of its own parts."""

    flat: ClassVar[bool]  # True if a formula is one line of characters, with its fractions and powers

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
        """The space or sign between two factors."""

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
        """Parentheses as tall as their content."""

    @abstractmethod
    def opening(self, function: str = "") -> str:
        """An opening parenthesis that is closed on another line, perhaps with the name of a function before it."""

    @abstractmethod
    def closing(self, exponent: str = "") -> str:
        """The closing parenthesis of `opening`, perhaps with a power."""

    @abstractmethod
    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        """A matrix in brackets."""

    @abstractmethod
    def cases(self, branches: Sequence[tuple[str, str]], otherwise: str) -> str:
        """Values beside their conditions."""


def style(text: str) -> Style:
    """The style of a letter or a word."""
    if text in GREEK:
        return "greek"
    if text.isdecimal() and text.isascii():
        return "number"
    return "letter" if len(text) == 1 and text.isalpha() else "word"


def runs(index: str) -> list[tuple[Style, str]]:
    """An index as runs of one style: `max,1` is a word, a comma and a number, `c1` a letter and a number."""
    if not re.fullmatch(r"[A-Za-z0-9,*]+", index):
        return [("word", visible(index))]
    return [(style(run), run) for run in re.findall(r"[A-Za-z]+|\d+|[,*]", index)]


def visible(text: str) -> str:
    """A name with a sign in the place of invisible characters: controls, directions, line ends, surrogates."""
    return "".join("\ufffd" if unicodedata.category(c) in HIDDEN else c for c in text)


def scientific(value: float) -> tuple[str, str]:
    """The digits and the power of ten of a number, as in 1.5 x 10^-5; no power for a plain decimal."""
    digits, _, exponent = repr(value).partition("e")
    return digits.removesuffix(".0"), str(int(exponent)) if exponent else ""
