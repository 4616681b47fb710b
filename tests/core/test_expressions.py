"""A CasADi function at many points at once."""

import casadi as ca
import numpy as np
import pytest

from workbench.core.expressions import AT_ONCE, rows

X, P = ca.SX.sym("x", 2), ca.SX.sym("p")
PRODUCTS = ca.Function("products", [X, P], [ca.blockcat([[X[0] * P, 0], [X[1], X[0] * X[1]]])])


def test_each_point_gives_its_values_column_by_column():
    x, p = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]), np.array([[10.0], [20.0], [30.0]])
    # the matrix has a structural zero, which is a value like any other
    np.testing.assert_array_equal(rows(PRODUCTS, x, p), [[10, 2, 0, 2], [60, 4, 0, 12], [150, 6, 0, 30]])


def test_an_argument_of_one_row_serves_all_points():
    x = np.array([[1.0, 2.0], [3.0, 4.0]])
    both = np.array([[7.0], [7.0]])
    np.testing.assert_array_equal(rows(PRODUCTS, x, both[:1]), rows(PRODUCTS, x, both))


def test_no_points_give_no_rows_and_a_transposed_argument_is_read_as_it_looks():
    assert rows(PRODUCTS, np.zeros((0, 2)), np.zeros((0, 1))).shape == (0, 4)
    x = np.array([[1.0, 3.0], [2.0, 4.0]]).T
    np.testing.assert_array_equal(rows(PRODUCTS, x, np.ones((1, 1)))[1], [3, 4, 0, 12])


@pytest.mark.parametrize("n", [AT_ONCE - 1, AT_ONCE, AT_ONCE + 1, 3 * AT_ONCE])
def test_points_beyond_those_of_one_call_have_their_values_too(n):
    x = np.random.default_rng(0).random((n, 2))
    expected = np.column_stack([2 * x[:, 0], x[:, 1], np.zeros(n), x[:, 0] * x[:, 1]])
    np.testing.assert_array_equal(rows(PRODUCTS, x, np.array([[2.0]])), expected)


def test_arguments_of_unequal_lengths_are_refused():
    with pytest.raises(ValueError, match=r"takes arrays \(n, \[2, 1\]\), or of a single row; got shapes"):
        rows(PRODUCTS, np.zeros((3, 2)), np.zeros((2, 1)))
