"""Exact rational arithmetic on expressions and matrices, for proofs without rounding."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

import casadi as ca

from workbench.notation.program import NAMES, Operation, walk
from workbench.validation.signatures import door

Matrix = list[list[Fraction]]

HIGHEST_POWER = 1000  # numbers of more than a million digits help nobody
LONGEST = 40  # digits of a number that a message shows


@door
def exact_values(expression: ca.SX, values: Mapping[str, Fraction]) -> Matrix:
    """A matrix (n, m) of expressions at rational values of its symbols, with no rounding at all.

    Known are + - * /, squares, whole powers, and sin 0 = 0, cos 0 = 1; any other operation is refused by name. A
    constant of the expression counts as the fraction that its double exactly is.
    """
    found = walk(expression)
    results: list[Fraction] = []
    for node in found.nodes:
        results.append(_value(node, [results[i] for i in node.operands], values))
    return [[results[place] for place in row] for row in found.entries]


def _value(node: Operation, of: Sequence[Fraction], values: Mapping[str, Fraction]) -> Fraction:
    if node.name:
        if node.name not in values:
            raise LookupError(f"`exact_values(values=...)` must give '{node.name}' a value; it has none.")
        return values[node.name]
    match NAMES[node.code], list(of):
        case "CONST", [] if math.isfinite(node.value):
            return Fraction(node.value)
        case "ADD", [a, b]:
            return a + b
        case "SUB", [a, b]:
            return a - b
        case "MUL", [a, b]:
            return a * b
        case "DIV", [a, b] if b:
            return a / b
        case "INV", [a] if a:
            return 1 / a
        case "NEG", [a]:
            return -a
        case "SQ", [a]:
            return a * a
        case "TWICE", [a]:
            return 2 * a
        case "POW" | "CONSTPOW", [a, b] if b.denominator == 1 and abs(b) <= HIGHEST_POWER and (a or b > 0):
            return a ** int(b)
        case "SIN", [a] if not a:
            return Fraction(0)
        case "COS", [a] if not a:
            return Fraction(1)
    shown = ", ".join(str(a) if max(abs(a.numerator), a.denominator) < 10**LONGEST else "a long fraction" for a in of)
    raise ValueError(f"`exact_values(expression)` knows no rational value of {NAMES[node.code]} at {shown}.")


@door
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


@door
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
