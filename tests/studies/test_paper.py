"""What the paper's study rests on: its loops, run alone."""

from functools import cache

import numpy as np
import pytest

from studies.a1_paper_tables.repairs import with_small_q, with_two_repairs
from studies.a1_paper_tables.six_laws import firm, reaching_time
from studies.a1_paper_tables.study import study
from studies.paper.card import CARD, PUBLISHED_COLUMNS
from studies.paper.comparison import comparison
from studies.paper.laws import ARM, proposed_as_printed, proposed_repaired
from workbench.arms.laws import AosmcRgs
from workbench.arms.mechanics import paper_arm
from workbench.engine import simulate, step_limit
from workbench.engine.metrics import rmse, sampled_rmse, step_with_metrics
from workbench.engine.metrics.accumulators import final_values
from workbench.study.case_runs import run
from workbench.study.run_and_sweep import Run
from workbench.study.study import Case, Study

H = 1e-3 / 12  # s, below the limit of 0.094 ms that the gains of the repaired law set
LONG = CARD["FS: horizon"]
PRINTED = sampled_rmse(CARD["sample time of (43)"])


def gain_and_errors(loop, h=1e-4):
    """The smallest eigenvalue of the symmetric part of K (N,), and the largest late |e| of either joint."""
    runs = simulate(step_with_metrics(loop.ode(), (), h), until=LONG, every=0.01)
    K = runs["controller.K"][0]
    return np.linalg.eigvalsh((K + K.transpose(0, 2, 1)) / 2)[:, 0], np.abs(runs["e"][0, runs.t >= 5]).max(axis=0)


@cache
def repaired():
    """The repaired law in the first scenario."""
    return simulate(step_with_metrics(proposed_repaired("FS").ode(), (PRINTED,), H), until=LONG, every=0.01)


def test_the_repaired_law_meets_the_printed_rmse_of_the_first_scenario():
    """The published pair is (0.3538, 0.3542), first table of section 5; the paper prints four digits."""
    values = final_values(repaired(), (PRINTED,))[PRINTED.name][0]
    printed = [PUBLISHED_COLUMNS["FS", joint].values["AOSMC-RGS"] for joint in (1, 2)]
    np.testing.assert_allclose(values, printed, rtol=0.02)  # 2 %, as asked; it comes within 0.2 %
    assert step_limit(repaired()).holds


def test_the_repaired_law_keeps_its_gain_positive_and_comes_back_to_the_path():
    K = repaired()["controller.K"][0]
    assert np.linalg.eigvalsh((K + K.transpose(0, 2, 1)) / 2).min() > 0
    # 0.13 rad is what the bias of observer (10) leaves, which ignores the disturbance
    assert np.abs(repaired()["e"][0, repaired().t > 5]).max() < 0.13


@pytest.mark.parametrize("scenario", ["FS", "SS"])
def test_the_law_as_printed_loses_its_positive_gain_and_then_the_path(scenario):
    runs = simulate(step_with_metrics(proposed_as_printed(scenario).ode(), (), 1e-4), until=10.0, every=0.01)
    assert runs.has_diverged[0]
    K = runs["controller.K"][0]
    alive = np.isfinite(K).all(axis=(1, 2))
    floor = np.linalg.eigvalsh((K + K.transpose(0, 2, 1))[alive] / 2)[:, 0]
    assert 0 < runs.t[alive][floor <= 0][0] < runs.diverged_at[0]


@pytest.mark.parametrize("shape", ["outer", pytest.param("elementwise", marks=pytest.mark.heavy)])
def test_with_a_small_q_the_printed_law_keeps_its_gain_positive_and_misses_the_path_all_the_same(shape):
    floor, late = gain_and_errors(with_small_q(shape))
    assert floor.min() > 2.5
    assert 1 < late.min() < late.max() < 2.5  # rad


@pytest.mark.parametrize("Q", [0.01, 1.0])
def test_with_3_and_28_repaired_alone_the_law_tracks_with_the_minus_as_printed(Q):
    loop = with_two_repairs("outer", Q)
    assert loop.controller.gain_sign == "printed"
    floor, late = gain_and_errors(loop)
    assert floor.min() > 1.8  # N m, of 5 at the start
    assert late.max() < 0.13  # rad, as with all four slips repaired


def test_smc_reaches_its_layer_only_after_seconds_with_the_assumed_gain_and_at_once_with_a_firm_one():
    loops = {"assumed": firm("FS", float(CARD["SMC: K"][0])), "firm": firm("FS", 50.0)}
    cases = tuple(Case("FS", law, Run(loop, (rmse(),), 4.0, 0.01, 2.5e-5)) for law, loop in loops.items())
    for outcome in run(Study("s", "t", "q", "m", lambda results: (), cases=cases)).outcomes:
        s = np.abs(outcome.measurement.trajectories["s"][0])
        at = reaching_time(outcome)
        assert ((s[outcome.t <= at] < CARD["phi"]).any(axis=0)).all()
        assert not ((s[outcome.t < at - 1e-9] < CARD["phi"]).any(axis=0)).all()
        assert (at > 3) if outcome.case.law == "assumed" else (at < 0.5)


def test_the_arm_of_the_card_is_the_one_of_the_catalogue():
    ours, known = ARM, paper_arm()
    assert [(p.mass, p.length) for p in ours.links] == [(p.mass, p.length) for p in known.links]
    assert ours.gravity == known.gravity


def test_the_proposed_law_is_marked_as_using_the_truth_and_no_rival_is():
    for case in study.cases:
        assert case.run.loop.observer.uses_truth == isinstance(case.run.loop.controller, AosmcRgs)
    for case in comparison("FS"):
        assert bool(case.run.loop.ode().notes) == isinstance(case.run.loop.controller, AosmcRgs)
