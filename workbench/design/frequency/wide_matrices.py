"""Matrices in twice the working precision with a bound of every rounding, so that what they say is proved.

A `Wide` is all matrices within `radius` of the sum high + low, entry by entry. Its product is split into slices whose
products are exact in any order of their sums, as in `riccati/double_double.py`; here what is left out is bounded, too.

References
----------
Rump (1999), INTLAB - INTerval LABoratory (matrices by midpoint and radius). Higham (2002), Accuracy and Stability of
Numerical Algorithms, 2nd ed., section 3.5: |fl(A B) - A B| <= k u / (1 - k u) |A| |B|, in any order of the sums.
Ozaki, Ogita, Oishi, Rump (2012), Error-free transformations of matrix multiplication, Numer. Algorithms 59.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.riccati.conditioning import Exponents
from workbench.design.riccati.double_double import DIGITS, TARGET_BITS, two_sum

U = 2.0**-53  # the relative rounding of one operation
TINY = 1e-290  # more than what all underflows of one product add up to


@dataclass(frozen=True, eq=False)
class Wide:
    """All matrices within `radius` of high + low, entry by entry."""

    high: Array
    low: Array
    radius: Array

    @staticmethod
    def of(matrix: Wide | Array) -> Wide:
        """A matrix of doubles, exactly."""
        return matrix if isinstance(matrix, Wide) else Wide(matrix, np.zeros_like(matrix), np.zeros_like(matrix))

    @property
    def size(self) -> Array:
        """An upper bound of the moduli of the entries."""
        return np.asarray((np.abs(self.high) + np.abs(self.low) + self.radius) * (1 + 8 * U))

    @property
    def middle(self) -> Wide:
        """The matrix high + low, exactly."""
        return Wide(self.high, self.low, np.zeros_like(self.high))

    @property
    def T(self) -> Wide:
        """The transposed matrix."""
        return Wide(self.high.T, self.low.T, self.radius.T)

    def scale(self, rows: Exponents | int, columns: Exponents | int) -> Wide:
        """The matrix with its rows and columns multiplied by powers of two, given by their exponents."""
        exponents = np.reshape(rows, (-1, 1)) + np.asarray(columns)
        return Wide(*(np.ldexp(part, exponents) for part in (self.high, self.low, self.radius)))

    def __getitem__(self, place: tuple[slice | Array, slice | Array]) -> Wide:
        return Wide(self.high[place], self.low[place], self.radius[place])

    def __neg__(self) -> Wide:
        return Wide(-self.high, -self.low, self.radius)

    def __add__(self, other: Wide | Array) -> Wide:
        y = Wide.of(other)
        total, error = two_sum(self.high, y.high)
        tails = self.low + y.low
        rest = error + tails
        lost = 2 * U * (np.abs(tails) + np.abs(rest))
        return Wide(*two_sum(total, rest), _up(self.radius + y.radius + lost, 4))

    def __sub__(self, other: Wide | Array) -> Wide:
        return self + (-Wide.of(other))

    def __matmul__(self, other: Wide | Array) -> Wide:
        y = Wide.of(other)
        inner = self.high.shape[1]
        total = _product(self.high, y.high)
        mixed = self.high @ y.low + self.low @ y.high
        size, other_size = np.abs(self.high), np.abs(y.high)
        first, second = size @ np.abs(y.low), np.abs(self.low) @ other_size
        lost = (inner + 4) * U * (first + second) + np.abs(self.low) @ np.abs(y.low)
        lost = lost + self.size @ y.radius + self.radius @ (y.size + y.radius)
        return Wide(total.high, total.low, _up(total.radius + lost, inner + 8)) + mixed


def bounded_product(A: Array, B: Wide | Array) -> tuple[Array, Array]:
    """A product in working precision, and a bound of its distance from the exact one."""
    y, inner = Wide.of(B), A.shape[1]
    first, size = A @ y.high, np.abs(A)
    lost = (inner + 2) * U * (size @ np.abs(y.high)) + size @ (np.abs(y.low) + y.radius)
    return np.asarray(first), _up(lost, inner + 8)


def stack(blocks: list[list[Wide]]) -> Wide:
    """The matrix of some blocks."""
    return Wide(*(np.block([[getattr(one, part) for one in row] for row in blocks]) for part in Wide.__match_args__))


def bounds_of_solution(inverse: Array, P: Wide, R: Wide) -> Array | None:
    """Upper bounds of the entries of P^-1 R, given an approximate inverse; None where P may be singular.

    With Q = |I - Z P| they are below any w > 0 with |Z R| + Q w < w.
    """
    product, radius = bounded_product(inverse, P)
    Q = np.abs(np.eye(len(product)) - product) * (1 + 2 * U) + radius
    first, radius = bounded_product(inverse, R)
    r = (np.abs(first) + radius) * (1 + 2 * U)
    if not (np.isfinite(Q).all() and np.isfinite(r).all()):
        return None
    try:
        w = 1.01 * np.linalg.solve(np.eye(len(Q)) - Q, r + 1e-20 * r.max(initial=0.0) + TINY)
    except np.linalg.LinAlgError:
        return None
    return w if (w > 0).all() and (_up(r + Q @ w, len(Q) + 8) < w).all() else None


def is_contraction(G: Array) -> bool:
    """True only if the spectral radius of a matrix of upper bounds, none negative, is below one.

    It is if a vector d > 0 has G d < d (Collatz and Wielandt).
    """
    n = len(G)
    if not np.isfinite(G).all():
        return False
    try:
        d = np.linalg.solve(np.eye(n) - G, np.ones(n))
    except np.linalg.LinAlgError:
        return False
    return bool((d > 0).all() and (_up(G @ d, n + 4) < d).all())


def is_positive_definite(S: Wide) -> bool:
    """True only if each symmetric matrix in S, of which the lower half is read, is positive definite.

    It is if the factorisation of Cholesky runs to its end after more than all its roundings have been taken from the
    diagonal.

    References
    ----------
    Rump (2006), Verification of positive definiteness, BIT Numerical Mathematics 46, theorem 2.3.
    """
    n, lower = len(S.high), np.tril(S.high)
    around = np.tril(np.abs(S.low) + S.radius)
    around = np.maximum(around, around.T)
    lost = float(around.sum(axis=1).max(initial=0.0)) + 4 * (n + 4) * U * float(np.abs(np.diag(lower)).sum())
    shifted = lower - float(_up(np.array(lost), n + 8)) * np.eye(n)
    try:
        np.linalg.cholesky(shifted)  # of the lower half
    except np.linalg.LinAlgError:
        return False
    return bool(np.isfinite(shifted).all())


def _up(bound: Array, operations: int) -> Array:
    """A bound that so many roundings cannot have made too small."""
    return np.asarray(bound * (1 + 4 * operations * U) + TINY)


def _product(A: Array, B: Array) -> Wide:
    """The product of two matrices of doubles."""
    inner = A.shape[1]
    bits = (DIGITS - int(np.ceil(np.log2(max(inner, 2))))) // 2
    left, right = _slices(A, bits), [(part.T, rest.T) for part, rest in _slices(B.T, bits)]
    total = Wide.of(np.zeros((len(A), B.shape[1])))
    for i, (part, _) in enumerate(left):
        count = min(len(right), -(-TARGET_BITS // bits) - i)
        for other, _ in right[:count]:
            total = total + part @ other  # exact: whole numbers that add up to less than 2^53
        rest = right[count - 1][1] if count > 0 else B
        total = Wide(total.high, total.low, total.radius + _up(np.abs(part) @ np.abs(rest), inner + 4))
    beyond = left[-1][1] if left else A
    return Wide(total.high, total.low, _up(total.radius + np.abs(beyond) @ np.abs(B), inner + 64))


def _slices(A: Array, bits: int) -> list[tuple[Array, Array]]:
    """Matrices that add up to A, each an integer up to 2^bits times one power of two a row; and what then is left."""
    slices: list[tuple[Array, Array]] = []
    rest = A
    while np.any(rest) and len(slices) * bits < TARGET_BITS:
        _, exponent = np.frexp(np.abs(rest).max(axis=1, keepdims=True))
        # adding and taking away 1.5 2^k rounds to the last digit of that number
        ruler = np.ldexp(0.75, exponent + DIGITS - bits)
        part = (rest + ruler) - ruler
        rest = rest - part
        slices.append((part, rest))
    return slices
