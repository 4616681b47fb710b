r"""The normal form of polynomials in symbols, sines and cosines: equal expressions have equal ones.

An expression of the class is a finite sum of

    rational coefficient  x  symbols to whole powers  x  1, or sin or cos of a polynomial angle.

Products of sines and cosines become sums, and doubles the fractions that they exactly are. Then two expressions are
equal for all values of their symbols (where no divisor is zero) if and only if their normal forms are the same, as
exp(i a) for different angles a are linearly independent: over the rational functions if the angles differ by more than
a constant, and over the rational numbers if they differ by a rational one.

References
----------
Lindemann and Weierstrass: Baker (1975), Transcendental Number Theory, theorem 1.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

import casadi as ca

from workbench.core.notation import textbook
from workbench.core.notation import trigonometric_sums as waves
from workbench.core.notation.formula import Formula, Matrix, Symbol, symbols_of
from workbench.core.notation.program import NAMES, ExpressionNode, walk
from workbench.core.notation.trigonometric_sums import NotInClass as NotInClass
from workbench.core.notation.trigonometric_sums import Terms
from workbench.core.validation.signatures import check_arguments

# Beyond so many terms in all an expansion would take minutes; it is given up.
MOST_TERMS = 200_000
MOST_ENTRIES = 10_000  # of a matrix


@dataclass(frozen=True)
class NormalForm:
    """One expression in normal form: its coefficients, keyed by monomial and sine or cosine.

    Symbols are known by their names. Two forms are equal (`==`) if and only if the expressions are.
    """

    terms: Terms

    @staticmethod
    def of(expression: ca.SX) -> NormalForm:
        """The normal form of one expression; `NotInClass` if it is not of the class, or expands to too many terms."""
        if (shape := ca.SX(expression).shape) != (1, 1):
            raise ValueError(
                f"`NormalForm.of(expression)` takes one expression; got shape {shape}: see `normal_forms`."
            )
        return normal_forms(expression)[0][0]

    @property
    def is_zero(self) -> bool:
        """True if the expression is zero identically: a proof, by exact arithmetic."""
        return not self.terms

    @property
    def number(self) -> Fraction | None:
        """The rational number that the form equals; None if it equals none."""
        return None if self.terms.keys() - {waves.UNIT} else self.terms.get(waves.UNIT, Fraction(0))

    def __add__(self, other: NormalForm) -> NormalForm:
        return NormalForm(waves.add(self.terms, other.terms))

    def __sub__(self, other: NormalForm) -> NormalForm:
        return NormalForm(waves.add(self.terms, other.terms, -1))

    def __mul__(self, other: NormalForm) -> NormalForm:
        return NormalForm(waves.multiply(self.terms, other.terms))

    def __truediv__(self, other: NormalForm) -> NormalForm:
        return NormalForm(waves.multiply(self.terms, waves.inverse(other.terms)))

    def __pow__(self, exponent: float) -> NormalForm:
        return NormalForm(waves.power(self.terms, waves.constant(Fraction(exponent))))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the symbols that are left, in alphabetical order."""
        found = {name for monomial, (_, angle) in self.terms for name, _ in monomial}
        found |= {name for _, (_, angle) in self.terms for monomial, _ in angle for name, _ in monomial}
        return tuple(sorted(found))

    def to_casadi(self, symbols: Mapping[str, ca.SX]) -> ca.SX:
        """The expression again, expanded, in the given CasADi symbols (by name)."""

        def power(monomial: waves.Monomial) -> ca.SX:
            return math.prod((symbols[name] ** exponent for name, exponent in monomial), start=ca.SX(1))

        total = ca.SX(0)
        for (monomial, (kind, angle)), coefficient in sorted(self.terms.items()):
            argument = sum((float(c) * power(m) for m, c in angle), ca.SX(0))
            wave = ca.cos(argument) if kind == "cos" else ca.sin(argument)
            total += float(coefficient) * power(monomial) * wave
        return total

    def to_formula(self, symbols: Mapping[str, Symbol] | None = None) -> Formula:
        """The formula that a textbook would print, the same in every process."""
        return textbook.textbook_form(self.terms, symbols_of(self.names, symbols))


@check_arguments
def normal_forms(
    matrix: ca.SX, numbers: Mapping[str, Fraction] | None = None, constant: Callable[[float], Fraction] = Fraction
) -> list[list[NormalForm]]:
    """The normal form of each entry of a matrix, row by row, with `numbers` in the place of some symbols.

    `constant` gives the fraction for a constant of the expression; `NotInClass` names what has no normal form.
    """
    if matrix.numel() > MOST_ENTRIES:
        raise NotInClass(f"A matrix of {matrix.numel()} entries is not expanded; {MOST_ENTRIES} are the most.")
    try:
        steps = walk(matrix)
    except ValueError as error:
        raise NotInClass(str(error)) from error
    known: list[Terms] = []
    work = 0
    for node in steps.nodes:
        operands = [known[i] for i in node.operands]
        sizes = [len(terms) for terms in operands]
        work += sizes[0] * sizes[-1] if node.code in PRODUCTS else sum(sizes)
        if work > MOST_TERMS:
            raise NotInClass(f"The normal form takes more than {MOST_TERMS} terms on the way: too long to expand.")
        fixed = numbers.get(node.name) if numbers else None
        known.append(_terms(node, operands, constant) if fixed is None else waves.constant(fixed))
    return [[NormalForm(known[place]) for place in row] for row in steps.entries]


@check_arguments
def to_formula(expression: ca.SX, symbols: Mapping[str, Symbol] | None = None) -> Formula:
    """The textbook form of an expression, or of a matrix of them; `NotInClass` if one has no normal form."""
    forms = normal_forms(expression)
    symbols_of({name for row in forms for form in row for name in form.names}, symbols)
    rows = tuple(tuple(form.to_formula(symbols) for form in row) for row in forms)
    return rows[0][0] if len(rows) == len(rows[0]) == 1 else Matrix(rows)


def _terms(node: ExpressionNode, operands: list[Terms], constant: Callable[[float], Fraction]) -> Terms:
    if node.code == ca.OP_CONST:
        if not math.isfinite(node.value):
            raise NotInClass(f"A normal form has finite coefficients; the expression holds {node.value}.")
        return waves.constant(constant(node.value))
    if node.code == ca.OP_INPUT:
        return waves.variable(node.name)
    if node.code not in RULES:
        raise NotInClass(f"{NAMES.get(node.code, node.code)} has no normal form: the class knows + - * / sin cos.")
    return RULES[node.code](*operands)


PRODUCTS = {ca.OP_MUL, ca.OP_SQ, ca.OP_DIV}
RULES: dict[int, Callable[..., Terms]] = {
    ca.OP_ASSIGN: lambda x: x,
    ca.OP_ADD: waves.add,
    ca.OP_SUB: lambda x, y: waves.add(x, y, -1),
    ca.OP_MUL: waves.multiply,
    ca.OP_DIV: lambda x, y: waves.multiply(x, waves.inverse(y)),
    ca.OP_NEG: lambda x: waves.scale(x, Fraction(-1)),
    ca.OP_TWICE: lambda x: waves.scale(x, Fraction(2)),
    ca.OP_SQ: lambda x: waves.multiply(x, x),
    ca.OP_INV: waves.inverse,
    ca.OP_POW: waves.power,
    ca.OP_CONSTPOW: waves.power,
    ca.OP_SIN: partial(waves.wave, "sin"),
    ca.OP_COS: partial(waves.wave, "cos"),
}
