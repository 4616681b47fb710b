"""Problems of predictive control: what is refused, sampling with a delay, offset-free targets and terminal sets."""

from itertools import pairwise

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.support.predictive_problems import cart_pole
from workbench.planning import (
    MpcLimits,
    exact_mpc,
    limited_target,
    mpc_problem,
    no_memory,
    offset_free,
    sampled_mpc,
    solve_period,
    splitting_numbers,
    terminal_set,
)

A, B, Q, R = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.0], [0.1]]), np.eye(2), np.array([[0.1]])
FREE = MpcLimits()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"Q": np.diag([1.0, -1.0])}, r"Q must be positive semidefinite"),
        ({"R": np.zeros((1, 1))}, r"R must be positive definite"),
        ({"P": np.diag([1.0, -1.0])}, r"P must be positive semidefinite"),
        ({"A": [[1.0, np.nan], [0.0, 1.0]]}, r"A must hold finite numbers"),
        ({"B": np.zeros((3, 1))}, r"B must be a matrix of shape \(2, any\)"),
        ({"B": np.zeros((2, 1))}, r"no gain|cannot|stabilis"),
        ({"horizon": 3, "delay": 3}, r"above the delay"),
        ({"limits": MpcLimits(inputs=(1.0, -1.0))}, r"low end below its high end; 'u\[0\]' has 1 and -1"),
        ({"limits": MpcLimits(states=([0.0, 1.0, 2.0], 1.0))}, r"two arrays of shape \(2,\)"),
        ({"limits": MpcLimits(states=(-1.0, 1.0), soft_weight=0.0)}, r"weight above zero"),
        ({"limits": MpcLimits(rates=(-1.0, np.nan))}, r"two numbers or two arrays"),
    ],
)
def test_a_problem_that_is_none_is_refused(change, message):
    given = {"A": A, "B": B, "Q": Q, "R": R, "horizon": 10, "limits": FREE} | change
    with pytest.raises(ValueError, match=message):
        mpc_problem(**given)


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.07, 0.1])
def test_a_sampled_plant_with_a_delay_moves_as_its_differential_equation(delay):
    a, b = np.array([[0.0, 1.0], [-4.0, -0.4]]), np.array([[0.0], [4.0]])
    system = control.ss(a, b, np.eye(2), np.zeros((2, 1)))
    problem = sampled_mpc(system, 0.05, np.eye(2), R, 10, MpcLimits(inputs=(-1.0, 1.0)), delay=delay)
    u = np.array([0.3, -0.8, 1.0, 0.2, -0.5, 0.7])
    state = np.zeros(len(problem.A))
    state[:2] = x = np.array([0.5, -0.2])
    for k in range(len(u)):
        state = problem.A @ state + problem.B @ u[k : k + 1]
        edges = np.unique(np.clip([0.05 * k, delay % 0.05 + 0.05 * k, 0.05 * (k + 1)], 0, None))
        for start, end in pairwise(edges):
            held = int(np.floor(((start + end) / 2 - delay) / 0.05))
            push = u[held] if held >= 0 else 0.0
            x = solve_ivp(lambda _, s, p=push: a @ s + b[:, 0] * p, (start, end), x, rtol=1e-11, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(state[:2], x, rtol=0, atol=1e-9)  # the solver's tolerance over the span


def test_limits_of_rates_hold_from_the_last_input_on():
    problem = mpc_problem(A, B, Q, R, 15, MpcLimits(inputs=(-1.0, 1.0), rates=(-0.3, 0.2)))
    answer = exact_mpc(problem).solve([2.0, 0.0, 0.1])
    changes = np.diff(answer.u[:, 0], prepend=0.1)
    assert changes.min() == pytest.approx(-0.3, abs=1e-9)  # rounding
    assert changes.max() <= 0.2 + 1e-9
    assert answer.certificate.is_passed


def test_a_constant_disturbance_leaves_no_offset_and_inputs_stay_within_limits():
    problem = mpc_problem(A, B, Q, R, 15, MpcLimits(inputs=(-1.0, 1.0)))
    numbers, offset = splitting_numbers(problem), offset_free(problem, [[1.0, 0.0]])
    x, estimate, memory = np.array([1.0, 0.0]), np.array([1.0, 0.0, 0.0]), no_memory(numbers)
    push = np.array([0.0, 0.04])
    for k in range(400):
        push = -push if k == 200 else push
        estimate = offset.correct(estimate, x[:1])
        answer = solve_period(numbers, memory, estimate[:2], offset.target_of(estimate[2:], np.array([0.5])))
        assert abs(answer.u[0]) <= 1.0
        memory, estimate = answer.memory, offset.predict(estimate, answer.u)
        x = A @ x + B @ answer.u + push
        if k in (199, 399):
            assert x[0] == pytest.approx(0.5, abs=1e-8)  # the slowest pole of the observer over 200 periods
    assert np.abs(offset.poles).max() < 1


def test_a_disturbance_that_an_integrator_hides_is_refused():
    problem = mpc_problem(A, B, Q, R, 10, FREE)
    with pytest.raises(ValueError, match=r"cannot be told from the states"):
        offset_free(problem, [[1.0, 0.0]], Cd=[[1.0]])
    with pytest.raises(ValueError, match=r"as many disturbances as there are outputs, 1"):
        offset_free(problem, [[1.0, 0.0]], Bd=np.eye(2))


def test_a_reference_beyond_the_limits_has_the_nearest_target():
    problem = mpc_problem([[0.5]], [[1.0]], [[1.0]], R, 10, MpcLimits(inputs=(-1.0, 1.0)))
    offset = offset_free(problem, [[1.0]])
    x, u = limited_target(offset, problem, np.array([0.0]), np.array([5.0]))
    np.testing.assert_allclose([x[0], u[0]], [2.0, 1.0], atol=1e-9)  # x = 0.5 x + u at u = 1
    inside = limited_target(offset, problem, np.array([0.25]), np.array([1.0]))
    np.testing.assert_allclose(np.concatenate(inside), [1.0, 0.25], atol=1e-9)


def test_the_terminal_ellipsoid_is_kept_by_lqr_and_touches_its_limit():
    limits = MpcLimits(inputs=(-1.0, 2.0), states=([-np.inf, -0.4], [np.inf, 0.4]))
    problem = mpc_problem(A, B, Q, R, 10, limits)
    ends = terminal_set(problem)
    assert ends.decrease_is_proved
    rng = np.random.default_rng(0)
    around = np.linalg.solve(np.linalg.cholesky(ends.P).T, rng.normal(size=(2, 2000)))
    around *= np.sqrt(ends.level / np.einsum("ib,ij,jb->b", around, ends.P, around))
    after = (A - B @ ends.K) @ around
    rows = (problem.rows.F - problem.rows.E @ ends.K) @ around
    assert np.einsum("ib,ij,jb->b", after, ends.P, after).max() < ends.level
    assert (rows <= problem.rows.high[:, None] + 1e-9).all()
    assert (rows >= problem.rows.low[:, None] - 1e-9).all()
    reach = np.abs(rows[problem.rows.names.index(ends.limit)]).max()
    assert reach == pytest.approx(
        {"u[0]": 1.0, "x[1]": 0.4}[ends.limit], rel=1e-4
    )  # of 2000 directions one is this near


def test_the_optimal_cost_falls_from_a_safe_start():
    problem = mpc_problem(A, B, Q, R, 10, MpcLimits(inputs=(-1.0, 1.0), states=([-np.inf, -0.5], [np.inf, 0.5])))
    ends, exact, x = terminal_set(problem), exact_mpc(problem), np.array([0.2, 0.0])
    answer = exact.solve(x)
    assert not ends.holds_state(x)
    assert ends.is_safe(answer.objective)
    for _ in range(15):
        u = answer.u[0]
        stage = x @ Q @ x + u @ R @ u
        x = A @ x + B @ u
        after = exact.solve(x)
        assert after.objective <= answer.objective - stage + 1e-9  # rounding
        answer = after


def test_a_terminal_set_needs_limits_around_the_rest_and_the_cost_of_lqr():
    with pytest.raises(ValueError, match=r"'u\[0\]' must hold 0 inside"):
        terminal_set(mpc_problem(A, B, Q, R, 10, MpcLimits(inputs=(0.5, 1.0))))
    with pytest.raises(ValueError, match=r"needs P to be the cost of the LQR law"):
        terminal_set(mpc_problem(A, B, Q, R, 10, MpcLimits(inputs=(-1.0, 1.0)), P=np.eye(2)))
    assert terminal_set(cart_pole()).claims[0].hypotheses
