"""Elements of actuators and sensors against their closed forms."""

import casadi as ca
import control
import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_lyapunov

from tests.support.equipped_plants import behind
from workbench.blocks.plants import (
    FirstOrder,
    PadeDelay,
    RateLimit,
    Saturation,
)
from workbench.blocks.plants.elements import pade

VOLTS = st.floats(-100, 100)


def test_the_elements_of_one_signal_act_in_their_order():
    first, last = Saturation("v", -1, 1), FirstOrder("v", 0.1, start=2.0)
    for elements, want in (((first, last), 2.0), ((last, first), 1.0)):
        assert behind(elements, lambda t: 3.0 + 0 * t, 1e-3)[1][0] == want


def test_a_lag_of_first_order_answers_a_step_by_an_exponential():
    t, y = behind((FirstOrder("v", 0.1, start=-1.0),), lambda t: 2.0 + 0 * t, 1.0)
    np.testing.assert_allclose(y, 2 - 3 * np.exp(-t / 0.1), atol=1e-9)  # Runge-Kutta with h / T = 0.01


def test_a_rate_limit_makes_ramps_of_steps_and_ends_them_as_a_lag():
    low, high, T = -4.0, 2.0, 0.01
    for step, limit in ((1.0, high), (-1.0, low)):
        t, y = behind((RateLimit("v", low, high, T),), lambda t, step=step: step + 0 * t, 1.0, 1e-4)
        bend = (abs(step) - abs(limit) * T) / abs(limit)  # where (v - y) / T comes within the limits
        want = np.where(t < bend, limit * t, step - limit * T * np.exp(-np.maximum(t - bend, 0) / T))
        np.testing.assert_allclose(y, want, atol=1e-6)  # the step of Runge-Kutta over the bend


def test_a_rate_limit_leaves_a_slow_ramp_late_by_its_time_constant():
    t, y = behind((RateLimit("v", -2.0, 2.0, 0.01),), lambda t: 1.5 * t, 1.0)
    np.testing.assert_allclose(y[t > 0.5], 1.5 * (t[t > 0.5] - 0.01), rtol=1e-9)


@pytest.mark.parametrize("order", [1, 2, 3, 5, 12])
def test_the_realisation_of_the_pade_approximant_is_balanced(order):
    A, B, C, _ = pade(order)
    for M, b in ((A, B), (A.T, C)):
        # the solver of Bartels and Stewart leaves some roundings of |A| = 2 n^2
        np.testing.assert_allclose(solve_continuous_lyapunov(M, -np.outer(b, b)), np.eye(order), atol=1e-12)


def response(order, omega):
    A, B, C, D = pade(order)
    return C @ np.linalg.solve(1j * omega * np.eye(order) - A, B) + D


@pytest.mark.parametrize("order", [1, 2, 3, 6])
@pytest.mark.parametrize("omega", [0.1, 1.0, 7.0])
def test_it_is_the_pade_approximant_of_python_control(order, omega):
    numerator, denominator = control.pade(1.0, order)
    want = np.polyval(numerator, 1j * omega) / np.polyval(denominator, 1j * omega)
    assert response(order, omega) == pytest.approx(want, abs=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_its_phase_is_that_of_the_delay_to_the_order_of_the_approximant(order):
    errors = [np.angle(response(order, omega) * np.exp(1j * omega)) for omega in (0.8, 0.4)]
    assert abs(response(order, 0.8)) == pytest.approx(1.0, abs=1e-14)
    # the phase differs by a power 2n + 1 of omega; the next power is 5 % at 0.8
    assert errors[0] / errors[1] == pytest.approx(2 ** (2 * order + 1), rel=0.1)


@pytest.mark.parametrize("order", [1, 2, 3, 10, 50])
def test_its_phase_is_that_of_the_delay_up_to_its_order(order):
    omegas = np.linspace(0, order, 30)
    assert max(abs(np.angle(response(order, omega) * np.exp(1j * omega))) for omega in omegas) < 0.08


def test_a_wave_leaves_a_delay_as_it_came_in():
    t, y = behind((PadeDelay("v", 0.2, 6),), lambda t: ca.sin(5 * t), 6.0)
    late = t > 3.0  # the start has left
    # [6/6] differs by omega^13 / 1e14 at omega T = 1: what is left is Runge-Kutta, with h lambda of 0.1
    np.testing.assert_allclose(y[late], np.sin(5 * (t[late] - 0.2)), atol=1e-6)


@pytest.mark.parametrize("order", [1, 4])
def test_a_delay_that_is_full_of_its_signal_rests(order):
    _, y = behind((PadeDelay("v", 0.2, order, past=3.0),), lambda t: 3.0 + 0 * t, 0.5)
    np.testing.assert_allclose(y, 3.0, rtol=1e-13)


REFUSED = [
    (lambda: Saturation("v", 1.0, 1.0), r"`Saturation\(low=..., high=...\)` of 'v' must leave room .* got 1.0 and 1.0"),
    (lambda: RateLimit("v", 0.0, 1.0, 0.1), r"`RateLimit\(low=...\)` must be finite, with value < 0; got 0"),
    (lambda: RateLimit("v", -1.0, 1.0, 0.0), r"`RateLimit\(time_constant=...\)` must be finite, with 0 < value \[s\]"),
    (lambda: FirstOrder("v", 0.0), r"`FirstOrder\(time_constant=...\)` must be finite, with 0 < value \[s\]; got 0"),
    (lambda: PadeDelay("v", 0.1, 0), r"`PadeDelay\(order=...\)` must be a whole number from 1 to 50; got 0"),
    (lambda: PadeDelay("v", 0.0, 2), r"`PadeDelay\(time=...\)` must be finite, with 0 < value \[s\]; got 0"),
]


@pytest.mark.parametrize(("make", "says"), REFUSED)
def test_a_number_that_no_element_has_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()
