"""Exact rational arithmetic on expressions and matrices, for proofs without rounding."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

import casadi as ca

from workbench.core.notation import text
from workbench.core.notation.normal_form import NormalForm, NotInClass, normal_forms
from workbench.core.validation.signatures import check_arguments

Matrix = list[list[Fraction]]


@check_arguments
def exact_values(expression: ca.SX, values: Mapping[str, Fraction]) -> Matrix:
    """A matrix (n, m) of expressions at rational values of its symbols, with no rounding at all.

    Known are + - * /, squares, whole powers, and sin 0 = 0, cos 0 = 1; any other operation is refused by name. A
    constant of the expression counts as the fraction that its double exactly is.
    """
    for symbol in ca.symvar(expression):
        if symbol.name() not in values:
            raise LookupError(f"`exact_values(values=...)` must give '{symbol.name()}' a value; it has none.")
    try:
        return [[_number(form) for form in row] for row in normal_forms(expression, values)]
    except NotInClass as error:
        raise ValueError(f"`exact_values(expression)` knows no rational value of it: {error}") from None


def _number(form: NormalForm) -> Fraction:
    if form.number is None:
        raise ValueError(f"`exact_values(expression)` knows no rational value of {text.emit(form.to_formula())}.")
    return form.number


@check_arguments
def characteristic_polynomial(A: Matrix) -> list[Fraction]:
    """The coefficients of det(s I - A) of a square matrix, highest power first (Faddeev and LeVerrier)."""
    n = len(A)
    if any(len(row) != n for row in A):
        raise ValueError(f"`characteristic_polynomial(A)` must be square; got {n} rows of {sorted(set(map(len, A)))}.")
    coefficients, M = [Fraction(1)], [[Fraction(0)] * n for _ in range(n)]
    for k in range(1, n + 1):
        for i in range(n):
            M[i][i] += coefficients[-1]
        M = [[sum((A[i][l] * M[l][j] for l in range(n)), Fraction(0)) for j in range(n)] for i in range(n)]
        coefficients.append(-sum((M[i][i] for i in range(n)), Fraction(0)) / k)
    return coefficients


@check_arguments
def unstable_modes(polynomial: Sequence[Fraction]) -> int | None:
    """The number of roots with a positive real part, by Routh's array; None where the array is not regular.

    References
    ----------
    Gantmacher (1959), The Theory of Matrices, volume 2, chapter XV.
    """
    if not polynomial or not polynomial[0]:
        raise ValueError("`unstable_modes(polynomial)` must have a highest power; its coefficient is zero.")
    above, row = list(polynomial[0::2]), list(polynomial[1::2])
    first = [above[0]]
    for _ in range(len(polynomial) - 1):
        if not row or not row[0]:
            return None
        first.append(row[0])
        padded = row + [Fraction(0)] * (len(above) - len(row))
        below = [above[j + 1] - above[0] * padded[j + 1] / row[0] for j in range(len(above) - 1)]
        above, row = row, below
    return sum(a * b < 0 for a, b in pairwise(first))
