"""Matrices of whole numbers over one power of two: products, inverses and factors with as many digits as are asked."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.rational_matrices import Matrix, Whole


@dataclass(frozen=True, eq=False)
class FixedPoint:
    """The matrix `numbers` / 2^bits; a result is rounded down to these places."""

    numbers: Whole
    bits: int

    @staticmethod
    def of(rows: Matrix | Array, shape: tuple[int, int], bits: int) -> FixedPoint:
        """A matrix of fractions or doubles, rounded down."""
        entries = [math.floor(Fraction(x) * 2**bits) for row in rows for x in row]
        return FixedPoint(_whole(entries, shape), bits)

    @staticmethod
    def identity(n: int, bits: int) -> FixedPoint:
        """The identity matrix (n, n)."""
        return FixedPoint(_whole(((i == j) << bits for i in range(n) for j in range(n)), (n, n)), bits)

    @property
    def T(self) -> FixedPoint:
        """The transposed matrix."""
        return FixedPoint(self.numbers.T, self.bits)

    def __add__(self, other: FixedPoint) -> FixedPoint:
        return FixedPoint(self.numbers + other.numbers, self.bits)

    def __sub__(self, other: FixedPoint) -> FixedPoint:
        return FixedPoint(self.numbers - other.numbers, self.bits)

    def __matmul__(self, other: FixedPoint) -> FixedPoint:
        return FixedPoint((self.numbers @ other.numbers) >> self.bits, self.bits)

    def scale_by_power(self, exponent: int) -> FixedPoint:
        """The matrix times 2^exponent."""
        numbers = self.numbers << exponent if exponent >= 0 else self.numbers >> -exponent
        return FixedPoint(numbers, self.bits)

    def scale_columns(self, factors: Iterable[Fraction]) -> FixedPoint:
        """The matrix whose columns are multiplied by one factor each."""
        whole = _whole((math.floor(f * 2**self.bits) for f in factors), (1, self.numbers.shape[1]))
        return FixedPoint((self.numbers * whole) >> self.bits, self.bits)

    def largest(self) -> Fraction:
        """The largest modulus of an entry."""
        return Fraction(max((abs(int(x)) for x in self.numbers.ravel()), default=0), 2**self.bits)

    def doubles(self) -> Array:
        """The matrix in doubles, each entry rounded once."""
        unit = 2**self.bits
        entries = [int(x) / unit for x in self.numbers.ravel()]
        return np.array(entries, dtype=float).reshape(self.numbers.shape)

    def solve(self, right: FixedPoint) -> FixedPoint | None:
        """X with self X = right by elimination with row pivots, or None if a pivot is zero."""
        n, bits = len(self.numbers), self.bits
        rows = np.hstack([self.numbers, right.numbers])
        for j in range(n):
            best = max(range(j, n), key=lambda i: abs(rows[i, j]))
            if rows[best, j] == 0:
                return None
            rows[[j, best]] = rows[[best, j]]
            rows[j] = (rows[j] << bits) // rows[j, j]
            for i in range(n):
                if i != j and rows[i, j]:
                    rows[i] = rows[i] - ((rows[i, j] * rows[j]) >> bits)
        return FixedPoint(rows[:, n:], bits)

    def cholesky(self) -> FixedPoint | None:
        """The lower triangular L with L L' = self, or None if a pivot is not positive."""
        n, rest = len(self.numbers), self.numbers.copy()
        L = _whole([0] * (n * n), (n, n))
        for j in range(n):
            if rest[j, j] <= 0:
                return None
            root = math.isqrt(int(rest[j, j]) << self.bits)
            L[j:, j] = (rest[j:, j] << self.bits) // root
            column = L[j + 1 :, j]
            rest[j + 1 :, j + 1 :] -= np.multiply.outer(column, column) >> self.bits
        return FixedPoint(L, self.bits)

    def pivoted_triangle(self) -> tuple[FixedPoint, list[int]]:
        """R of a QR factorisation whose columns are chosen by their lengths, and the order of the columns."""
        n, bits = self.numbers.shape[1], self.bits
        rest, order = self.numbers.copy(), list(range(n))
        R = _whole([0] * (n * n), (n, n))
        for k in range(n):
            lengths = (rest[:, k:] ** 2).sum(axis=0)
            best = k + max(range(n - k), key=lambda j: lengths[j])
            for M in (rest, R):
                M[:, [k, best]] = M[:, [best, k]]
            order[k], order[best] = order[best], order[k]
            R[k, k] = root = math.isqrt(int(lengths[best - k]))
            if root == 0:
                break
            direction = (rest[:, k] << bits) // root
            R[k, k + 1 :] = (direction @ rest[:, k + 1 :]) >> bits
            rest[:, k + 1 :] -= np.multiply.outer(direction, R[k, k + 1 :]) >> bits
        return FixedPoint(R, bits), order


def _whole(entries: Iterable[int], shape: tuple[int, int]) -> Whole:
    numbers = np.empty(shape[0] * shape[1], dtype=object)
    numbers[:] = [int(x) for x in entries]
    return numbers.reshape(shape)
