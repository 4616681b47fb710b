"""How wide a formula will be on the page, in widths of a digit: an estimate that errs upward."""

from __future__ import annotations

from fractions import Fraction

from workbench.notation.build import split_sign
from workbench.notation.formula import (
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

# A plus, minus or equals sign with the space round it; a pair of parentheses; a small space; the size of an index.
SIGN, PARENTHESES, THIN, SMALL = 2.5, 1.6, 0.4, 0.75

WIDE = {"m", "w", "M", "W", "omega"}


def measure(formula: Formula) -> float:
    """The width of a formula that is not broken, in widths of a digit (half an em)."""
    minus, size = split_sign(formula)
    if minus:
        return SIGN + measure(size)
    match size:
        case Number(value):
            return _number(value)
        case Symbol():
            return _symbol(size)
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


def _number(value: Fraction | float) -> float:
    if isinstance(value, Fraction):
        parts = [len(str(abs(value.numerator))), len(str(value.denominator)) if value.denominator > 1 else 0]
        return 0.5 * (value.denominator > 1) + max(parts)
    return len(repr(value))


def _symbol(symbol: Symbol) -> float:
    letter = 2.0 if symbol.letter in WIDE else 1.55 if symbol.letter[:1].isupper() else 1.15
    if len(symbol.letter) > 1 and symbol.letter not in GREEK:
        letter = 1.1 * len(symbol.letter)
    return letter + SMALL * max(len(symbol.index), len(symbol.mark)) + 0.1
