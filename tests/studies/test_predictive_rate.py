"""The table of predictive laws beside solvers of quadratic programs; no time is asserted."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("llvmlite", reason="the study of speed is that of the compiled march")

from studies.performance import predictive_peers, predictive_rate
from studies.performance.measurements import Effort
from studies.performance.predictive_loops import PERIOD, PredictiveCase, Starts
from studies.performance.predictive_rate import INPUTS, SOFT_WEIGHT, STATES, hard_loops, same_bits

SMALL = Effort(horizon=2.0, repetitions=1, loops=8, peer_loops=3, exact_loops=2)
CASES = (PredictiveCase(INPUTS, None, 60), PredictiveCase(STATES, SOFT_WEIGHT, 60))


@pytest.mark.parametrize("case", CASES, ids=("inputs", "states"))
def test_daqp_solves_the_problem_of_the_law(case):
    pytest.importorskip("daqp")
    runs = case.run(case.step, Starts.draw(3, 0))
    states = runs.e.reshape(-1, 4)[::7]
    exact = [case.design.exact.first_move(x)[0] for x in states]
    moves = predictive_peers.daqp(case.design.problem)(states)
    np.testing.assert_allclose(moves, exact, rtol=0, atol=1e-8)  # the tolerance of an active row


@pytest.mark.parametrize("name", ["osqp", "tinympc"])
def test_a_peer_of_a_coarse_tolerance_comes_near_the_exact_law(name):
    pytest.importorskip(name)
    (case, _) = CASES
    solver = getattr(predictive_peers, name)(case.design.problem)
    x = np.tile([0.02, 0.0, 0.0, 0.0], (5, 1))
    moves = solver(x)
    assert moves[-1] == pytest.approx(case.design.exact.first_move(x[0])[0], abs=0.3)  # a twentieth of the span


@pytest.mark.parametrize("case", CASES, ids=("inputs", "states"))
def test_limits_act_and_clipped_lqr_is_bad_at_the_starts_that_are_kept(case):
    loops = hard_loops(case, 6)
    assert 0 < len(loops.starts) <= 6
    assert (loops.active >= 0.2).all()
    assert (loops.excess >= 0.05).all()
    assert f"{len(loops.starts)} loops of 60 periods" in loops.words
    assert same_bits(loops, case.ends(case.step, loops.starts))
    assert not same_bits(replace(loops, ends=loops.ends + 1.0), loops.ends)


def test_a_state_beyond_a_soft_limit_costs_its_square():
    soft = CASES[1]
    runs = soft.run(soft.step, Starts.draw(1, 0))
    over = np.maximum(np.abs(runs.e[:, :, 2]) - 0.06, 0.0)
    assert over.max() > 0.0
    free = replace(soft, soft_weight=0.0)
    assert soft.costs(runs) - free.costs(runs) == pytest.approx(SOFT_WEIGHT * (over**2).sum(), rel=1e-9)  # rounding


def test_a_loop_whose_pole_falls_costs_infinitely_much():
    case = PredictiveCase(INPUTS, None, 60)
    start = Starts(np.array([[0.0, 0.0, 0.9, 5.0]]), np.array([0.2]))
    assert np.isinf(case.costs(case.run(case.step, start))).all()


def test_the_exact_law_and_peers_run_the_plant_of_the_law():
    """The law of many sweeps ends where the exact law does."""
    (case, _) = CASES
    starts = Starts.draw(2, 4)
    own = replace(case, sweeps=60)
    expected, runs = own.run(own.step, starts), predictive_rate.exact_runs(case, starts)
    np.testing.assert_allclose(runs.F, expected.F, rtol=0, atol=1e-6)  # N: what the sweeps and the polish leave, grown
    assert runs.e.shape == (2, 60, 4)
    assert case.periods * PERIOD == pytest.approx(1.2)


def test_the_table_has_a_row_for_each_solver_and_one_for_the_cost():
    absent = predictive_peers.PredictivePeer("absent", "no_such_package", 7.0, lambda problem: pytest.fail("not there"))
    there = predictive_peers.PredictivePeer("zero", "numpy", 1e9, lambda problem: lambda x: np.zeros(len(x)))
    rows = predictive_rate.predictive_rows(SMALL, (absent, there), there)
    assert [row.name for row in rows] == [
        "cost of MPC over the exact law, limits on the input",
        "loops of MPC, limits on the input, absent",
        "loops of MPC, limits on the input, zero",
        "cost of MPC over the exact law, soft limits on a state",
        "loops of MPC, soft limits on a state, zero",
    ]
    assert (rows[1].value, rows[1].note) == (None, "no_such_package is not installed")
    assert rows[2].is_reached is False
    assert "inf % over the exact law" in rows[2].note
    assert rows[0].is_reached
    assert rows[3].is_reached
    assert "the bits are the same" in rows[0].note
    assert "the bits are the same" in rows[3].note
