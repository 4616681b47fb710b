"""a8: the same conditions for all laws, numbers that reach them, and runs by the equations."""

from functools import cache

import casadi as ca
import numpy as np
import pytest

from studies.a8_fair_comparison.ablations import PARTS, RETUNED_ENTRANTS, RICCATI, steady_gain
from studies.a8_fair_comparison.evidence import DRAW_SEED, LostRuns, cause_of
from studies.a8_fair_comparison.other_numbers import half_budget, second_search, third_search
from studies.a8_fair_comparison.study import study
from studies.paper.card import CARD
from studies.paper.costs import cost_of
from studies.paper.entrants import (
    ALL,
    ALL_INFORMATION,
    BOTH,
    ENTRANTS,
    LAWS,
    PROPOSAL,
    PROPOSED_LAW,
    READINGS,
)
from studies.paper.scenarios import (
    HELD_OUT,
    TERMS,
    TRAINING,
    cost,
    first_estimates,
    metrics,
    objective,
    uncertain,
)
from tests.support.given_costs import RNG
from tests.support.samples import made_sample
from tests.support.tunings import tuning
from workbench.blocks.loop import roles
from workbench.core import Signals, information_classes, lift
from workbench.engine.factors import Space
from workbench.study.tuning import tune

PAPER, JUMPS = HELD_OUT[0], next(one for one in HELD_OUT if one.jumps)
REST = Signals({name: ca.SX.zeros(2) for name in ("q", "qd", "qdd")})


@pytest.fixture(scope="module")
def loops():
    """All laws with the numbers of the card in the scenario 'paper'."""
    return {one.key: one.loop(PAPER) for one in ALL}


@pytest.fixture(scope="module")
def equation(loops):
    """The equations of one of these loops, written down when they are asked for."""
    return cache(lambda key: loops[key].ode())


# All laws with most and with least that is measured; between them the proposed law, and PID, which has no model.
REACHED = [*ENTRANTS[BOTH.key], *ENTRANTS[READINGS.key], *(one for one in ALL if one.name in (PROPOSED_LAW, "PID"))]
OF_LIGHT_TESTS = {
    PROPOSAL.key,
    *(one.key for one in ENTRANTS[READINGS.key] if one.name in (PROPOSED_LAW, "PID", "SMC")),
}


@pytest.mark.parametrize(
    "entrant",
    [
        pytest.param(one, marks=[pytest.mark.heavy] * (one.key not in OF_LIGHT_TESTS), id=one.key)
        for one in dict.fromkeys(REACHED)
    ],
)
def test_a_number_reaches_the_loop_as_the_search_sets_it(entrant, equation):
    """The search sets numbers in the equations; the law that is judged has the same numbers in its blocks."""
    u = np.linspace(0.2, 0.8, len(entrant.tuned_numbers))
    searched = equation(entrant.key)
    factors = tuple(one.factor for one in entrant.tuned_numbers)
    space = Space(factors, searched.parameters, searched.states)
    p, x0 = space.rows(u[None])
    x = dict(zip((one.name for one in entrant.tuned_numbers), space.values(u[None])[0], strict=True))
    judged = entrant.loop(PAPER, x).ode()
    assert (judged.parameters.names, judged.states.names) == (searched.parameters.names, searched.states.names)
    np.testing.assert_allclose(judged.parameters.default, p[0], rtol=1e-15)
    np.testing.assert_allclose(judged.states.default, x0[0], rtol=1e-15)


@pytest.mark.parametrize("scenario", [*TRAINING, *HELD_OUT], ids=lambda one: one.name)
def test_all_laws_face_the_same_arm_and_the_same_instruments(scenario):
    some = [entrants[k] for entrants in ENTRANTS.values() for k in (0, -1)]  # a scenario does not ask for a law's name
    loops = [entrant.loop(scenario) for entrant in (ALL if scenario is PAPER else some)]
    arms = [lift(loop.loop.plant).layout.default for loop in loops]
    instruments = [lift(loop.instruments).layout.default for loop in loops]
    for loop, arm, reading in zip(loops, arms, instruments, strict=True):
        np.testing.assert_array_equal(arm, arms[0])
        np.testing.assert_array_equal(reading, instruments[0])
        assert (loop.period, loop.delay, loop.loop.reference) == (loops[0].period, loops[0].delay, scenario.reference)


def test_no_law_uses_the_truth(loops):
    assert not any(loop.loop.observer.uses_truth for loop in loops.values())


@pytest.mark.parametrize("given", ALL_INFORMATION, ids=lambda one: one.key)
def test_laws_that_are_compared_are_given_the_same(given, loops):
    """By the equations: alone PID without an observer is given less, as it has no model, and the observers have one."""
    held = {one.name: roles(loops[one.key].loop) for one in ENTRANTS[given.key]}
    everyone = tuple(one.name for one in LAWS)
    with_model = tuple(name for name in everyone if name != "PID")
    assert set(information_classes(held)) == ({everyone} if "observer" in given.words else {with_model, ("PID",)})


def test_nobody_is_judged_where_it_was_tuned():
    trained = {(id(one.reference), one.mass) for one in TRAINING}
    assert not trained & {(id(one.reference), one.mass) for one in HELD_OUT}
    assert len({one.name for one in (*TRAINING, *HELD_OUT)}) == len(TRAINING) + len(HELD_OUT)


def test_no_law_is_judged_by_the_noise_that_it_was_tuned_for():
    training = {
        tuning.noise(trial, search)
        for tuning in study.tunings
        for trial in tuning.trials
        for search in range(len(tuning.seeds))
    }
    assert len(training) == len(TRAINING) * len(study.tunings[0].seeds)  # nor have two scenarios or searches one noise
    assert DRAW_SEED not in training


def test_the_error_of_the_step_is_the_largest_of_the_runs_that_were_run_again():
    held = costed(np.array([0.01, 0.02, 0.05]))
    assert cost_of({"a": held, "b": held}).errors == pytest.approx([0.05 / 0.5] * 2)  # RMSE, over 0.5 rad
    unbounded = costed(np.array([0.01, 0.02, np.nan]))
    assert np.isinf(cost_of({"a": held, "b": unbounded}).errors).tolist() == [False, True]


def test_the_other_searches_and_half_of_the_budget_are_what_their_names_say():
    found = tune(tuning(evaluations=32, seeds=(0, 1, 2)))
    own = found.place // 32
    second, third = sorted((k for k in range(3) if k != own), key=lambda k: found.bests[k])
    assert second_search(found) == found.best_of(found.tuning.seeds[second])
    assert third_search(found) == found.best_of(found.tuning.seeds[third])
    assert half_budget(found) == found.best_within(16)  # of 32 in each search


def costed(errors):
    """24 runs of which three were run again, with errors of the RMSE of joint 1; NaN where half of the step fails."""
    columns = tuple((term.metric, joint, term.unit) for term in TERMS for joint in (0, 1))
    values, off = np.ones((24, 1, 8)), np.zeros((3, 1, 8))
    off[:, 0, 0] = errors
    again, lost = np.array([0, 8, 16]), np.full(24, np.nan)
    return made_sample(
        "s", (), columns, np.ones(1), 1e-3, 0, "", np.empty((24, 0)), values, again, off, np.ones(3), lost
    )


@pytest.mark.release
def test_the_same_draws_reach_a_law_whatever_it_is_made_of(loops, equation):
    points = RNG.uniform(size=(3, 11))
    starts = []
    ablated = [(loop, loop.ode()) for loop in loops[PROPOSAL.key].ablations().values()]
    for loop, ode in (*((loops[one.key], equation(one.key)) for one in dict.fromkeys(REACHED)), *ablated):
        space = Space(uncertain(PAPER, loop), ode.parameters, ode.states)
        _, x0 = space.rows(points)
        states = ode.states
        starts.append(x0[:, list(states.indices("plant.q"))])
        for path in first_estimates(loop.loop.observer):  # the first estimate is the first reading
            np.testing.assert_array_equal(x0[:, list(states.indices(f"observer.{path}"))], starts[-1])
    assert all(np.array_equal(start, starts[0]) for start in starts)


@pytest.mark.parametrize("entrant", ENTRANTS[BOTH.key], ids=lambda one: one.key)
def test_behind_both_observers_each_law_counts_on_the_estimated_disturbance_once(entrant, loops):
    loop = loops[entrant.key].loop
    est = ca.SX.sym("d", 2)
    law, z = loop.controller, loop.controller.memory
    torque = law.torque(0.0, z.view(ca.SX(z.default)), Signals(q=ca.SX([0.1, 0.2]), qd=ca.SX([0.3, 0.4]), d=est), REST)
    np.testing.assert_allclose(np.array(ca.evalf(ca.jacobian(torque, est))), np.eye(2), atol=1e-12)


def test_late_is_the_second_half_of_a_run_or_of_each_level():
    t, e = ca.SX.sym("t"), ca.SX.sym("e", 2)
    for scenario, late in ((PAPER, [3.0, 5.9]), (JUMPS, [1.0, 1.9, 3.2, 5.5])):
        g = ca.Function("g", [t, e], [metrics(scenario)[1].integrand(t, {"e": e})])
        for time in np.arange(0.0, 6.0, 0.1):
            found = np.array(g(time, [2.0, 3.0])).ravel()
            expected = [4.0, 9.0] if _late(time, scenario.jumps) else [0.0, 0.0]
            np.testing.assert_array_equal(found, expected)
        assert all(_late(time, scenario.jumps) for time in late)


def _late(time, jumps):
    return time >= 3.0 if not jumps else int(time + 1e-9) % 2 == 1


def test_the_cost_is_the_sum_of_its_terms():
    columns = tuple((term.metric, joint, term.unit) for term in TERMS for joint in (0, 1))
    values = np.array([[[0.3, 0.4, 0.0, 0.01, 300.0, 400.0, 30.0, 40.0]]] * 2)
    held = made_sample(
        *("s", (), columns, np.ones(1), 1e-3, 0, "", np.empty((2, 0)), values),
        *(np.arange(0), values[:0], np.empty(0), np.full(2, np.nan)),
    )
    by_hand = sum(size / term.acceptable for size, term in zip((0.5, 0.01, 500.0, 50.0), TERMS, strict=True))
    np.testing.assert_allclose(cost(held), [by_hand] * 2)
    np.testing.assert_allclose(objective({"a": held, "b": held}), [by_hand] * 2)


@pytest.mark.parametrize("part", PARTS)
def test_a_law_without_a_part_is_tuned_for_each_number_that_still_acts_and_no_other(part):
    """By the equations: its torque over time depends on them, or those of its memories do."""
    one = RETUNED_ENTRANTS[part]
    loop = one.loop(PAPER, {number.name: 1.5 * number.low for number in one.tuned_numbers})
    equation = loop.ode()
    known = {*equation.parameters.names, *equation.states.names}
    for number in one.tuned_numbers:
        assert {path.split("[")[0] for path in number.paths} <= known
    names = {number.name for number in one.tuned_numbers}
    given = {number.name for number in PROPOSAL.tuned_numbers}
    assert names <= given
    if part == RICCATI:
        assert names == given - {"Q", "R"}
    if part == "adaptation of K":
        assert not names & {"P(0)", "Q", "R"}


def test_the_steady_gain_solves_34_with_a_derivative_of_zero():
    """Put back into the equation, with M(q) of a two-link arm of point masses written out by hand."""
    numbers = {one.name: (one.low * one.high) ** 0.5 for one in PROPOSAL.tuned_numbers}
    law = PROPOSAL.loop(PAPER, numbers).loop.controller
    (m1, m2), (l1, l2), c = CARD["masses"], CARD["lengths"], np.cos(PAPER.start[1])
    h = m2 * l1 * l2 * c
    M = np.array([[(m1 + m2) * l1**2 + m2 * l2**2 + 2 * h, m2 * l2**2 + h], [m2 * l2**2 + h, m2 * l2**2]])
    A, B = -np.linalg.solve(M, law.K), np.diag(law.Lambda)
    P = steady_gain(PAPER, numbers)
    left = A.T @ P + P @ A - P @ B @ np.linalg.solve(law.R, B.T @ P) + law.Q
    assert np.abs(left).max() < 1e-9 * np.abs(law.Q).max()  # rounding, and the condition of M
    assert np.linalg.eigvalsh(P).min() > 0


@pytest.mark.heavy
def test_runs_that_are_asked_for_again_are_run_in_both_ways_and_a_run_that_lasts_is_lost_by_nothing():
    (asmc,) = (one for one in ENTRANTS[READINGS.key] if one.name == "ASMC")  # which has memories that are stepped
    found = cause_of(LostRuns(HELD_OUT[0].name, asmc.key, (0, 3), ()))
    assert {way: lost.tolist() for way, lost in found.diverges.items()} == {"declared": [0, 0], "fine": [0, 0]}
    assert found.by_integrator == 2
    assert found.by_law == found.undecided_runs == 0
