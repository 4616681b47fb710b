"""Checks of matrices of doubles in rational arithmetic, which no rounding can touch."""

from __future__ import annotations

from fractions import Fraction

from workbench.core.layout import Array
from workbench.proofs.exact_arithmetic import Matrix, characteristic_polynomial


def definite(S: Array) -> bool:
    """Whether a symmetric matrix is positive definite: all its leading minors are positive."""
    return _definite(_fractions(S))


def bears_mismatch(P: Array, A: Array, B: Array, rho: float) -> bool:
    """Whether P > 0 and A' P + P A + rho^2 I + P B B' P < 0, exactly.

    Then z' P z falls along z' = A z + B w for every w with |w| <= rho |z|.
    """
    p, a, b = (_fractions(part) for part in (P, A, B))
    pa, pb, square = _product(p, a), _product(p, b), Fraction(rho) ** 2
    rest, places = _product(pb, [list(column) for column in zip(*pb, strict=True)]), range(len(p))
    left = [[-(pa[i][j] + pa[j][i] + rest[i][j] + (square if i == j else 0)) for j in places] for i in places]
    return _definite(p) and _definite(left)


def _definite(rows: Matrix) -> bool:
    leading = ([row[:k] for row in rows[:k]] for k in range(1, len(rows) + 1))
    return all(characteristic_polynomial(block)[-1] * (-1) ** len(block) > 0 for block in leading)


def _fractions(S: Array) -> Matrix:
    return [[Fraction(float(value)) for value in row] for row in S]


def _product(a: Matrix, b: Matrix) -> Matrix:
    return [
        [sum((x * y for x, y in zip(row, column, strict=True)), Fraction(0)) for column in zip(*b, strict=True)]
        for row in a
    ]
