"""Matrices of whole numbers and fractions: what doubles are exactly, so that no tolerance decides a rank."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array
from workbench.design.frequency.integer_polynomials import Polynomial

Matrix = list[list[Fraction]]
Whole = NDArray[np.object_]


def whole(M: Array) -> tuple[Whole, int]:
    """A matrix of doubles as whole numbers over one power of two: M = numbers / denominator, exactly."""
    fractions = [Fraction(float(x)) for x in M.ravel()]
    denominator = max((f.denominator for f in fractions), default=1)
    numbers = np.array([f.numerator * (denominator // f.denominator) for f in fractions], dtype=object)
    return numbers.reshape(M.shape), denominator


def rational(M: Array) -> Matrix:
    """A matrix of doubles as the fractions that they are."""
    return [[Fraction(float(x)) for x in row] for row in M]


def transpose(M: Matrix, columns: int) -> Matrix:
    """The transpose of a matrix with so many columns, which a matrix without rows cannot tell."""
    return [[row[j] for row in M] for j in range(columns)]


def product(M: Matrix, N: Matrix, columns: int) -> Matrix:
    """The product M N; N has so many columns, which a matrix without rows cannot tell."""
    sparse = [[(j, b) for j, b in enumerate(row) if b] for row in N]
    result = []
    for row in M:
        total = [Fraction(0)] * columns
        for a, entries in zip(row, sparse, strict=True):
            if a:
                for j, b in entries:
                    total[j] += a * b
        result.append(total)
    return result


def echelon(M: Matrix, columns: int) -> tuple[Matrix, list[int]]:
    """The rows of M in reduced echelon form by its first columns, and the columns of their pivots.

    Rows that are zero in these columns stand last, combined with the others in the same way.
    """
    rows = [list(row) for row in M]
    pivots: list[int] = []
    for j in range(columns):
        at = len(pivots)
        candidates = [i for i in range(at, len(rows)) if rows[i][j]]
        if not candidates:
            continue
        best = min(candidates, key=lambda i: max(x.denominator * x.numerator for x in map(abs, rows[i])))
        rows[at], rows[best] = rows[best], rows[at]
        inverse = 1 / rows[at][j]
        rows[at] = [x * inverse for x in rows[at]]
        for i, row in enumerate(rows):
            if i != at and row[j]:
                factor = row[j]
                rows[i] = [x - factor * y if y else x for x, y in zip(row, rows[at], strict=True)]
        pivots.append(j)
    return rows, pivots


def integer_characteristic_polynomial(M: Whole) -> Polynomial:
    """The coefficients of det(s I - M), lowest power first, of a matrix of whole numbers (Faddeev and LeVerrier)."""
    n = len(M)
    coefficients, R = [1], np.array([[0] * n for _ in range(n)], dtype=object).reshape(n, n)
    for k in range(1, n + 1):
        for i in range(n):
            R[i, i] += coefficients[-1]
        R = M @ R
        coefficients.append(-sum(R[i, i] for i in range(n)) // k)
    return coefficients[::-1]


def rational_characteristic_polynomial(M: Matrix) -> Polynomial:
    """A whole multiple of det(s I - M), lowest power first."""
    denominator = int(np.lcm.reduce([1] + [x.denominator for row in M for x in row], dtype=object))
    n = len(M)
    numbers = np.array([[int(x * denominator) for x in row] for row in M], dtype=object).reshape(n, n)
    # det(q s I - q M): the coefficient of s^k gains q^k
    return [c * denominator**k for k, c in enumerate(integer_characteristic_polynomial(numbers))]


def markov_parameters(A: Whole, B: Whole, C: Whole, count: int) -> list[Whole]:
    """The matrices C A^k B, k < count, of whole numbers."""
    parameters, moved = [], B
    for _ in range(count):
        parameters.append(C @ moved)
        moved = A @ moved
    return parameters
