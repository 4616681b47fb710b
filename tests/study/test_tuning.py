"""Tuning: the search finds what a Riccati equation knows, within its budget, and says where it is in doubt."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from tests.support.diverging_searches import bomb
from tests.support.samples import with_measurement
from tests.support.sweeps import Explosion
from tests.support.tunings import GAINS, DoubleIntegrator, quadratic, tuning
from workbench.core import Entry, Layout, Ode
from workbench.engine.distributions import LogUniform, Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import effort, iae, ise, total_variation
from workbench.study import study_cost
from workbench.study.run_and_sweep import Run
from workbench.study.tuning import Trial, tune
from workbench.study.tuning.convergence import reasons_of
from workbench.study.tuning.search import compile_tuning, here

METRICS = (ise(), effort())


@pytest.fixture(scope="module")
def found():
    """What two searches of forty generations find."""
    return tune(tuning(evaluations=640, population=16, seeds=(0, 1)))


def test_the_best_gains_of_a_double_integrator_are_those_of_its_riccati_equation(found):
    P = solve_continuous_are(np.array([[0.0, 1], [0, 0]]), np.array([[0.0], [1]]), np.diag([1.0, 0]), np.eye(1))
    assert found.objective == pytest.approx(P[0, 0], rel=1e-5)  # from above: nothing is better
    assert found.objective >= P[0, 0] * (1 - 1e-9)  # what RK4 at 10 ms and the end after 20 s leave out
    # the objective is flat there: 1e-5 of it are some 3e-3 of the gains
    assert [found.best["Kp"], found.best["Kd"]] == pytest.approx(P[1], rel=1e-2)
    assert (found.failures, found.at_edge, found.has_settled, found.warnings) == (0, (), (True, True), ())


def test_every_search_looks_at_exactly_as_many_points_as_its_budget_has(found):
    assert found.points.shape == (1280, 2)
    assert {len(one) for one in found.samples.values()} == {1280}
    assert [one.seed for one in found.searches] == [0, 1]
    for one in found.searches:
        assert one.evaluations.tolist() == list(range(16, 641, 16))
        assert (np.diff(one.bests) <= 0).all()
    assert found.bests.min() == found.objectives.min() == min(one.bests[-1] for one in found.searches)
    assert not np.array_equal(found.points[:16], found.points[640:656])


def test_the_objectives_are_those_of_the_runs_that_are_kept(found):
    np.testing.assert_array_equal(found.objectives, quadratic(found.samples))
    np.testing.assert_array_equal(found.finals[:, 0], quadratic(found.final_samples))
    np.testing.assert_array_equal(found.finals[:, 0], found.objectives[found.finalists])
    np.testing.assert_array_equal(found.samples["step"].factor_values, found.numbers)


def test_the_same_seed_gives_the_same_bits_and_whoever_computes_them():
    alone = tune(tuning(), lambda sweeps, first, last: [_one_by_one(one, first, last) for one in sweeps])
    again = tune(tuning())
    assert alone.points.tobytes() == again.points.tobytes()
    assert alone.objectives.tobytes() == again.objectives.tobytes()
    assert alone.best == again.best
    assert tune(tuning(seeds=(1,))).best != again.best


def _one_by_one(one, first, last):
    """The runs of a chunk, each in a march of its own."""
    from workbench.study.ledger.chunk import chunk_of

    parts = [one.chunk(i, i + 1).arrays() for i in range(first, last)]
    return chunk_of(one.name(first, last), {key: np.concatenate([part[key] for part in parts]) for key in parts[0]})


def test_the_best_numbers_go_into_any_loop_that_has_their_places(found):
    other = found.best_equations(DoubleIntegrator(start=2.0))
    assert dict(zip(other.parameters.names, other.parameters.default, strict=True)) == found.best
    assert other.states.default.tolist() == [2.0, 0.0]
    with pytest.raises(LookupError, match="There is no 'Kp', which 'Kp' varies"):
        found.best_equations(Explosion())


def test_shares_are_those_of_the_numbers_of_each_loop():
    share = Factor("gains", ("Kp", "Kd"), Uniform(1.0, 4.0), share=True)
    found = tune(tuning(factors=(share,)))
    expected = 0.5 * found.best["gains"]
    assert found.best_equations(DoubleIntegrator()).parameters.default.tolist() == [expected, expected]


def test_all_trials_have_their_say():
    trials = tuple(
        Trial(name, Run(DoubleIntegrator(start), METRICS, 20.0, h=0.01)) for name, start in (("a", 1), ("b", 3))
    )
    found = tune(tuning(trials=trials))
    # the loop is linear: the cost of the second is nine times that of the first, to rounding
    np.testing.assert_allclose(
        found.samples["b"].score("ISE").value, 9 * found.samples["a"].score("ISE").value, rtol=1e-12
    )
    np.testing.assert_allclose(found.objectives, 10 * quadratic({"a": found.samples["a"]}), rtol=1e-12)


def test_a_point_whose_run_diverges_is_counted_and_never_the_best():
    found = tune(bomb(0.5, 1.5, evaluations=160))
    diverged = found.numbers[:, 0] > 1
    assert (
        0
        < found.failures
        == diverged.sum()
        == reasons_of(found.objectives, found.samples)["the run in 'long' diverged"]
    )
    np.testing.assert_array_equal(np.isinf(found.objectives), diverged)
    # -log(1 - rate) / rate, which is at least 1.38 here: the least rate is the best, and lies at the edge
    assert found.best["rate"] == pytest.approx(0.5, abs=1e-3)
    assert found.at_edge == ("rate",)
    assert "The best 'rate' lies at the low end of its range." in found.warnings
    assert len(found.measures(lambda runs: runs["long"].score("IAE").value)) == (~diverged).sum()


class LastLook:
    """x' = 0 from x(0) = 1, with an output that is no number at the horizon where the gain is above 1."""

    def ode(self, name="loop"):
        """The equation."""
        states, parameters = Layout((Entry("x", np.ones(1)),)), Layout((Entry("gain", np.array(1.0)),))
        t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
        root = ca.sqrt(1 - p * (t > 0.99))
        return Ode.of(name, states, parameters, (t, x, p), {"x": 0 * x}, {"e": x, "tau_applied": root})


def test_a_point_whose_metric_is_no_number_is_counted_though_its_run_is_finite():
    trial = Trial("flat", Run(LastLook(), (iae(), total_variation(0.25)), 1.0, h=0.025))
    gain = Factor("gain", ("gain",), LogUniform(0.01, 100.0))
    found = tune(tuning(trials=(trial,), factors=(gain,), objective=lambda runs: -runs["flat"].factor_values[:, 0]))
    assert reasons_of(found.objectives, found.samples)["the run in 'flat' diverged"] == 0
    assert (
        reasons_of(found.objectives, found.samples)["a metric in 'flat' is no number"]
        == found.failures
        == (found.numbers > 1).sum()
        > 0
    )
    assert 0.9 < found.best["gain"] <= 1


def test_points_beyond_a_limit_of_the_objective_are_not_admissible():
    def limited(runs):
        cost = quadratic(runs)
        return np.where(runs["step"].score("effort").value > 0.1, np.inf, cost)

    free, found = tune(tuning()), tune(tuning(objective=limited))
    assert found.samples["step"].score("effort").value[found.place] <= 0.1
    assert free.samples["step"].score("effort").value[free.place] > 0.1
    reasons = ("the run in 'step' diverged", "a metric in 'step' is no number", "the objective is infinite")
    assert reasons_of(found.objectives, found.samples) == dict(zip(reasons, (0, 0, found.failures), strict=True))
    assert found.failures > 0


def test_a_point_that_only_a_long_step_keeps_finite_is_no_winner():
    # the pole is at 1 / rate; RK4 goes past it while rate < 1.012 at 5 ms, and while rate < 1.006 at 2.5 ms
    found = tune(bomb(1.0, 1.015, objective=lambda runs: -runs["long"].factor_values[:, 0], evaluations=8))
    first = found.numbers[found.finalists[0], 0]
    assert 1.006 < first < 1.012
    assert np.isinf(found.finals_at_half_step[0, 0])
    assert found.best["rate"] < 1.006
    assert found.objective == -found.best["rate"]


def test_measures_are_of_all_points_that_were_looked_at(found):
    error, torque = (lambda runs: runs["step"].score("ISE").value), (lambda runs: runs["step"].score("effort").value)
    runs = found.samples["step"]
    np.testing.assert_array_equal(
        found.measures(error, torque).T, [runs.score("ISE").value, runs.score("effort").value]
    )
    with pytest.raises(ValueError, match="needs at least one measure"):
        found.measures()


def test_short_searches_that_end_apart_are_said_to():
    found = tune(tuning(evaluations=4, population=4, seeds=(0, 1)))
    assert not any(found.has_settled)
    assert any("too short to tell" in said for said in found.warnings)
    assert any("The best objectives of the 2 searches differ by" in said for said in found.warnings)


def test_a_search_that_finds_nothing_is_said_beside_one_that_does():
    found = tune(bomb(0.9, 6.0, evaluations=16, population=4, seeds=(0, 2)))
    assert np.isinf(found.bests).tolist() == [False, True]
    assert "The search of seed 2 found an admissible point only in its last quarter, or none." in found.warnings
    assert not found.has_settled[1]


def test_a_coarse_step_is_said_beside_the_best():
    found = tune(tuning(trials=(Trial("step", Run(DoubleIntegrator(), METRICS, 20.0, h=1.0)),)))
    assert found.step_error > 0.01 * found.objective
    assert any("has an error of" in said and "by the step" in said for said in found.warnings)
    assert "the best objective has an error of" in found.note


def test_a_step_beyond_the_stability_limit_of_the_best_is_said():
    # RK4 takes steps up to 2.785 over the fastest rate, which is 8 1/s at the least here
    fast = (Factor("Kp", ("Kp",), Uniform(64.0, 65.0)), Factor("Kd", ("Kd",), Uniform(16.1, 16.4)))
    found = tune(tuning(trials=(Trial("step", Run(DoubleIntegrator(), METRICS, 20.0, h=0.4)),), factors=fast))
    Kp, Kd = found.best.values()
    fastest = (Kd + np.sqrt(Kd**2 - 4 * Kp)) / 2
    assert found.stable_steps["step"] == pytest.approx(2.785293563 / fastest, rel=1e-4)  # of a grid of the region
    assert any("0.4 s is beyond the stability limit 0.3" in said for said in found.warnings)
    unknown = replace(
        found, final_samples={"step": with_measurement(found.final_samples["step"], limits=np.full(8, np.nan))}
    )
    assert "The stability limit of the step is not known along the best run in 'step'." in unknown.warnings


def test_within_the_stability_limit_nothing_is_said_of_it(found):
    assert found.stable_steps["step"] > 0.02
    assert not any("stability" in said for said in found.warnings)


def test_what_is_said_of_a_search_is_in_plain_numbers(found):
    assert found.note == (
        "Each of the 2 searches used 640 evaluations, 320 for each tuned number; 0 of 1,280 were not admissible. "
        "The seeds of the searches are 0 and 1. The step of the simulation is 0.01 s; the best objective has an error "
        "of less than 0.01 % by the step."
    )
    off = replace(found, finals_at_half_step=1.275 * found.finals_at_half_step)
    assert "The best objective has an error of 55 % by the step." in off.warnings


def test_what_a_search_takes_is_known_before_it_begins():
    made = compile_tuning(tuning(evaluations=160, seeds=(0, 1)))
    needed = study_cost.cost_of([*made.trials, *made.finals], workers=2)
    assert needed.runs == 320 + 2 * 8
    asked = []
    tune(made, lambda sweeps, first, last: asked.append(last - first) or here(sweeps, first, last))
    assert sum(asked) == needed.runs


def test_a_logarithmic_range_is_searched_by_its_logarithm():
    given = compile_tuning(tuning()).trials[0].space.values(np.array([[0.5, 0.0]]))
    assert given[0] == pytest.approx([1.0, 0.1])
    assert isinstance(GAINS[0].distribution, LogUniform)
