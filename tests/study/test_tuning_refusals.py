"""Tunings, trials and searches that make no sense, or find nothing admissible, are refused with the reason."""

import numpy as np
import pytest

from tests.support.diverging_searches import Bomb, bomb
from tests.support.tunings import GAINS, DoubleIntegrator, quadratic, tuning
from workbench.engine.distributions import Normal
from workbench.engine.factors import Factor
from workbench.engine.metrics import effort, iae, ise
from workbench.study.run_and_sweep import Run
from workbench.study.tuning import Trial, equal_budget, tune

METRICS = (ise(), effort())


@pytest.mark.parametrize(
    ("asked", "reason"),
    [
        (bomb(1.5, 2.0), "the run in 'long' diverged in 80"),
        (tuning(objective=lambda runs: np.full(len(runs["step"]), np.inf)), "the objective is infinite in 80"),
    ],
)
def test_a_search_without_an_admissible_point_is_refused_with_the_reason(asked, reason):
    with pytest.raises(ValueError, match=rf"no admissible point among 80 at the step of 0.0.* s \({reason}\)"):
        tune(asked)


def test_a_search_whose_best_points_all_live_by_the_step_alone_is_refused():
    asked = bomb(1.007, 1.0135, objective=lambda runs: -runs["long"].factor_values[:, 0])
    with pytest.raises(ValueError, match=r"at half the step, 0.0025 s, .*finite at the step \(the run in 'long' div"):
        tune(asked)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"evaluations": 81}, "must be a multiple of the population, 8, so that every law gets the same"),
        ({"evaluations": 81}, "got 81: take 80 or 88."),
        ({"name": "a" * 80}, "_half' of 90 letters"),
        ({"evaluations": 3}, "got 3: take 8."),
        ({"population": 3}, "at least 4, which make a new point; got 3"),
        ({"evaluations": 0}, "positive whole number"),
        ({"seeds": ()}, "at least one seed"),
        ({"seeds": (1, 1)}, "each once"),
        ({"seeds": (-1,)}, "2^64"),
        ({"seeds": 3}, "a tuple of `int`; got 3: one alone is written `(...,)`"),
        ({"trials": ()}, "at least one trial"),
        ({"factors": ()}, "at least one factor"),
        ({"factors": (GAINS[0], GAINS[0])}, "each of another name"),
        ({"factors": (Factor("Kp", ("Kp",), Normal(1.0, 0.1)),)}, "two ends"),
        ({"objective": 3.0}, "must be a function; got 3.0"),
        ({"name": "P D"}, "a-z, 0-9 and _"),
    ],
)
def test_a_tuning_that_makes_no_sense_is_refused(changes, said):
    with pytest.raises(ValueError) as refusal:
        tuning(**changes)
    assert said in str(refusal.value)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"h": 0.0}, "`Run(h=...)` must be a positive"),
        ({"until": 0.055}, "must be a multiple of `h`, 0.01 s; got 0.055 s"),
        ({"metrics": (3,)}, "`Run(metrics=...)` must be a tuple of `AbstractMetric`; got 3"),
        ({"name": "a/b"}, "`Trial(name)` must be made of a-z"),
    ],
)
def test_a_trial_that_makes_no_sense_is_refused(changes, said):
    run = {"loop": DoubleIntegrator(), "metrics": METRICS, "h": 0.01, "until": 20.0} | changes
    name = run.pop("name", "step")
    with pytest.raises(ValueError) as refusal:
        Trial(name, Run(**run))
    assert said in str(refusal.value)


def test_a_factor_that_one_trial_lacks_is_refused_with_the_trial():
    trials = (*tuning().trials, Trial("bomb", Run(Bomb(), (iae(),), 1.0, h=0.01)))
    with pytest.raises(LookupError, match=r"in the trial 'bomb': There is no 'Kp', which 'Kp' varies"):
        tune(tuning(trials=trials))


@pytest.mark.parametrize(
    ("objective", "said"),
    [
        (lambda runs: 1.0, "(8,), one number for each of the points; got ()"),
        (lambda runs: runs["step"].values[:, -1], "(8,), one number for each of the points; got (8, 2)"),
        (lambda runs: np.full(8, np.nan), "got nan at Kp = "),
        (lambda runs: np.full(8, -np.inf), "got -inf at Kp = "),
        (lambda runs: "good", "must be a vector of numbers; got 'good'"),
        (lambda runs: quadratic(runs) / quadratic(runs).mean(), "must judge each point by its own runs; among all 80"),
    ],
)
def test_an_objective_that_says_nothing_of_a_point_is_named(objective, said):
    with pytest.raises(ValueError) as refusal:
        tune(tuning(objective=objective))
    assert str(refusal.value).startswith("`Tuning('pd', objective=...)` must ")
    assert said in str(refusal.value)


def test_all_laws_get_the_same_budget_or_are_refused():
    trial = tuning().trials[0]
    slower = Trial("step", Run(DoubleIntegrator(), METRICS, 20.0, h=0.005))
    budget = {"evaluations": 80, "population": 8, "seeds": (0, 1)}
    first, second = equal_budget({"a": ((trial,), GAINS), "b": ((trial,), GAINS[:1])}, quadratic, **budget)
    assert (first.size, first.objective, first.seeds) == (second.size, second.objective, second.seeds)
    with pytest.raises(ValueError, match=r"the same trials for every law; 'b' has 'step' .* h = 0.01 s"):
        equal_budget({"a": ((trial,), GAINS), "b": ((slower,), GAINS)}, quadratic, **budget)
    with pytest.raises(ValueError, match="'b' has 'step' .*; 'long' .*, and 'a' has 'step'"):
        equal_budget({"a": ((trial,), GAINS), "b": ((trial, bomb(0, 1).trials[0]), GAINS)}, quadratic, **budget)
