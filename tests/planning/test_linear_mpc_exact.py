"""The exact solution of a predictive problem against DAQP, and proofs that there is none."""

import numpy as np
import pytest

from tests.support.predictive_problems import cart_pole, drawn, peer_answer
from workbench.planning import MpcConflictError, MpcLimits, exact_mpc, mpc_problem, plan_gap
from workbench.planning.linear_mpc.infeasibility import farkas_margin

DOUBLE = ([[1.0, 0.1], [0.0, 1.0]], [[0.005], [0.1]], np.diag([1.0, 0.1]), [[0.1]])


@pytest.mark.parametrize("soft", [False, True])
def test_optima_and_conflicts_of_drawn_problems_are_those_of_a_peer(soft):
    rng, solutions, conflicts = np.random.default_rng(4), 0, 0
    for _ in range(12):
        problem = drawn(rng, soft=soft)
        exact = exact_mpc(problem)
        for x in 1.5 * rng.normal(size=(3, len(problem.A))):
            peer = peer_answer(problem, x)
            try:
                answer = exact.solve(x)
            except MpcConflictError as error:
                proof = error.proof
                conflicts += 1
            else:
                proof = None
                solutions += 1
            if proof is not None:
                assert peer is None
                assert proof.is_proved  # in exact arithmetic
                assert proof.limits
                continue
            assert peer is not None
            assert answer.certificate.is_passed
            np.testing.assert_allclose(answer.u[0], peer[0], rtol=0, atol=1e-7)  # the peer's tolerance is 1e-6 of a row
            assert answer.objective == pytest.approx(peer[1], rel=1e-7)
    assert solutions > 20
    assert soft or conflicts > 1


def test_the_objective_is_the_cost_of_the_model_under_the_inputs_within_their_limits():
    problem = cart_pole(states=([-NO, -NO, -0.1, -NO], [NO, NO, 0.1, NO]))
    x = np.array([-0.05, 0.0, 0.05, 0.2])
    answer = exact_mpc(problem).solve(x)
    cost = 0.0
    for u in answer.u:
        cost += x @ problem.Q @ x + u @ problem.R @ u
        x = problem.A @ x + problem.B @ u
        assert abs(u[0]) <= 3 + 1e-9  # rounding, as in the next line
        assert abs(x[2]) <= 0.1 + 1e-9
    assert answer.active_limits
    assert answer.objective == pytest.approx(cost + x @ problem.P @ x, rel=1e-10)  # two sums of a hundred terms


NO = np.inf


def test_a_conflict_names_the_limits_without_any_of_which_there_is_a_solution():
    speed = ([-NO, -0.8], [NO, 0.8])
    problem = mpc_problem(*DOUBLE, 10, MpcLimits(inputs=(-1.0, 1.0), states=speed))
    x = [0.0, 1.5]  # it takes 7 periods to brake to 0.8
    with pytest.raises(MpcConflictError, match=r"limits on u\[0\], x\[1\] from this state") as refusal:
        exact_mpc(problem).solve(x)
    proof = refusal.value.proof
    assert proof.is_proved
    assert proof.margin > 0
    for limits in (MpcLimits(inputs=(-1.0, 1.0)), MpcLimits(states=speed)):
        assert exact_mpc(mpc_problem(*DOUBLE, 10, limits)).solve(x).certificate.is_passed


def test_no_multipliers_refute_a_state_that_has_a_solution():
    problem = mpc_problem(*DOUBLE, 10, MpcLimits(inputs=(-1.0, 1.0), states=([-NO, -0.8], [NO, 0.8])))
    x, rng = np.array([0.5, 0.75]), np.random.default_rng(0)
    assert exact_mpc(problem).solve(x).certificate.is_passed
    for multipliers in rng.normal(size=(50, 10, 2)):
        margin, is_proved = farkas_margin(problem, x, multipliers)
        assert margin <= 0
        assert not is_proved


def test_any_multipliers_bound_the_optimum_from_below_and_their_plan_from_above():
    exact, rng = exact_mpc(cart_pole()), np.random.default_rng(1)
    x = np.array([-0.2, 0.0, 0.05, 0.1])
    answer = exact.solve(x)
    for size in (0.0, 1e-3, 1e-1, 1.0):
        lower, upper = plan_gap(exact, x, answer.multipliers.ravel() * (1 + size * rng.normal(size=20)))
        assert lower <= answer.objective * (1 + 1e-12)  # rounding
        assert upper >= answer.objective * (1 - 1e-12)
        assert size or upper == pytest.approx(lower, rel=1e-10)


def test_an_unstable_plant_and_a_long_horizon_cost_no_digits():
    """The maps are made of the closed loop: A^64 of this plant is 1e8, its Hessian of condition 1e18."""
    A, B = [[1.35, 0.1], [0.0, 0.9]], [[0.0], [0.2]]
    problem = mpc_problem(A, B, np.eye(2), [[0.1]], 64, MpcLimits(inputs=(-40.0, 40.0)))
    x = np.array([4.0, -0.5])
    answer = exact_mpc(problem).solve(x)
    assert answer.active_limits
    assert answer.certificate.is_passed
    longer = mpc_problem(A, B, np.eye(2), [[0.1]], 40, MpcLimits(inputs=(-40.0, 40.0)))
    assert answer.objective == pytest.approx(exact_mpc(longer).solve(x).objective, rel=1e-11)  # LQR after stage 40


def test_a_limit_that_no_input_moves_is_refuted_by_its_own_row():
    # the position a period later depends on the state alone, and is beyond its limit whatever the input is
    A, B = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.0], [0.1]])
    limits = MpcLimits(inputs=(-1.0, 1.0), states=(-2.0, 2.0))
    exact = exact_mpc(mpc_problem(A, B, np.eye(2), [[0.1]], 6, limits))
    with pytest.raises(MpcConflictError, match="x\\[0\\]") as refusal:
        exact.solve([1.9, 1.5])
    assert refusal.value.proof.is_proved
    assert exact.solve([1.9, 0.3]).certificate.violation < 1e-12
