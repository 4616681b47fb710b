"""The study of planned motions and predictive laws: targets, the governor, equal choices, and what counts as lost."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from studies.d2_planning.choices import CANDIDATES, Choice, candidates, judge_candidates
from studies.d2_planning.designs import BY_KEY, LAWS, LOAD, MOST_KNOBS, clipped_regulator, governed_regulator, laws_of
from studies.d2_planning.followed_section import Share
from studies.d2_planning.followers import ALONG, CAUGHT, FOLLOWERS, FORWARD, gains_of
from studies.d2_planning.motions import PlannedMotion
from studies.d2_planning.problems import PROBLEMS, linear_model
from studies.d2_planning.runs import cost_of, is_lost, loop_of

KNOBS = {"load": 1.0, "inputs": 0.1, "rates": 0.1, "margin": 0.0}


@pytest.mark.parametrize("key", PROBLEMS)
def test_the_rest_of_a_reference_is_a_rest_with_the_reference_as_its_output(key):
    one = linear_model(key)
    size = np.abs(one.B @ one.G).max() + 1.0
    np.testing.assert_allclose((one.A - np.eye(len(one.A))) @ one.X + one.B @ one.G, 0.0, atol=1e-10 * size)
    np.testing.assert_allclose(one.C @ one.X, np.eye(2), atol=1e-10)


def test_the_predictive_law_is_the_clipped_regulator_where_no_limit_acts():
    problem = replace(PROBLEMS["tank"], low=(-1e3, -1e3), high=(1e3, 1e3), horizon=80.0)
    ends = []
    for key in ("mpc", "lqr"):
        loop = loop_of(problem, BY_KEY[key], KNOBS).ode()
        x0 = loop.states.pack({"plant.h_1": 11.0, "observer.h_1_hat": 11.0})
        ends.append(wb.simulate(loop.step(1), x0=x0, until=problem.horizon)["v_1"])
    np.testing.assert_allclose(*ends, rtol=1e-9)  # the same command up to rounding


def test_the_governed_prediction_keeps_the_limits_from_a_state_at_rest():
    problem = PROBLEMS["tank"]
    law, model = governed_regulator(problem, KNOBS), linear_model("tank")
    own = law.target
    x = np.array(problem.x0)
    est = wb.Signals({**own.states.view(ca.SX(x)), "d": ca.SX.zeros(2)})
    ref = wb.Signals(own.outputs.view(ca.SX([16.0, 9.0])))  # far beyond what the pumps can do at once
    after = law.update(0.0, {"v": ca.SX(problem.r0), "begun": ca.SX(1.0)}, est, ref)
    v = np.array(ca.DM(ca.densify(after["v"]))).ravel()
    e = x - problem.x0 - model.X @ (v - problem.r0)
    u = np.array([model.G @ (v - problem.r0) + problem.u0 - part @ e for part in law.Phi.reshape(-1, 2, 4)])
    assert (u >= np.array(problem.low) - 1e-9).all()
    assert (u <= np.array(problem.high) + 1e-9).all()
    at_a_limit = np.abs(np.concatenate([u - problem.low, u - problem.high])).min()
    assert at_a_limit < 1e-9  # it moves as far as it may
    assert not np.allclose(v, [16.0, 9.0])


def test_all_laws_choose_among_as_many_candidates_and_each_may_choose_the_observer():
    points = candidates()
    assert points.shape == (CANDIDATES, MOST_KNOBS)
    for law in LAWS:
        assert law.knobs[0] == LOAD
        assert len(law.knobs) <= MOST_KNOBS
    assert {law.key for law in laws_of(PROBLEMS["arm"])} == set(BY_KEY)
    assert clipped_regulator(PROBLEMS["arm"], KNOBS).K.shape == (2, 4)


def test_a_candidate_that_loses_fewer_runs_is_better_at_any_cost():
    choice = Choice(np.zeros((3, MOST_KNOBS)), np.array([1.0, 0.0, 0.0]), np.array([1.0, 5.0, 4.0]))
    assert choice.best == 2
    assert Choice(np.zeros((2, MOST_KNOBS)), np.array([4.0, 3.0]), np.array([np.nan, 9.0])).best == 1


def test_a_run_that_diverged_or_ends_far_away_is_lost_and_never_averaged():
    problem = PROBLEMS["arm"]
    terms = np.array([[0.3, 0.005, 300.0], [0.3, 2 * problem.lost_beyond, 300.0], [np.nan, np.nan, np.nan]])
    np.testing.assert_array_equal(is_lost(problem, terms), [False, True, True])
    np.testing.assert_allclose(cost_of(problem, terms)[0], 3.0)  # one for each term
    assert np.isnan(cost_of(problem, terms)[1:]).all()
    lost, costs = judge_candidates(problem, terms[np.newaxis])
    assert (lost[0], costs[0]) == (2.0, pytest.approx(3.0))


def test_the_share_of_loops_that_arrive_has_the_exact_interval():
    share = Share(np.ones(100, dtype=bool))
    assert share.value == 1.0
    assert share.interval == (pytest.approx(0.025 ** (1 / 100)), 1.0)  # Clopper and Pearson, where all arrive


def test_feedforward_alone_has_no_gain_and_a_plan_is_caught_in_its_last_tenth():
    times = np.linspace(0.0, 1.0, 21)
    none = np.zeros((20, 1))
    K = np.arange(1.0, 22.0)[:, np.newaxis, np.newaxis]
    shares = (1.0, 0.99, 1.0)
    plan = PlannedMotion(times, *6 * (none,), times, K, 1.0, 0.0, 0.0, True, (), *shares)
    assert set(FOLLOWERS) >= {ALONG, CAUGHT, FORWARD}
    assert not gains_of(plan, FORWARD).K.any()
    np.testing.assert_array_equal(gains_of(plan, ALONG).K, K)
    caught = gains_of(plan, CAUGHT).K.ravel()
    np.testing.assert_array_equal(caught, np.where(times >= 0.9, 21.0, 0.0))
