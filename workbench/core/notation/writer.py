"""A formula on one line: the signs and parentheses for every markup, and an estimate of the width on the page."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import assert_never

from workbench.core.notation.build import split_sign
from workbench.core.notation.formula import (
    GREEK,
    Call,
    Cases,
    Formula,
    Matrix,
    Number,
    Power,
    Product,
    Quotient,
    Relation,
    Sum,
    Symbol,
    System,
)
from workbench.core.notation.markup import Markup, Space

# The tightness of the parts of a formula: a part that is looser than its place demands gets parentheses.
LOOSE, SUM, PRODUCT, POWER, ATOM = range(5)

# Functions that need no parentheses before a lone symbol, and take a power as in sin^2 q.
BARE = {"sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "log"}

# A plus, minus or equals sign with the space round it; a pair of parentheses; a small space; the size of an index.
SIGN, PARENTHESES, THIN, SMALL = 2.5, 1.6, 0.4, 0.75

WIDE = {"m", "w", "M", "W", "omega"}


@dataclass(frozen=True)
class Writer:
    """Formulas in one markup."""

    markup: Markup

    def width(self, formula: Formula) -> float:
        """The width of a formula on one line, in characters or in widths of a digit."""
        return len(self.write(formula)) if self.markup.flat else measure(formula)

    @property
    def sign(self) -> float:
        """The width of a plus, minus or equals sign with the space round it."""
        return len(" + ") if self.markup.flat else SIGN

    def write(self, formula: Formula, least: int = LOOSE, *, last: bool = True) -> str:
        """A formula on one line, in parentheses if it binds more loosely than `least`.

        With `last` nothing follows that could be taken for a part of it: `sin q` needs no parentheses.
        """
        text, tightness = self._formula_text(formula, last)
        return self.markup.group.format(text) if tightness < least else text

    def factor(self, factors: tuple[Formula, ...], i: int, *, last: bool = True) -> str:
        """Factor number i of a product."""
        factor = factors[i]
        # In one line, a / b * c and a * (b / c) are different computations.
        least = POWER if self.markup.flat and i > 0 and isinstance(factor, Quotient | Number) else PRODUCT
        if i + 1 < len(factors):
            last = _is_call(factors[i + 1])
        return self.write(factor, least, last=last)

    def space(self, before: Formula, after: Formula) -> Space:
        """The space between two factors."""
        if _starts_with_digit(after):
            return "dot"
        return "thin" if _is_call(before) or _is_call(after) else "none"

    def _formula_text(self, formula: Formula, last: bool) -> tuple[str, int]:
        markup, flat = self.markup, self.markup.flat
        minus, size = split_sign(formula)
        if minus:
            return markup.row([markup.sign("-", unary=True), self.write(size, PRODUCT, last=last)]), SUM
        match size:
            case Number(Fraction() as value):
                return markup.number(value), ATOM if value.denominator == 1 else PRODUCT
            case Number(value):
                return markup.number(value), ATOM if flat or "e" not in repr(value) else PRODUCT
            case Symbol(mark=mark):
                return markup.symbol(size), POWER if mark and not flat else ATOM
            case Sum(terms):
                return self._sum(terms), SUM
            case Product(factors):
                return self._product(factors, last), PRODUCT
            case Quotient(numerator, denominator):
                above, below = (PRODUCT, POWER) if flat else (LOOSE, LOOSE)
                return markup.quotient.format(self.write(numerator, above), self.write(denominator, below)), PRODUCT
            case Power(base, exponent):
                return self._power(base, exponent, last), POWER
            case Call(function, arguments):
                text = self._call(function, arguments, "", last)
                return text, PRODUCT if self._bare(function, arguments) else ATOM
            case Matrix(rows):
                return markup.grid.write([[self.write(entry) for entry in row] for row in rows]), ATOM
            case Cases(branches, otherwise):
                pairs = [(self.write(value, SUM), self.write(when, SUM - 1)) for value, when in branches]
                return markup.cases(pairs, self.write(otherwise, SUM)), LOOSE
            case Relation(left, sign, right):
                return markup.row([self.write(left, SUM), markup.sign(sign), self.write(right, SUM)]), LOOSE
            case System(relations):
                return markup.row([self.write(relation) for relation in relations]), LOOSE
        assert_never(size)

    def _sum(self, terms: tuple[Formula, ...]) -> str:
        parts = [self.write(terms[0], SUM)]
        for term in terms[1:]:
            minus, size = split_sign(term)
            parts += [self.markup.sign("-" if minus else "+"), self.write(size, PRODUCT)]
        return self.markup.row(parts)

    def _product(self, factors: tuple[Formula, ...], last: bool) -> str:
        parts = [self.factor(factors, 0, last=last)]
        for i in range(1, len(factors)):
            space = self.markup.spaces[self.space(factors[i - 1], factors[i])]
            parts += [space, self.factor(factors, i, last=last)]
        return self.markup.row(parts)

    def _power(self, base: Formula, exponent: Formula, last: bool) -> str:
        if self.markup.flat:
            return self.markup.power.format(self.write(base, ATOM), self.write(exponent, ATOM))
        above = self.write(exponent)
        match base:
            case Symbol(mark=""):
                return self.markup.symbol(base, above)
            case Call(function, arguments) if function in BARE and _is_whole(exponent):
                return self._call(function, arguments, above, last)
        return self.markup.power.format(self.write(base, ATOM), above)

    def _call(self, function: str, arguments: tuple[Formula, ...], exponent: str, last: bool) -> str:
        texts = [self.write(argument) for argument in arguments]
        return self.markup.call(function, texts, exponent=exponent, bare=last and self._bare(function, arguments))

    def _bare(self, function: str, arguments: tuple[Formula, ...]) -> bool:
        return not self.markup.flat and function in BARE and isinstance(arguments[0], Symbol)


def _is_call(formula: Formula) -> bool:
    match formula:
        case Power(base, exponent):
            return isinstance(base, Call) and base.function in BARE and _is_whole(exponent)
        case Call(function):
            return function not in ("sqrt", "abs", "floor", "ceil")
    return False


def _is_whole(exponent: Formula) -> bool:
    """True for the exponents 2, 3, ...: sin^-1 q would be taken for the inverse function."""
    return isinstance(exponent, Number) and exponent.value > 1 and exponent.value == int(exponent.value)


def _starts_with_digit(factor: Formula) -> bool:
    """True if a factor would run together with a number before it."""
    match factor:
        case Number() | Power(Number()):
            return True
        case Product((first, *_)):
            return _starts_with_digit(first)
    return False


def measure(formula: Formula) -> float:
    """The width of an unbroken formula in widths of a digit (half an em): an estimate that errs upward."""
    minus, size = split_sign(formula)
    if minus:
        return SIGN + measure(size)
    match size:
        case Number(Fraction() as value):
            parts = str(abs(value)).split("/")
            return 0.5 * (len(parts) > 1) + max(map(len, parts))
        case Number(value):
            return len(repr(value))
        case Symbol(letter, index, mark=mark):
            width = 2.0 if letter in WIDE else 1.55 if letter[:1].isupper() else 1.15
            width = 1.1 * len(letter) if len(letter) > 1 and letter not in GREEK else width
            return width + SMALL * max(len(index), len(mark)) + 0.1
        case Sum(terms):
            return sum(SIGN * (i > 0) + measure(split_sign(term)[1]) for i, term in enumerate(terms))
        case Product(factors):
            inner = sum(measure(f) + PARENTHESES * isinstance(f, Sum | Cases | Relation) for f in factors)
            return inner + 2 * THIN * sum(isinstance(f.base if isinstance(f, Power) else f, Call) for f in factors)
        case Quotient(above, below):
            return 0.5 + max(measure(above), measure(below))
        case Power(base, exponent):
            loose = isinstance(base, Sum | Product | Quotient)
            return measure(base) + PARENTHESES * loose + SMALL * measure(exponent)
        case Call(function, arguments):
            bare = len(arguments) == 1 and isinstance(arguments[0], Symbol)
            return 0.9 * len(function) + (THIN if bare else PARENTHESES) + sum(map(measure, arguments)) + len(arguments)
        case Matrix(rows):
            columns = [max(map(measure, column)) for column in zip(*rows, strict=True)]
            return PARENTHESES + sum(2 + column for column in columns)
        case Cases(branches, otherwise):
            values = [measure(otherwise), *(measure(value) for value, _ in branches)]
            return PARENTHESES + 4 + max(values) + max(9.0, *(measure(c) for _, c in branches))
        case Relation(left, _, right):
            return measure(left) + 1.5 * SIGN + measure(right)
        case System(relations):
            return max(map(measure, relations))
