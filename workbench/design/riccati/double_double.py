"""Sums and products of matrices in twice the working precision, by error-free transformations.

A number is an unevaluated sum `high + low` of two floats. A product is split into slices so short that every product
of two slices is exact in any order of its sums: the digits are the same on every machine.

References
----------
Ozaki, Ogita, Oishi, Rump (2012), Error-free transformations of matrix multiplication, Numer. Algorithms 59.
Ogita, Rump, Oishi (2005), Accurate sum and dot product, SIAM J. Sci. Comput. 26, algorithm 3.1 (TwoSum).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array

DIGITS = 53  # of a float
TARGET_BITS = 106  # of a product, counted from the largest term of its row and column


@dataclass(frozen=True)
class Twice:
    """A matrix high + low."""

    high: Array
    low: Array

    @property
    def T(self) -> Twice:
        """The transposed matrix."""
        return Twice(self.high.T, self.low.T)

    def __neg__(self) -> Twice:
        return Twice(-self.high, -self.low)

    def __add__(self, other: Twice | Array) -> Twice:
        y = twice(other)
        total, error = two_sum(self.high, y.high)
        return Twice(*two_sum(total, error + (self.low + y.low)))

    def __sub__(self, other: Twice | Array) -> Twice:
        return self + (-twice(other))

    def __matmul__(self, other: Twice | Array) -> Twice:
        y = twice(other)
        # low times low lies beyond the digits that are kept
        return _product(self.high, y.high) + (self.high @ y.low + self.low @ y.high)


def twice(matrix: Twice | Array) -> Twice:
    """The matrix as a sum of two, the second zero if it has none."""
    return matrix if isinstance(matrix, Twice) else Twice(matrix, np.zeros_like(matrix))


def two_sum(a: Array, b: Array) -> tuple[Array, Array]:
    """The rounded sum a + b, and its exact rounding error (Knuth)."""
    total = a + b
    shadow = total - a
    return total, (a - (total - shadow)) + (b - shadow)


def _product(A: Array, B: Array) -> Twice:
    # n products of two integers below 2^bits add up to less than 2^53
    bits = (DIGITS - int(np.ceil(np.log2(max(A.shape[1], 2))))) // 2
    left, right = _slices(A, bits), [part.T for part in _slices(B.T, bits)]
    total = Twice(*(np.zeros((len(A), B.shape[1])) for _ in range(2)))
    pairs = [(i, j) for i in range(len(left)) for j in range(len(right)) if (i + j) * bits < TARGET_BITS]
    for i, j in sorted(pairs, key=sum):
        total = total + left[i] @ right[j]
    return total


def _slices(A: Array, bits: int) -> list[Array]:
    """Matrices that add up to A, each an integer below 2^bits times one power of two a row."""
    slices: list[Array] = []
    rest = A
    while np.any(rest) and len(slices) * bits < TARGET_BITS:
        _, exponent = np.frexp(np.abs(rest).max(axis=1, keepdims=True))
        # adding and taking away 1.5 2^k rounds to the last digit of that number
        ruler = np.ldexp(0.75, exponent + DIGITS - bits)
        part = (rest + ruler) - ruler
        slices.append(part)
        rest = rest - part
    return slices
