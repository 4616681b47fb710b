"""Searches of a tuning: where they begin and may go, when they end, and what training noise does to them."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.arms import arm_instruments
from tests.support.tunings import GAINS, HORIZON, DoubleIntegrator, quadratic, tuning
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines
from workbench.engine.distributions import LogUniform, Triangular, Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import effort, ise, rmse
from workbench.study.run_and_sweep import Run
from workbench.study.tuning import Trial, Tuning, equal_budget, tune
from workbench.study.tuning.search import compile_tuning
from workbench.study.tuning.tuning import population_of

FAR = tuple(Factor(name, (name,), LogUniform(1e-6, 1e4)) for name in ("Kp", "Kd"))
LOW = {"Kp": (1e-5, 1e-3), "Kd": (1e-5, 1e-3)}  # three decades and more below the best, Kp = 1 and Kd = sqrt(2)
SMOOTH = (Trial("step", Run(DoubleIntegrator(), (ise(), effort()), HORIZON, h=0.01)),)
STIFFER = tuple(Factor(name, (f"controller.{name}[0]",), LogUniform(10.0, 200.0)) for name in ("Kp", "Kd"))


class Arm:
    """The paper's arm under PID control by a computer, on noisy readings."""

    def ode(self, name="loop"):
        """The loop between instants, and at them."""
        plant, law = Manipulator(paper_arm(), q=[0.5, -0.5]), ArmPID(Kp=[60.0, 40.0], Ki=[20.0, 10.0], Kd=[10.0, 8.0])
        loop = ClosedLoop(plant, ArmFullState(2), law, Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]))
        return loop.digital(2e-3, arm_instruments(2, noise_q=1e-3, noise_qd=0.3, limit=40.0), name=name)


def shaken(**changes):
    """A short search on noisy readings."""
    trials = (
        Trial("run", Run(Arm(), (rmse(),), 0.4, h=1e-3, seed=3)),
        Trial("other", Run(Arm(), (rmse(),), 0.2, h=1e-3, seed=4)),
    )
    declared = {"trials": trials, "evaluations": 48, "population": 8, "seeds": (5, 6)}
    return Tuning(name="shaken", factors=STIFFER, objective=wander, **(declared | changes))


def wander(runs):
    """RMSE of joint 1 over all trials."""
    return np.sum([run.score("RMSE").value for run in runs.values()], axis=0)


@pytest.fixture(scope="module")
def noisy():
    """What two searches under their own noises find."""
    return tune(shaken())


def bowl(runs):
    """Least, 1, at Kp = 1 and Kd = sqrt(2), by the squares of their distances in decades."""
    decades = np.log10(runs["step"].factor_values / [1.0, np.sqrt(2)])
    return 1 + (decades**2).sum(axis=1)


def quick(name="step"):
    """A trial of which only the numbers count."""
    return (Trial(name, Run(DoubleIntegrator(), (ise(), effort()), 0.02, h=0.01)),)


def test_an_optimum_three_decades_beyond_the_start_is_found():
    found = tune(tuning(trials=quick(), objective=bowl, factors=FAR, starts=LOW, evaluations=480, population=16))
    assert (found.numbers[:16] >= 1e-5).all()
    assert (found.numbers[:16] <= 1e-3).all()
    assert list(found.best.values()) == pytest.approx([1.0, np.sqrt(2)], rel=1e-2)  # 4e-5 of the objective
    assert (found.at_edge, found.at_physical, found.has_settled, found.warnings) == ((), {}, (True,), ())


@pytest.mark.parametrize("seed", range(4))
def test_the_gains_of_a_double_integrator_are_found_two_decades_beyond_the_start(seed):
    start = {"Kp": (1e-3, 1e-2), "Kd": (1e-3, 1e-2)}
    found = tune(tuning(factors=FAR, starts=start, evaluations=480, population=16, seeds=(seed,)))
    assert found.objective == pytest.approx(np.sqrt(2), rel=1e-3)


def test_an_optimum_at_a_limit_is_flagged_and_a_physical_limit_told_apart():
    near = (Factor("Kp", ("Kp",), LogUniform(1e-4, 0.1)), Factor("Kd", ("Kd",), LogUniform(1e-4, 0.1)))
    found = tune(
        tuning(factors=near, starts={"Kp": (1e-3, 1e-2)}, evaluations=160, physical={("Kd", "high"): "a stop"})
    )
    assert (found.at_edge, found.at_physical) == (("Kp",), {"Kd": "a stop"})
    assert "The best 'Kp' lies at the high end of its range." in found.warnings
    assert not any("'Kd'" in said for said in found.warnings)
    assert "'Kd' is at a physical limit: a stop" in found.note
    elsewhere = replace(found, tuning=replace(found.tuning, physical={("Kd", "low"): "a stop"}))
    assert elsewhere.at_edge == ("Kp", "Kd")


@pytest.mark.parametrize("spread", [Uniform(0.5, 5.0), LogUniform(0.5, 5.0), Triangular(0.5, 1.0, 5.0)])
def test_a_start_is_that_of_any_distribution_to_the_last_digits(spread):
    low, high = compile_tuning(tuning(factors=(Factor("Kp", ("Kp",), spread),), starts={"Kp": (0.7, 5.0)})).start
    assert spread.quantile(low) == pytest.approx(0.7, rel=1e-12)
    assert high[0] == 1.0


def test_a_search_ends_once_it_has_settled_and_not_before_it_may():
    whole = tune(tuning(evaluations=320, seeds=(0, 1)))
    found = tune(tuning(evaluations=320, seeds=(0, 1), settle=0.3))
    assert whole.evaluations == (320, 320)
    for early, late, used in zip(found.searches, whole.searches, found.evaluations, strict=True):
        assert 96 <= used < 320
        np.testing.assert_array_equal(early.bests, late.bests[: used // 8])
        gains = early.bests[:-10] / early.bests[10:] - 1  # over ten generations, a quarter of forty
        assert gains[-1] <= 0.01  # it has settled ...
        assert (gains[max(0, 12 - 10 - 1) : -1] > 0.01).all()  # ... and had not before, since it might have ended
    assert found.has_settled == (True, True)
    assert len(found.points) == sum(found.evaluations) == len(found.samples["step"])
    assert found.note.startswith(
        f"The 2 searches used {found.evaluations[0]} and {found.evaluations[1]} of at most 320 evaluations, 160 for "
        "each tuned number;"
    )


def test_a_search_that_has_not_settled_has_all_its_evaluations_and_is_marked():
    asked = tuning(trials=quick(), objective=bowl, factors=FAR, starts=LOW, evaluations=128, settle=0.5)
    found = tune(replace(asked, population=16))
    assert (found.evaluations, found.has_settled) == ((128,), (False,))
    assert any("The search of seed 0 became better by" in said and "has not settled" in said for said in found.warnings)


@pytest.fixture(scope="module")
def alone():
    """What each of the two searches finds by itself, in the noise that it has beside the other."""
    moved = tuple(replace(trial, run=replace(trial.run, seed=trial.run.seed + 1000)) for trial in shaken().trials)
    return tune(shaken(seeds=(5,))), tune(shaken(seeds=(6,), trials=moved))


def test_each_search_has_a_training_noise_of_its_own(noisy, alone):
    seeds = [
        [trial.run.seed for trial in compile_tuning(shaken()).under(compile_tuning(shaken()).trials, k)] for k in (0, 1)
    ]
    assert seeds == [[3, 4], [1003, 1004]]
    for k, one in enumerate(alone):
        np.testing.assert_array_equal(one.objectives, noisy.objectives[48 * k : 48 * (k + 1)])


def test_the_winner_is_the_least_mean_over_the_noises_of_all_searches(noisy):
    assert noisy.finals.shape == noisy.finals_at_half_step.shape == (16, 2)
    np.testing.assert_array_equal(noisy.finals.T.ravel(), wander(noisy.final_samples))
    row = list(noisy.finalists).index(noisy.place)
    assert noisy.objective == noisy.finals[row].mean() == noisy.finals.mean(axis=1).min()
    assert noisy.spread == abs(np.diff(noisy.finals[row])[0]) > 0
    assert "a noise of its own, with seeds 1000 apart. Under the 2 noises the best objective varies by" in noisy.note


def test_the_best_of_one_search_is_that_of_it_alone(noisy, alone):
    assert [noisy.best_of(seed) for seed in (5, 6)] == [one.best for one in alone]
    with pytest.raises(LookupError, match="There is no '7' among the 2 searches of 'shaken' by their seeds"):
        noisy.best_of(7)
    lost = np.where(np.arange(16)[:, None] < 8, np.inf, noisy.finals_at_half_step)
    with pytest.raises(ValueError, match=r"`best_of\(5\)`: this search of 'shaken' has no admissible point at half"):
        replace(noisy, finals_at_half_step=lost).best_of(5)


def test_the_best_within_a_smaller_budget_is_among_the_first_points_of_each_search(noisy):
    first = np.r_[0:24, 48:72]
    place = first[np.argmin(noisy.objectives[first])]
    assert list(noisy.best_within(24).values()) == noisy.numbers[place].tolist()
    assert list(noisy.best_within(10**6).values()) == noisy.numbers[np.argmin(noisy.objectives)].tolist()
    with pytest.raises(ValueError, match=r"`best_within\(2\)`: no search of 'shaken' has an admissible point"):
        replace(noisy, objectives=np.where(np.arange(96) % 48 < 2, np.inf, noisy.objectives)).best_within(2)
    with pytest.raises(ValueError, match="positive whole number"):
        noisy.best_within(0)


def test_without_noise_the_best_points_are_run_again_once():
    found = tune(tuning(seeds=(0, 1)))
    assert (found.finals.shape, found.spread) == ((16, 1), 0.0)
    assert "noise" not in found.note


def test_a_winner_that_depends_on_the_noise_is_said_to(noisy):
    said = replace(noisy, finals=noisy.finals * [1.0, 1.2]).warnings
    assert any("The best objective varies by" in one and "with the training noise" in one for one in said)


def test_a_budget_may_be_one_per_number_in_whole_populations():
    trials = tuning().trials
    laws = {"two": (trials, GAINS), "one": (trials, GAINS[:1])}
    starts, stops = {"two": {"Kp": (1.0, 2.0)}}, {"one": {("Kp", "low"): "zero"}}
    two, one = equal_budget(laws, quadratic, evaluations_per_number=50, settle=0.5, starts=starts, physical=stops)
    assert (two.population, two.evaluations, one.population, one.evaluations) == (16, 112, 16, 64)
    assert (two.evaluations_per_number, one.evaluations_per_number) == (56, 64)
    assert (two.starts, one.starts, two.settle, one.settle) == ({"Kp": (1.0, 2.0)}, {}, 0.5, 0.5)
    assert (two.physical, one.physical) == ({}, {("Kp", "low"): "zero"})
    assert [population_of(d) for d in (1, 4, 5, 8, 9, 12)] == [16, 16, 24, 24, 32, 32]


@pytest.mark.parametrize(
    ("changes", "error", "said"),
    [
        ({}, ValueError, "takes either `evaluations` or `evaluations_per_number`; got none."),
        ({"evaluations": 80, "evaluations_per_number": 40.0}, ValueError, "got both."),
        ({"evaluations_per_number": -1.0}, ValueError, "positive"),
        ({"evaluations": 80, "population": 8, "starts": {"c": {}}}, LookupError, "no 'c' among the 1 laws of"),
        ({"evaluations": 80, "population": 8, "physical": {"c": {}}}, LookupError, "no 'c' among the 1 laws of"),
    ],
)
def test_a_budget_that_makes_no_sense_is_refused(changes, error, said):
    with pytest.raises(error) as refusal:
        equal_budget({"a": (tuning().trials, GAINS)}, quadratic, **changes)
    assert said in str(refusal.value)


@pytest.mark.parametrize(
    ("changes", "error", "said"),
    [
        ({"starts": {"kp": (1.0, 2.0)}}, LookupError, "There is no 'kp' among the 2 factors"),
        ({"starts": {"Kp": (2.0, 1.0)}}, ValueError, "low < high, within the limits"),
        ({"starts": {"Kp": (0.01, 1.0)}}, ValueError, "that of 'Kp' is 0.01 to 1, and its limits are log-uniform, 0.1"),
        ({"starts": {"Kp": (np.nan, 1.0)}}, ValueError, "low < high, within the limits"),
        ({"physical": {("K", "low"): "zero"}}, LookupError, "There is no 'K' among the 2 factors"),
        ({"physical": {("Kp", "left"): "zero"}}, LookupError, "There is no 'left' among the 2 ends of a range"),
        ({"physical": {("Kp", "low"): ""}}, ValueError, "at the low end of 'Kp'"),
        ({"settle": 1.5}, ValueError, "a finite number, a share of the evaluations, at least 0, at most 1; got 1.5"),
    ],
)
def test_limits_that_make_no_sense_are_refused(changes, error, said):
    with pytest.raises(error) as refusal:
        tuning(**changes)
    assert said in str(refusal.value)


def test_a_noise_beyond_the_seeds_is_refused_before_the_search():
    trial = replace(SMOOTH[0], run=replace(SMOOTH[0].run, seed=2**64 - 1))
    with pytest.raises(ValueError, match="the noise of the last search in 'step'"):
        tuning(trials=(trial,), seeds=(0, 1))
