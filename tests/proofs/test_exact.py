"""Exact rational arithmetic, against NumPy's eigenvalues and against polynomials with known roots."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.proofs.exact_arithmetic import characteristic_polynomial, exact_values, unstable_modes

whole = st.integers(-5, 5)


def fractions(A):
    return [[Fraction(int(value)) for value in row] for row in A]


@given(st.integers(1, 6).flatmap(lambda n: st.lists(st.lists(whole, min_size=n, max_size=n), min_size=n, max_size=n)))
def test_the_characteristic_polynomial_is_that_of_numpy(A):
    found = [float(c) for c in characteristic_polynomial(fractions(A))]
    np.testing.assert_allclose(found, np.poly(np.array(A, dtype=float)), atol=1e-6 * max(map(abs, found)))


@given(st.lists(st.integers(-4, 4).filter(bool), min_size=1, max_size=6))
def test_routh_counts_the_positive_roots_of_a_product(roots):
    polynomial = [Fraction(1)]
    for root in roots:
        polynomial = [a - root * b for a, b in zip([*polynomial, Fraction(0)], [Fraction(0), *polynomial], strict=True)]
    counted = unstable_modes(polynomial)
    assert counted is None or counted == sum(root > 0 for root in roots)


def test_routh_counts_a_growing_pair():
    assert unstable_modes([Fraction(1), Fraction(-1), Fraction(5)]) == 2  # s^2 - s + 5
    assert unstable_modes([Fraction(1), Fraction(1), Fraction(5)]) == 0


def test_a_mode_that_neither_grows_nor_decays_gives_no_answer():
    assert unstable_modes([Fraction(1), Fraction(0), Fraction(4)]) is None  # s^2 + 4
    assert unstable_modes([Fraction(1), Fraction(2), Fraction(0)]) is None  # s^2 + 2 s


def test_a_polynomial_without_a_highest_power_is_refused():
    with pytest.raises(ValueError, match="must have a highest power"):
        unstable_modes([Fraction(0), Fraction(1)])


def test_values_are_exact_where_floats_are_not():
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    ((value,),) = exact_values((x + y) / 3 - x / 3, {"x": Fraction(10**30), "y": Fraction(1)})
    assert value == Fraction(1, 3)


def test_a_double_counts_as_the_fraction_that_it_is():
    ((value,),) = exact_values(ca.SX(0.1), {})
    assert value == Fraction(0.1) != Fraction(1, 10)


def test_sine_and_cosine_are_known_at_zero_and_nowhere_else():
    x = ca.SX.sym("x")
    assert exact_values(ca.vertcat(ca.sin(x), ca.cos(x)), {"x": Fraction(0)}) == [[0], [1]]
    with pytest.raises(ValueError, match="no rational value of sin\\(1/2\\)"):
        exact_values(ca.sin(x), {"x": Fraction(1, 2)})


def test_a_division_by_zero_is_refused():
    x = ca.SX.sym("x")
    with pytest.raises(ValueError, match="no rational value of"):
        exact_values(1 / x, {"x": Fraction(0)})


def test_a_symbol_without_a_value_is_named():
    with pytest.raises(LookupError, match="must give 'x' a value"):
        exact_values(ca.SX.sym("x") + 1, {})
