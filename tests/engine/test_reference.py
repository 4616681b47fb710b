"""The reference mode: closed forms with jumps, corners and sliding; its own error estimate; every refusal by name."""

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

from tests.support.equations import decay, explosion, oscillator, root
from tests.support.reference_runs import equation, run, times_of
from workbench.arms.laws import AosmcRgs
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines
from workbench.core import rk4
from workbench.engine import simulate
from workbench.engine.reference import reference_of_function, reference_run

# The runs below are asked for 1e-10, and what is handed back is closer by far; a factor is what an equation magnifies.
EXACT = 1e-10


# Smooth equations


@pytest.mark.parametrize("tol", [1e-4, 1e-7, 1e-10])
def test_smooth_equations_follow_their_closed_forms_at_each_tolerance(tol):
    turning = reference_run(oscillator(), times=[1.0, 5.0, 20.0], rtol=tol, atol=tol)
    growing = run(lambda t, x: [x[0] * ca.cos(t)], [1.0], 20.0, rtol=tol, atol=tol)
    logistic = run(lambda t, x: [x[0] * (1 - x[0])], [0.1], 10.0, rtol=tol, atol=tol)
    # an oscillation adds its errors up, once a radian: 40 of them
    np.testing.assert_allclose(turning.x[:, 0], np.cos(2 * turning.t), atol=40 * tol)
    np.testing.assert_allclose(growing.x[:, 0], np.exp(np.sin(growing.t)), atol=10 * tol)
    np.testing.assert_allclose(logistic.x[:, 0], 1 / (1 + 9 * np.exp(-logistic.t)), atol=10 * tol)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_the_error_estimate_is_above_the_error(method):
    result = reference_run(oscillator(), times=[1.0, 5.0], rtol=1e-6, atol=1e-8, method=method)
    error = np.abs(result.x[:, 0] - np.cos(2 * result.t))
    assert (error < result.error[:, 0]).all()
    assert (result.error < 1e-3).all()
    assert result.method == method


def test_a_stiff_equation_is_left_to_the_implicit_method():
    # Prothero and Robinson: x' = -L (x - cos t); beyond the transient x = (L^2 cos t + L sin t) / (1 + L^2)
    L = 1e6
    result = run(lambda t, x: [-L * (x[0] - ca.cos(t))], [0.0], 3.0, count=4)
    t = result.t[1:]
    np.testing.assert_allclose(result.x[1:, 0], (L**2 * np.cos(t) + L * np.sin(t)) / (1 + L**2), atol=EXACT)
    assert result.method == "implicit"
    assert result.steps < 2000  # an explicit method needs 3 L / 6 of them
    assert reference_run(oscillator(), times=[1.0]).method == "explicit"


def test_a_plain_function_gives_what_its_equation_gives():
    plain = reference_of_function(lambda t, x: [x[1], -np.sin(x[0])], [3.0, 0.0], times=[0.0, 2.0, 4.0])
    result = reference_run(equation(lambda t, x: [x[1], -ca.sin(x[0])], [3.0, 0.0]), times=[0.0, 2.0, 4.0])
    np.testing.assert_allclose(plain.x, result.x, atol=10 * EXACT)  # started near the top, where errors grow
    np.testing.assert_array_equal(plain.x[0], [3.0, 0.0])
    stiff = reference_of_function(lambda t, x: -1e4 * x, [1.0], times=[1.0], method="implicit")
    np.testing.assert_allclose(stiff.x, 0.0, atol=EXACT)


def test_the_initial_time_alone_is_answered_with_the_initial_state():
    np.testing.assert_array_equal(reference_run(decay(), times=[0.0]).x, [[1.0]])
    np.testing.assert_array_equal(reference_of_function(lambda t, x: -x, [2.0], times=[0.0]).x, [[2.0]])


def test_parameters_and_initial_states_are_those_given():
    ode = decay()
    result = reference_run(ode, ode.parameters.pack({"rate": 0.5})[0], np.array([4.0]), times=[2.0])
    np.testing.assert_allclose(result.x[0, 0], 4 * np.exp(-1.0), rtol=EXACT)


# Corners and other switches


def test_corners_are_located_and_crossed():
    result = run(lambda t, x: [1.0, ca.fabs(x[0]), ca.fmax(-0.5, ca.fmin(x[0], 0.25))], [-1.0, 0.0, 0.0], 2.0)
    t, y = result.t, result.t - 1
    saturated = np.where(y < -0.5, -0.5 * t, np.where(y < 0.25, -0.375 + y**2 / 2, -0.375 - 0.03125 + 0.25 * y))
    np.testing.assert_allclose(result.x[:, 1], 0.5 + np.sign(y) * y**2 / 2, atol=1e-14)
    np.testing.assert_allclose(result.x[:, 2], saturated, atol=1e-14)
    np.testing.assert_allclose(times_of(result, "crosses"), [0.5, 1.0, 1.25], atol=1e-14)


def test_a_boundary_layer_is_entered_at_its_edge_and_ends_linear():
    lam, k, phi = 6.0, 5.0, 0.1
    result = run(lambda t, x: [x[1], -lam * x[1] - k * ca.fmax(-1, ca.fmin(1, (lam * x[0] + x[1]) / phi))], [1, 0.5], 3)
    T = (6.5 - phi) / k
    (event,) = result.events
    assert event.t == pytest.approx(T, abs=1e-13)
    a = (6.5 + k / lam) / lam
    e = (1 - a) * np.exp(-lam * T) + a - k * T / lam
    inside = np.array([[0, 1], [-k * lam / phi, -lam - k / phi]])
    expected = [expm(inside * (t - T)) @ [e, phi - lam * e] for t in result.t if t > T]
    np.testing.assert_allclose(result.x[result.t > T], expected, atol=10 * EXACT)


@pytest.mark.heavy
@pytest.mark.parametrize("phi", [1e-5])
def test_a_thin_boundary_layer_is_entered_and_followed(phi):
    result = run(lambda t, x: [x[1], -6 * x[1] - 5 * ca.fmax(-1, ca.fmin(1, (6 * x[0] + x[1]) / phi))], [1, 0], 1.5, 2)
    # s = 6 e + e' falls at the rate 5 to phi, and inside decays as exp(-5 t / phi); e' = -6 e + s
    T = (6 - phi) / 5
    e = (1 - 41 / 36) * np.exp(-6 * T) + 41 / 36 - 5 * T / 6
    inside = e + phi / (5 / phi - 6)
    np.testing.assert_allclose(result.x[1:, 0], inside * np.exp(-6 * (result.t[1:] - T)), atol=EXACT)


def test_a_staircase_is_climbed_step_by_step_and_slid_along_where_the_rate_holds_it():
    up = run(lambda t, x: [1.0, ca.floor(3 * x[0]), ca.ceil(3 * x[0])], [0.0, 0.0, 0.0], 3.0)
    assert up.x[-1, 1] == pytest.approx(sum(range(9)) / 3, abs=1e-13)
    assert up.x[-1, 2] == pytest.approx(sum(range(1, 10)) / 3, abs=1e-13)
    held = run(lambda t, x: [0.45 - 0.1 * ca.floor(x[0] / 0.1)], [0.0], 8.0)  # 0.45 above, 0.05; below 0.5 it rises
    assert held.x[-1, 0] == pytest.approx(0.5, abs=1e-14)
    assert times_of(held, "slides") == pytest.approx([sum(0.1 / (0.45 - 0.1 * n) for n in range(5))], abs=1e-13)


def test_two_staircases_a_quarter_of_a_step_apart_are_climbed():
    result = run(lambda t, x: [ca.floor(t) - ca.floor(t - 0.25)], [0.0], 3.0)
    assert result.x[-1, 0] == pytest.approx(3 * 0.25, abs=1e-13)
    assert times_of(result, "crosses") == pytest.approx([0.25, 1.0, 1.25, 2.0, 2.25], abs=1e-13)


def test_conditions_are_surfaces_too():
    def rate(t, x):
        late = ca.logic_and(x[0] >= 1.5, ca.logic_not(t < 0.2))
        return [ca.if_else(x[0] < 1, 1.0, ca.if_else(ca.logic_or(late, x[0] > 9), -1.0, 0.5))]

    result = run(rate, [0.0], 4.0)
    expected = np.minimum(1.5, np.where(result.t < 1, result.t, 1 + 0.5 * (result.t - 1)))
    np.testing.assert_allclose(result.x[:, 0], expected, atol=1e-14)


def test_a_branch_that_is_not_taken_may_have_no_value():
    result = run(lambda t, x: [1.0, ca.if_else(x[0] > 0, ca.sqrt(x[0]), 0)], [-1.0, 0.0], 2.0)
    np.testing.assert_allclose(result.x[-1, 1], 2 / 3, atol=EXACT)


def test_a_surface_whose_function_jumps_with_another_is_met_where_it_jumps_to():
    result = run(lambda t, x: [1.0, -ca.sign(x[1] + 2 * ca.sign(x[0] - 1))], [0.0, 0.0], 4.0)
    np.testing.assert_allclose(result.x[:, 1], np.where(result.t < 1, result.t, 2 - result.t), atol=1e-13)


# A loop of the workbench


def aosmc(shape):
    law = AosmcRgs(
        paper_arm(), 6.0, 0.05, 5 * np.eye(2), 10 * np.eye(2), np.eye(2), np.eye(2), "reference", "raised", shape
    )
    return ClosedLoop(
        Manipulator(paper_arm(), q=[0.6, -0.8]), ArmFullState(2), law, Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    ).ode()


@pytest.mark.parametrize(
    ("shape", "h", "error"),
    [
        ("norm", 1e-5, 1e-9),  # corners: second order in the step, and fourth between them
        pytest.param("outer", 1e-5, 1e-5, marks=pytest.mark.heavy),  # jumps: first order, at most a step of them
    ],
)
def test_a_loop_of_the_workbench_is_the_limit_of_its_fixed_steps(shape, h, error):
    ode = aosmc(shape)
    times = np.array([0.1, 0.25, 0.4])
    result = reference_run(ode, times=times)
    runs = simulate(rk4(ode, h), until=0.4)
    steps = runs.x[0, np.round(times / h).astype(int)]
    np.testing.assert_allclose(result.x, steps, atol=error)
    assert (result.error < 1e-9).all()
    assert len(result.events) >= 3


@pytest.mark.parametrize("corner", [ca.fabs, lambda y: ca.fmax(y, 0), lambda y: y * ca.sign(y)])
def test_a_state_that_stays_on_a_corner_has_one_rate(corner):
    result = run(lambda t, x: [1 + corner(x[1]), -x[1]], [0.0, 0.0], 1.0)
    np.testing.assert_allclose(result.x[:, 0], result.t, atol=1e-15)


def test_numbers_of_numpy_are_numbers():
    result = reference_run(decay(), times=[1.0], rtol=np.float32(1e-6), max_steps=np.int64(1000))
    assert result.x[0, 0] == pytest.approx(np.exp(-3.0), abs=1e-6)


def test_an_equation_without_a_lipschitz_constant_at_its_start_and_one_that_escapes_after_the_last_time_are_run():
    assert (
        reference_run(root(), times=[1.0]).x[0, 0] == 0.0
    )  # of all solutions of x' = sqrt(x) from 0 the one that stays
    assert reference_run(explosion(), times=[0.9]).x[0, 0] == pytest.approx(10.0, rel=1e-8)
