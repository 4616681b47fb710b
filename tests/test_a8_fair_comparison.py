"""What a8 compares: the same conditions for all laws, numbers that reach them, and verdicts that turn with figures."""

import sys
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "studies"))

import fair_findings as findings
from a8_fair_comparison import SEED, study
from fair_conditions import HELD_OUT, TRAINING, uncertain
from fair_evidence import FAMILY, RESAMPLES, cost_of, judged, of_other_search
from fair_laws import ENTRANTS, MAIN, OBSERVED, PROPOSALS, PROPOSED, TOLD
from fair_objective import TERMS, cost, metrics, objective
from tunings import tuning

from workbench.core import lift
from workbench.study.evidence import compare, paired
from workbench.study.factors import Space
from workbench.study.sample import Sample
from workbench.study.tuning import tune

PAPER, JUMPS = HELD_OUT[0], next(one for one in HELD_OUT if one.jumps)
RNG = np.random.default_rng(5)
BASE = np.abs(RNG.normal(size=60)) + 1


@pytest.mark.parametrize("entrant", ENTRANTS, ids=lambda one: one.key)
def test_a_number_reaches_the_loop_by_its_paths_as_by_its_name(entrant):
    """The search sets numbers by paths; the law that is judged is built from the same numbers by name."""
    u = np.linspace(0.2, 0.8, len(entrant.tuned))
    searched = entrant.loop(PAPER, entrant.card).ode()
    space = Space(entrant.factors, searched.parameters, searched.states)
    p, x0 = space.rows(u[None])
    x = dict(zip((one.name for one in entrant.tuned), space.values(u[None])[0], strict=True))
    judged = entrant.loop(PAPER, x).ode()
    assert (judged.parameters.names, judged.states.names) == (searched.parameters.names, searched.states.names)
    np.testing.assert_allclose(judged.parameters.default, p[0], rtol=1e-15)
    np.testing.assert_allclose(judged.states.default, x0[0], rtol=1e-15)


@pytest.mark.parametrize("scenario", [*TRAINING, *HELD_OUT], ids=lambda one: one.name)
def test_all_laws_face_the_same_arm_and_the_same_instruments(scenario):
    loops = [entrant.loop(scenario, entrant.card) for entrant in ENTRANTS]
    arms = [lift(loop.loop.plant).layout.default for loop in loops]
    instruments = [lift(loop.instruments).layout.default for loop in loops]
    for loop, arm, reading in zip(loops, arms, instruments, strict=True):
        np.testing.assert_array_equal(arm, arms[0])
        np.testing.assert_array_equal(reading, instruments[0])
        assert (loop.period, loop.delay, loop.loop.reference) == (loops[0].period, loops[0].delay, scenario.reference)


def test_only_the_law_that_is_told_uses_the_truth():
    told = [one.name for one in ENTRANTS if one.loop(PAPER, one.card).loop.uses_truth]
    assert told == [TOLD]


def test_nobody_is_judged_where_it_was_tuned():
    trained = {(id(one.reference), one.mass) for one in TRAINING}
    assert not trained & {(id(one.reference), one.mass) for one in HELD_OUT}
    assert len({one.name for one in (*TRAINING, *HELD_OUT)}) == len(TRAINING) + len(HELD_OUT)


def test_no_law_is_judged_by_the_noise_that_it_was_tuned_for():
    training = {trial.seed for tuning in study.tunings for trial in tuning.trials}
    assert len(training) == len(TRAINING)  # nor is the noise of both scenarios one
    assert SEED not in training


def test_the_error_of_the_step_is_the_largest_of_the_runs_that_were_run_again():
    held = costed(np.array([0.01, 0.02, 0.05]))
    assert cost_of({"a": held, "b": held}, "cost").errors == pytest.approx([0.05 / 0.5] * 2)  # RMSE, over 0.5 rad
    unbounded = costed(np.array([0.01, 0.02, np.nan]))
    assert np.isinf(cost_of({"a": held, "b": unbounded}, "cost").errors).tolist() == [False, True]


def test_the_other_search_is_not_the_one_of_the_best_and_is_refused_if_it_found_nothing():
    found = tune(tuning(evaluations=16, seeds=(0, 1)))
    own = found.place // 16
    other = 1 - own
    at = 16 * other + int(np.argmin(found.objectives[16 * other : 16 * other + 16]))
    assert list(of_other_search(found).values()) == found.numbers[at].tolist()
    lost = np.where(np.arange(32) // 16 == own, found.objectives, np.inf)
    with pytest.raises(ValueError, match="The other search of 'pd' found no admissible point"):
        of_other_search(replace(found, objectives=lost))


def costed(errors):
    """24 runs of which three were run again, with errors of the RMSE of joint 1; NaN where half of the step fails."""
    columns = tuple((term.metric, joint, term.unit) for term in TERMS for joint in (0, 1))
    values, off = np.ones((24, 1, 8)), np.zeros((3, 1, 8))
    off[:, 0, 0] = errors
    again, lost = np.array([0, 8, 16]), np.full(24, np.nan)
    return Sample("s", (), columns, np.ones(1), 1e-3, 0, "", np.empty((24, 0)), values, again, off, np.ones(3), lost)


def test_intervals_of_all_scenarios_hold_at_once():
    values = paired({"a": BASE, "b": 1.001 * BASE}, metric="cost")
    one = judged(values)
    assert len(HELD_OUT) * (1 - one.confidence) == pytest.approx(1 - FAMILY)  # the union bound
    alone = compare(values, confidence=FAMILY, resamples=RESAMPLES, seed=88)
    assert (one.level.low < alone.level.low).all()
    assert (one.level.high > alone.level.high).all()


def test_the_same_draws_reach_a_law_whatever_it_is_made_of():
    points = RNG.uniform(size=(3, 11))
    loops = [one.loop(PAPER, one.card) for one in MAIN[:2]]
    loops += PROPOSALS[0].loop(PAPER, PROPOSALS[0].card).ablations().values()
    starts = []
    for loop in loops:
        equation = loop.ode()
        space = Space(uncertain(PAPER, loop), equation.parameters, equation.states)
        _, x0 = space.rows(points)
        states = equation.states
        starts.append(x0[:, list(states.indices("plant.q"))])
        for path in loop.estimates:  # the first estimate is the first reading
            np.testing.assert_array_equal(x0[:, list(states.indices(path))], starts[-1])
    assert all(np.array_equal(start, starts[0]) for start in starts)


def test_behind_the_observers_a_law_counts_on_the_estimated_disturbance():
    entrant = OBSERVED[0]
    loop = entrant.loop(PAPER, entrant.card).loop
    ode, x = loop.ode(), RNG.uniform(-1, 1, loop.ode().states.size)
    y = ode.outputs_at(0.3, x)
    bare = type(loop)(loop.plant, loop.observer, loop.controller.law, loop.reference).ode().outputs_at(0.3, x)
    np.testing.assert_allclose(y["tau"] - bare["tau"], y["d"] - y["d_error"], atol=1e-12)  # D_hat


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
    held = Sample(
        *("s", (), columns, np.ones(1), 1e-3, 0, "", np.empty((2, 0)), values),
        *(np.arange(0), values[:0], np.empty(0), np.full(2, np.nan)),
    )
    by_hand = sum(size / term.acceptable for size, term in zip((0.5, 0.01, 500.0, 50.0), TERMS, strict=True))
    np.testing.assert_allclose(cost(held), [by_hand] * 2)
    np.testing.assert_allclose(objective({"a": held, "b": held}), [by_hand] * 2)


def held(**shares):
    """A comparison for each scenario: each law's cost as a share of the same draws; None for a law that fails."""
    return {
        scenario: compare(
            paired({law: np.full(60, np.nan) if s is None else s * BASE for law, s in laws.items()}, metric=scenario),
            margin=0.02,
        )
        for scenario, laws in shares.items()
    }


WINS, LOSES = {PROPOSED: 1.0, "SMC": 2.0, "PID": 3.0}, {PROPOSED: 2.0, "SMC": 1.0, "PID": 3.0}
TIED, FAILS = {PROPOSED: 1.0, "SMC": 1.001, "PID": 3.0}, {PROPOSED: None, "SMC": 1.0, "PID": 1.0}


@pytest.mark.parametrize(
    ("figures", "mostly", "everywhere"),
    [
        ({"a": WINS, "b": WINS}, "holds", "holds"),
        ({"a": WINS, "b": TIED}, "holds", "open"),
        ({"a": WINS, "b": WINS, "c": LOSES}, "holds", "fails"),
        ({"a": WINS, "b": LOSES}, "open", "fails"),
        ({"a": LOSES, "b": TIED}, "fails", "fails"),
        ({"a": TIED, "b": TIED}, "open", "open"),
        ({"a": WINS, "b": FAILS}, "holds", "fails"),
    ],
)
def test_who_wins_follows_from_the_figures(figures, mostly, everywhere):
    found = held(**figures)
    assert findings.mostly(found, PROPOSED).kind == mostly
    assert findings.everywhere(found, PROPOSED, "cost").kind == everywhere
    assert findings.by_its_law(found, PROPOSED).kind == everywhere


def test_a_failed_run_is_told_by_scenario():
    assert findings.fails_nowhere(held(a=WINS), PROPOSED).kind == "holds"
    found = findings.fails_nowhere(held(a=WINS, b=FAILS), PROPOSED)
    assert found.kind == "fails"
    assert "60 of 60 in 'b'" in str(found.evidence)


@pytest.mark.parametrize(("other", "kind"), [({"a": WINS}, "holds"), ({"a": LOSES}, "fails"), ({"a": TIED}, "open")])
def test_the_winner_of_one_search_is_held_against_that_of_the_other(other, kind):
    assert findings.whichever_search(held(a=WINS, b=LOSES), held(**other)).kind == kind


@pytest.mark.parametrize(
    ("less", "kind", "words"),
    [(1.5, "holds", "cost rises without part"), (1.001, "fails", "less than 2 %"), (0.5, "fails", "cost falls")],
)
def test_a_part_matters_only_where_the_cost_rises_without_it(less, kind, words):
    found = findings.parts_matter(held(a={PROPOSED: 1.0, "part": less}), PROPOSED)
    assert found.kind == kind
    assert words in str(found.evidence)
