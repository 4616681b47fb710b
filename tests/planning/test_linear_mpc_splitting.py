"""The law with a fixed number of sweeps: what is proved of it, and how near it comes to the exact law."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.predictive_problems import cart_pole, drawn
from workbench.planning import (
    MpcLimits,
    dual_product,
    exact_loops,
    exact_mpc,
    move_bound,
    mpc_problem,
    no_memory,
    operation_count,
    recursion_numbers,
    sampled_loss,
    solve_period,
    splitting_numbers,
    tune_splitting,
)
from workbench.planning.linear_mpc.splitting import solve_quasidefinite, sweep
from workbench.planning.linear_mpc.splitting_tuning import admm_numbers

NO = np.inf


def test_the_law_is_lqr_where_no_limit_acts():
    problem = cart_pole()
    numbers, x = splitting_numbers(problem), np.array([0.001, 0.0, 0.01, 0.02])
    memory = no_memory(numbers)
    for _ in range(30):
        answer = solve_period(numbers, memory, x)
        np.testing.assert_allclose(answer.u, -problem.K @ x, rtol=0, atol=1e-12)  # rounding of a force of order one
        memory, x = answer.memory, problem.A @ x + problem.B @ answer.u


def test_two_passes_over_the_stages_are_the_dense_product():
    rng = np.random.default_rng(3)
    for _ in range(5):
        problem = drawn(rng, soft=True)
        numbers = splitting_numbers(problem)
        multipliers = rng.normal(size=(4, len(numbers.low)))
        dense = multipliers @ numbers.matrix.T
        passes = dual_product(recursion_numbers(problem), multipliers)
        np.testing.assert_allclose(passes, dense, rtol=0, atol=1e-11 * np.abs(dense).max())  # rounding of sums


def test_the_contraction_holds_for_every_active_set():
    rng = np.random.default_rng(5)
    for problem in (cart_pole(), drawn(rng, soft=True), drawn(rng, soft=True)):
        numbers = splitting_numbers(problem)
        assert numbers.is_proved
        D, M = numbers.matrix, np.diag(numbers.sigma) + numbers.W * numbers.L @ numbers.W.T
        for _ in range(20):
            a = np.flatnonzero(rng.random(len(D)) < rng.uniform(0.1, 1.0))
            if len(a) == 0:
                continue
            error = np.linalg.eigvals(np.linalg.solve(M[np.ix_(a, a)], (M - D)[np.ix_(a, a)]))
            assert np.abs(error).max() <= numbers.contraction + 1e-9  # rounding of the eigenvalues


def test_sweeps_end_at_the_exact_solution_at_the_rate_of_the_contraction():
    problem = cart_pole()
    numbers, exact, x = splitting_numbers(problem), exact_mpc(problem), np.array([-0.15, 0.0, 0.03, 0.0])
    answer = exact.solve(x)
    assert len(answer.active_limits) > 3
    lqr = numbers.Y @ x
    zeta, errors = lqr, []
    for _ in range(40):
        zeta, _ = sweep(numbers, lqr, zeta)
        v = np.clip(zeta, numbers.low, numbers.high)
        errors.append(np.abs((zeta - v) / numbers.sigma - answer.multipliers.ravel()).max())
    first = next(i for i, error in enumerate(errors) if error < 1e-3)
    assert errors[-1] < 1e-9 * np.abs(answer.multipliers).max()
    later = min(first + 6, 39)
    assert (
        errors[later] < 10 * numbers.contraction ** (later - first) * errors[first]
    )  # 10: from a norm of M to the largest


@pytest.mark.parametrize("method", ["metric", "admm"])
def test_both_methods_reach_the_exact_move_under_limits_on_states_and_rates(method):
    A, B = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.005], [0.1]])
    limits = MpcLimits(inputs=(-1.0, 1.0), states=([-NO, -0.5], [NO, 0.5]), rates=(-0.4, 0.4))
    problem = mpc_problem(A, B, np.diag([1.0, 0.1]), [[0.1]], 12, limits)
    exact = exact_mpc(problem)
    numbers = exact.numbers if method == "metric" else admm_numbers(exact, 3.0, 30.0)
    x = np.array([0.6, 0.1, 0.0])
    answer = solve_period(numbers, no_memory(numbers), x, sweeps=3000)
    assert answer.residual < 1e-7
    np.testing.assert_allclose(answer.u, exact.first_move(x), rtol=0, atol=1e-6)  # what 3000 sweeps leave


def test_three_sweeps_cost_a_thousandth_where_clipped_lqr_is_lost():
    """Issue 37's bar for |F| limited: the sum over starts at which a limit acts in a fifth of the periods or more."""
    problem = cart_pole()
    starts = np.random.default_rng(0).uniform(-1, 1, (40, 4)) * [0.25, 0.2, 0.05, 0.2]
    numbers, exact = splitting_numbers(problem, sweeps=3), exact_mpc(problem)
    hard = np.array([x for x in starts if _lqr_is_lost(problem, x)])[:8]
    assert len(hard) == 8
    loss = sampled_loss(exact, numbers, hard, 40)
    assert loss.infeasible == 0
    assert loss.active_share > 0.2
    assert loss.worst_cost_loss < 1e-3
    assert loss.worst_violation == 0.0


def _lqr_is_lost(problem, x):
    for _ in range(200):
        x = problem.A @ x + problem.B @ np.clip(-problem.K @ x, -3.0, 3.0)
    return np.abs(x).max() > 1.0


def test_a_target_and_its_limits_are_those_of_the_moved_problem():
    problem = cart_pole()
    rest = np.array([0.2, 0.0, 0.0, 0.0]), np.array([0.5])
    numbers, moved = splitting_numbers(problem, sweeps=200), exact_mpc(problem.about(*rest))
    x = np.array([0.05, 0.0, 0.02, 0.1])
    answer = solve_period(numbers, no_memory(numbers), x, rest)
    np.testing.assert_allclose(answer.u - rest[1], moved.first_move(x - rest[0]), rtol=0, atol=1e-7)


def test_tuning_takes_the_fewest_operations_that_are_accurate_enough():
    exact = exact_mpc(cart_pole(8, states=([-NO, -NO, -0.1, -NO], [NO, NO, 0.1, NO]), soft_weight=1e4))
    starts = np.random.default_rng(2).uniform(-1, 1, (4, 4)) * [0.2, 0.2, 0.08, 0.3]
    states, moves = exact_loops(exact, starts, 15)
    tuning = tune_splitting(exact, states, moves, accuracy=1e-3)
    chosen = operation_count(tuning.numbers).period
    good = [row for row in tuning.table if row.error <= 1e-3]
    assert chosen == min(row.operations for row in good)
    assert len(tuning.table) > len(good)


def test_the_residual_bounds_the_error_of_a_move():
    exact = exact_mpc(cart_pole(states=([-NO, -NO, -0.1, -NO], [NO, NO, 0.1, NO]), soft_weight=1e4))
    numbers, ratios = exact.numbers, []
    for x in np.random.default_rng(8).uniform(-1, 1, (12, 4)) * [0.2, 0.2, 0.08, 0.3]:
        lqr, u = numbers.Y @ x, exact.first_move(x)
        zeta = lqr
        for _ in range(4):
            bound = move_bound(exact, numbers, x, zeta)
            error = np.abs(np.clip(zeta[:1], -3.0, 3.0) - u)
            assert error <= bound + 1e-10  # rounding
            ratios.append(float(error[0] / bound[0]) if bound[0] > 1e-6 else 0.0)
            zeta, _ = sweep(numbers, lqr, zeta)
    assert max(ratios) > 0.02  # a bound that says something: the error is in one entry, the residual in forty


def test_factors_without_pivoting_solve_quasidefinite_systems():
    rng = np.random.default_rng(6)
    root, other = rng.normal(size=(2, 3, 5, 5))
    G = root @ root.swapaxes(-1, -2) + 0.1 * np.eye(5)
    G[:, :2, :2] = -(other @ other.swapaxes(-1, -2))[:, :2, :2] - 0.1 * np.eye(2)
    right = rng.normal(size=(3, 5))
    gap = np.einsum("brs,bs->br", G, solve_quasidefinite(G, right)) - right
    assert np.abs(gap).max() < 1e-11  # entries and condition of order 100


def test_a_batch_has_the_answers_of_its_members():
    numbers = replace(splitting_numbers(cart_pole()), sweeps=5)
    states = np.random.default_rng(7).uniform(-0.1, 0.1, (6, 4))
    together = solve_period(numbers, no_memory(numbers, 6), states)
    for i, x in enumerate(states):
        alone = solve_period(numbers, no_memory(numbers), x)
        np.testing.assert_allclose(together.u[i], alone.u, rtol=0, atol=1e-11)  # BLAS sums in another order
        np.testing.assert_allclose(together.memory[i], alone.memory, rtol=0, atol=1e-9)
