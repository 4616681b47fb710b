"""A language for formulas as a table of templates, and the style of letters, words and numbers that all share."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, TypeAlias

from workbench.core.notation.formula import GREEK, Symbol, name_of

# Between two factors: nothing, a thin space beside the name of a function, or a sign.
Space: TypeAlias = Literal["none", "thin", "dot"]
# A run of characters: a number, a slanted letter, a Greek letter by name, or an upright word.
Style: TypeAlias = Literal["number", "letter", "greek", "word"]

# Names of functions as they are printed, where that is not the name in the code.
PRINTED_FUNCTIONS = {"log": "ln", "asin": "arcsin", "acos": "arccos", "atan": "arctan"}
PRINTED_FUNCTIONS |= {"asinh": "arsinh", "acosh": "arcosh", "atanh": "artanh"}
# Functions for which LaTeX and Typst have a name of their own.
KNOWN_FUNCTIONS = {"sin", "cos", "tan", "sinh", "cosh", "tanh", "arcsin", "arccos", "arctan", "exp", "ln", "min", "max"}
DOTS = ("", "dot", "ddot")
HIDDEN_CATEGORIES = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})  # categories of Unicode


@dataclass(frozen=True)
class Grid:
    """Rows of cells: templates of a cell, of a row, and of the whole, which also takes a `c` for each column."""

    between: str
    below: str
    whole: str
    cell: str = "{}"
    row: str = "{}"

    def write(self, rows: Sequence[Sequence[str]]) -> str:
        """The text of rows of cells."""
        lines = [self.row.format(self.between.join(map(self.cell.format, row))) for row in rows]
        return self.whole.format(self.below.join(lines), "c" * len(rows[0]))


@dataclass(frozen=True, kw_only=True)
class Markup:
    """A language for formulas: templates of the text of each part, which take the texts of its own parts in order."""

    flat: bool = False  # True if a formula is one line of characters, with its fractions and powers
    letter: Callable[[str, bool], str]  # a letter, number or word, perhaps bold
    function: Callable[[str], str]
    signs: Mapping[str, str]  # where a sign is not written as itself
    before: str = "{}"  # a sign before a term, and one between two
    amid: str = "{}"
    spaces: Mapping[Space, str]
    between: str  # what stands between parts side by side, and round several of them
    several: str = "{}"
    digits: str = "{}"
    ten: str = ""  # a power of ten, from the sign and the digits of its exponent
    minus: str = "-"
    over: Mapping[str, str]  # accents and dots
    subscript: str = ""
    both: str = ""  # an index and a power
    marks: Mapping[str, str]  # signs in an index, and what stands between its parts
    apart: str = ""
    quotient: str
    power: str
    group: str  # parentheses as tall as their content; `opening` and `closing` stand on different lines
    opening_fence: str
    closing_fence: str
    applies: str = ""  # a sign between a function and its argument
    application: str = "{}{}"
    bare: str = ""  # a function and an argument without parentheses
    comma: str = ", "
    enclosures: Mapping[str, str]  # functions that are drawn round their argument
    grid: Grid
    case_grid: Grid  # values beside their conditions
    condition: str
    otherwise: str

    def number(self, value: Fraction | float) -> str:
        """A number that is not negative."""
        if self.flat:
            return str(value) if isinstance(value, Fraction) else repr(value)
        if isinstance(value, Fraction):
            above, below = self.digits.format(value.numerator), self.digits.format(value.denominator)
            return self.quotient.format(above, below) if value.denominator > 1 else above
        digits, exponent = scientific(value)
        power = self.ten.format(self.minus if exponent.startswith("-") else "", exponent.lstrip("-"))
        if exponent and digits == "1":
            return power
        plain = self.digits.format(digits)
        return self.row([plain, self.spaces["dot"], power]) if exponent else plain

    def symbol(self, symbol: Symbol, exponent: str = "") -> str:
        """A letter with its dots, accent and index, and its mark or a power."""
        if self.flat:
            return ascii(name_of(symbol))[1:-1]
        text = self.letter(symbol.letter, symbol.bold)
        for sign in filter(None, (symbol.accent, DOTS[symbol.dots])):
            text = self.over[sign].format(text)
        index, mark = self._index(symbol.index), exponent or self._index(symbol.mark)
        if index and mark:
            return self.both.format(text, index, mark)
        return self.subscript.format(text, index) if index else self.with_power(text, mark)

    def with_power(self, text: str, exponent: str) -> str:
        """A text with its power, if there is one."""
        return self.power.format(text, exponent) if exponent else text

    def sign(self, sign: str, *, unary: bool = False) -> str:
        """A plus or minus, or the sign of a relation."""
        return (self.before if unary else self.amid).format(self.signs.get(sign, sign))

    def row(self, parts: Iterable[str]) -> str:
        """Parts side by side."""
        return self._join([part for part in parts if part], self.between)

    def call(self, function: str, arguments: Sequence[str], *, exponent: str = "", bare: bool = False) -> str:
        """A function of its arguments, perhaps to a power; without parentheses if `bare`."""
        inner = self.comma.join(arguments)
        if function in self.enclosures:
            return self.enclosures[function].format(inner)
        name = self.with_power(self.function(function), exponent)
        return self.bare.format(name, inner) if bare else self.application.format(name, self.group.format(inner))

    def open_parenthesis(self, function: str = "") -> str:
        """An opening parenthesis that is closed on another line, perhaps with the name of a function before it."""
        return (self.function(function) + self.applies if function else "") + self.opening_fence

    def cases(self, branches: Sequence[tuple[str, str]], otherwise: str) -> str:
        """Values beside their conditions."""
        rows = [[value, self.condition.format(when)] for value, when in branches]
        return self.case_grid.write([*rows, [otherwise, self.otherwise] if self.otherwise else [otherwise]])

    def _index(self, index: str) -> str:
        parts = [self.marks.get(text) or self.letter(text, False) for _, text in runs(index)] if index else []
        return self._join(parts, self.apart) if parts else ""

    def _join(self, parts: Sequence[str], between: str) -> str:
        return parts[0] if len(parts) == 1 else self.several.format(between.join(parts))


def style(text: str) -> Style:
    """The style of a letter or a word."""
    if text in GREEK:
        return "greek"
    if text.isdecimal() and text.isascii():
        return "number"
    return "letter" if len(text) == 1 and text.isalpha() else "word"


def runs(index: str) -> list[tuple[Style, str]]:
    """An index as runs of one style: `max,1` is a word, a comma and a number, `c1` a letter and a number."""
    if not re.fullmatch(r"[A-Za-z0-9,*+]+", index):
        return [("word", visible(index))]
    return [(style(run), run) for run in re.findall(r"[A-Za-z]+|\d+|[,*+]", index)]


def visible(text: str) -> str:
    """A name with a sign in the place of invisible characters: controls, directions, line ends, surrogates."""
    return "".join("\ufffd" if unicodedata.category(c) in HIDDEN_CATEGORIES else c for c in text)


def scientific(value: float) -> tuple[str, str]:
    """The digits and the power of ten of a number, as in 1.5 x 10^-5; no power for a plain decimal."""
    digits, _, exponent = repr(value).partition("e")
    return digits.removesuffix(".0"), str(int(exponent)) if exponent else ""
