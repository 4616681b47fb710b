"""The interval Newton operator: its bounds hold where the zero is known, and it refuses what it cannot bound."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.proofs.interval import NoBound
from workbench.proofs.newton_operator import NewtonOperator


def test_the_zero_of_a_square_is_within_the_radius_and_no_wider_box_holds_two():
    x = ca.SX.sym("x")
    operator = NewtonOperator.of(x**2 - 2, x, np.array([1.4142]), {})
    radius = operator.radius(0.5)
    assert radius is not None
    assert abs(1.4142 - np.sqrt(2.0)) <= radius < 2.2e-5  # the root is 1.36e-5 from there, and q is 0.36
    assert operator.radius(3.0) is None  # where the other root is in the box too


def test_a_box_smaller_than_the_distance_to_the_zero_proves_nothing():
    x = ca.SX.sym("x")
    operator = NewtonOperator.of(x**2 - 2, x, np.array([1.4]), {})
    assert operator.contraction(0.01) < 0.1
    assert operator.radius(0.01) is None  # the root is 0.0142 from there
    assert operator.radius(0.02) is not None


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-1, 1), min_size=9, max_size=9), st.lists(st.floats(-1, 1), min_size=3, max_size=3))
def test_the_exact_zero_of_a_linear_system_is_within_the_radius(entries, constants):
    A, b = np.reshape(entries, (3, 3)) + 4 * np.eye(3), np.array(constants)
    x = ca.SX.sym("x", 3)
    point = -np.linalg.solve(A, b)
    radius = NewtonOperator.of(ca.DM(A) @ x + ca.DM(b), x, point, {}).radius(1e-3 + 1.0)
    assert radius is not None
    assert max(abs(Fraction(c) - z) for c, z in zip(point.tolist(), _exact_zero(A, b), strict=True)) <= radius < 1e-14


def _exact_zero(A, b):
    """The solution of A x + b = 0 in rational numbers (Cramer)."""
    rows, right = [[Fraction(v) for v in row] for row in A.tolist()], [-Fraction(v) for v in b.tolist()]

    def determinant(m):
        return (
            m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
        )

    whole = determinant(rows)
    return [
        determinant([[r if k == j else v for k, v in enumerate(row)] for row, r in zip(rows, right, strict=True)])
        / whole
        for j in range(3)
    ]


def test_where_intervals_of_the_slope_are_too_wide_bounds_of_the_map_prove_a_zero():
    x = ca.SX.sym("x")
    f = x - 0.01 + 1e3 * (ca.sin(2 * x) - 2 * ca.sin(x) * ca.cos(x))  # it is x - 0.01
    operator = NewtonOperator.of(f, x, np.array([0.0]), {})
    assert operator.contraction(0.1) > 1
    assert operator.radius(0.1) is None
    assert operator.has_zero(0.1)
    assert not operator.has_zero(0.005)


def test_the_rounding_of_constants_in_y_times_df_is_within_the_contraction():
    x = ca.SX.sym("x", 2)
    A = np.array([[0.1, 0.3], [0.7, 2.3]])  # nearly singular: what is folded would be off by more than it is bounded
    operator = NewtonOperator.of(ca.DM(A) @ x, x, np.zeros(2), {})
    Y = np.linalg.inv(A)
    exact = [
        sum(abs((1 if i == j else 0) - sum(Fraction(Y[i, k]) * Fraction(A[k, j]) for k in range(2))) for j in range(2))
        for i in range(2)
    ]
    assert 0 < max(exact) <= Fraction(operator.contraction(1.0))


def test_numbers_of_other_symbols_are_not_rounded():
    x, a = ca.SX.sym("x"), ca.SX.sym("a")
    f = -((a - 1) - a + 0.5) * x  # it is x / 2; doubles make it -x / 2
    operator = NewtonOperator.of(f, x, np.zeros(1), {"a": 1e16})
    assert operator.contraction(1.0) >= 1  # as the slope is known to two units of 1e16 at best


@pytest.mark.parametrize(
    ("f", "message"),
    [
        (lambda x: ca.vertcat(x[0] - ca.sign(x[1]), x[1]), "without jumps; this one holds SIGN"),
        (lambda x: ca.vertcat(x[0] + x[1], 2 * x[0] + 2 * x[1]), "only where df/dx is regular"),
        (lambda x: ca.vertcat(ca.sqrt(x[0] - 1), x[1]), "only where df/dx is regular"),
        (lambda x: x[0] + x[1], "as many functions as unknowns; here 1 are for 2"),
        (lambda x: ca.vertcat(ca.erf(x[0]) + x[0], x[1]), "An interval of ERF is not known here"),
    ],
)
def test_what_has_no_operator_is_refused(f, message):
    x = ca.SX.sym("x", 2)
    with pytest.raises(NoBound, match=message):
        NewtonOperator.of(f(x), x, np.zeros(2), {})
