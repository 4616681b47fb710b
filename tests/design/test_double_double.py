"""Products in twice the working precision against rational arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from workbench.design.riccati.double_double import Twice, twice

ERROR = Fraction(1, 2**103)  # 2^-106 of the largest term, some terms long


def rational(matrix):
    pair = twice(matrix)
    return [[Fraction(float(h)) + Fraction(float(low)) for h, low in zip(*rows, strict=True)]
            for rows in zip(pair.high, pair.low, strict=True)]  # fmt: skip


def product(A, B):
    return [[sum(x * y for x, y in zip(row, column, strict=True)) for column in zip(*B, strict=True)] for row in A]


@pytest.mark.parametrize("n", [1, 2, 3, 17, 40])
def test_a_product_has_twice_the_digits(n):
    rng = np.random.default_rng(n)
    A = rng.normal(size=(3, n)) * 10 ** rng.uniform(-12, 12, size=(3, n))
    B = rng.normal(size=(n, 4)) * 10 ** rng.uniform(-12, 12, size=(n, 4))
    wanted, got = product(rational(A), rational(B)), rational(twice(A) @ B)
    for i in range(3):
        for j in range(4):
            largest = Fraction(float(np.abs(A[i]).max())) * Fraction(float(np.abs(B[:, j]).max()))
            assert abs(got[i][j] - wanted[i][j]) <= n * ERROR * largest


def test_products_of_pairs_keep_their_digits_where_all_leading_ones_cancel():
    rng = np.random.default_rng(0)
    A, B = rng.normal(size=(4, 4)), rng.normal(size=(4, 4))
    left = twice(A) @ B
    rest = left @ A - twice(left.high) @ A  # what is left are the low parts alone
    wanted = product(rational(Twice(np.zeros((4, 4)), left.low)), rational(A))
    got = rational(rest)
    assert all(abs(got[i][j] - wanted[i][j]) <= 64 * ERROR for i in range(4) for j in range(4))


def test_sums_and_differences_lose_nothing_that_fits():
    x, y = Twice(np.array([[1.0]]), np.array([[2.0**-60]])), Twice(np.array([[-1.0]]), np.array([[2.0**-70]]))
    assert rational(x + y) == [[Fraction(1, 2**60) + Fraction(1, 2**70)]]
    assert rational(x - x) == [[0]]
    assert rational((-x).T) == [[-1 - Fraction(1, 2**60)]]


def test_a_matrix_of_zeros_is_a_product_of_zeros():
    np.testing.assert_array_equal((twice(np.zeros((2, 3))) @ np.ones((3, 2))).high, np.zeros((2, 2)))
