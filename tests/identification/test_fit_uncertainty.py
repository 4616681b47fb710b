"""Profiles, bootstraps and factors of a fit: other roads to its intervals, and its way into studies."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.stats import binom, chi2

import workbench as wb
from tests.support.motor_logs import FREE, MOTOR, TRUE, T, V, X, log, motion, steps
from workbench.engine.factors import Space
from workbench.identification.estimation import Bootstrap, fit
from workbench.identification.estimation.profile_likelihood import ProfileEnd
from workbench.study.compiled_sweep import compile_sweep

SIGMA = 0.3
NOISE = {"omega": SIGMA, "i": SIGMA}
LINEAR = ("offset of omega", "scale of omega")
SPEED = wb.Dataset.of(T, {"v": V, "omega": log(T, V, X, SIGMA)["omega"]}, {"v": "V", "omega": "rad/s"})
WIDE_NOISE = {"omega": 5 * SIGMA, "i": 5 * SIGMA}
AT_END = 1e-3  # of a half width: an end has the ratio of its limit to 2e-4


@pytest.fixture(scope="module")
def known():
    return fit(MOTOR, log(T, V, X, SIGMA), FREE, noise=NOISE, hold_out=0.0)


@pytest.fixture(scope="module")
def wide():
    """A fit whose interval of J reaches below zero."""
    return fit(MOTOR, log(T, V, X, WIDE_NOISE["i"]), ("J", "R"), noise=WIDE_NOISE, hold_out=0.0)


@pytest.fixture(scope="module")
def linear():
    """Fits of an offset and a scale, in which the outputs are linear, with noise that is known and estimated."""
    return {
        known: fit(MOTOR, SPEED, LINEAR, noise={"omega": SIGMA} if known else None, hold_out=0.0)
        for known in (False, True)
    }


@pytest.mark.parametrize("is_noise_known", [True, False])
def test_the_profile_of_a_linear_model_is_its_linear_interval(linear, is_noise_known):
    found = linear[is_noise_known]
    for name, (low, high) in found.intervals(0.9).items():
        profile = found.profile(name, 0.9)
        assert profile.interval == pytest.approx((low, high), abs=AT_END * (high - low) / 2)
        assert profile.remarks == ()
        if is_noise_known:  # the ratio of a linear model is the square of the distance in standard errors
            distance = (profile.values - found.values[name]) / found.standard_errors[name]
            assert profile.ratios == pytest.approx(distance**2, rel=1e-4, abs=1e-5)


def test_an_end_of_a_profile_has_the_ratio_of_the_best_others_found_by_another_search():
    found = fit(MOTOR, log(T, V, X, SIGMA), ("b", "J"), noise=NOISE, hold_out=0.0)
    profile = found.profile("J")
    low, high = found.intervals()["b"]

    def cost(J):
        def sum_at(b):
            return np.sum(found.data.residuals(np.array([b, J]), found.end.sigma) ** 2)

        return minimize_scalar(sum_at, bounds=(2 * low - high, 2 * high - low), method="bounded").fun

    least = cost(found.values["J"])
    for end in profile.interval:
        assert cost(end) - least == pytest.approx(chi2.ppf(0.95, 1), rel=1e-3)  # the ends are found to 2e-4
    assert np.all(np.diff(profile.values) > 0)
    assert profile.ratios.min() == 0.0
    assert profile.by_half_step < 0.01 * profile.limit


def test_ends_that_a_search_does_not_reach_are_open_or_at_their_bound(known):
    error, b = known.standard_errors["b"], known.values["b"]
    profile = known.profile("b", limits=(b - 0.5 * error, b + 10 * error))
    assert profile.low_end == ProfileEnd(-np.inf, "open")
    assert profile.high_end.reason == "reached"
    assert "'b' is open below" in profile.remarks[0]
    late = fit(MOTOR, log(T, V, motion(T, V, delay=0.003), SIGMA), ("R", "delay of v"), noise=NOISE, hold_out=0.0)
    profile = late.profile("delay of v")
    assert profile.low_end == ProfileEnd(0.0, "bound")
    assert "ends below at its bound" in profile.remarks[0]


def test_fits_that_do_not_converge_leave_an_end_unknown(wide):
    profile = wide.profile("J")  # towards an inertia of zero no step is short enough: the equation becomes stiff
    assert profile.ratios.max() < 2 * profile.limit  # without a shorter step it jumps to 1e37
    assert profile.low_end.reason == "not converged"
    assert np.isnan(profile.interval[0])
    assert "no end is known" in profile.remarks[0]


def test_a_better_minimum_on_a_profile_is_said(known):
    profile = known.profile("R")
    assert profile.remarks == ()
    assert "There is a better minimum" in replace(profile, ratios=profile.ratios - 0.1).remarks[-1]


def test_a_parametric_bootstrap_of_a_linear_model_has_its_covariance(linear):
    found = linear[False]
    drawn = found.bootstrap(200, seed=2)
    ratios = [drawn.standard_errors[name] / found.standard_errors[name] for name in LINEAR]
    assert ratios == pytest.approx([1.0, 1.0], abs=4 / np.sqrt(400))  # four standard errors of a deviation of 200 draws
    assert drawn.share_failed == 0.0
    assert np.array_equal(found.bootstrap(5, seed=2).draws, drawn.draws[:5])
    assert not np.array_equal(found.bootstrap(5, seed=3).draws, drawn.draws[:5])


def test_residuals_are_drawn_for_each_sensor_by_itself():
    e = np.random.default_rng(5).standard_normal(X.shape) * [0.5, 0.002]
    found = fit(MOTOR, log(T, V, X + e), ("offset of omega", "offset of i"), hold_out=0.0)
    drawn = found.bootstrap(100, seed=1, kind="residual")
    for name in found.names:
        # 5 standard errors of a deviation of 100 draws
        assert drawn.standard_errors[name] == pytest.approx(found.standard_errors[name], rel=0.35)


def test_a_fit_that_failed_counts_as_beyond_both_ends():
    draws = np.random.default_rng(0).standard_normal((199, 1))
    whole = Bootstrap(("a",), np.zeros(1), draws, "parametric", {"a": 0.0}, 0.0, 0.0, ("a",))
    assert whole.intervals()["a"] == (np.sort(draws[:, 0])[4], np.sort(draws[:, 0])[194])
    broken = replace(whole, draws=np.where(np.arange(199)[:, np.newaxis] < 4, np.nan, draws))
    low, high = broken.intervals()["a"]
    rest = np.sort(draws[4:, 0])
    assert (low, high) == (rest[0], rest[-1])
    assert np.isnan(broken.standard_errors["a"])
    assert "2.01 % of the fits did not converge" in repr(broken)
    assert (whole.is_passed, broken.is_passed) == (True, False)
    with pytest.raises(ValueError, match="2.01 % of the fits"):
        broken.plants()
    assert whole.plants("plant.")[3] == {"plant.a": draws[3, 0]}
    broken = replace(whole, draws=np.where(np.arange(199)[:, np.newaxis] < 5, np.nan, draws))
    assert broken.intervals()["a"] == (-np.inf, np.inf)
    with pytest.raises(ValueError, match="at least 199 draws"):
        replace(whole, draws=draws[:100]).intervals(0.99)


def test_factors_have_the_covariance_of_the_fit_in_a_sweep_of_a_loop(known):
    motor = known.apply(wb.DCMotor())
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
    factors = known.factors(path="plant.")
    changes = np.array([factor.direction.changes for factor in factors])
    assert changes.T @ changes == pytest.approx(known.covariance, rel=1e-9)
    design = wb.uncertainty.MonteCarlo(len(factors), 3000, seed=1)
    run = wb.Run(loop, (wb.effort("omega"),), until=0.1, h=0.01)
    sweep = compile_sweep(wb.Sweep("doubt", run, factors, design))
    p, _ = sweep.rows(0, 3000)
    columns = [sweep.equation.parameters.labels.index(f"plant.{name}") for name in FREE]
    drawn = (p[:, columns] - known.theta) / np.array(list(known.standard_errors.values()))
    assert drawn.mean(axis=0) == pytest.approx(np.zeros(4), abs=4 / np.sqrt(3000))
    assert np.cov(drawn.T) == pytest.approx(known.correlation, abs=4 * np.sqrt(2 / 3000))  # 4 errors of a covariance
    others = np.delete(np.arange(p.shape[1]), columns)
    assert np.ptp(p[:, others], axis=0).max() == 0.0


def test_factors_that_would_leave_bounds_or_move_numbers_twice_are_refused(wide):
    with pytest.raises(ValueError, match="% lie beyond the bounds of 'J'"):
        wide.factors()
    assert [factor.paths for factor in wide.factors(["R"])] == [("R",)]
    factors = wide.factors(cut=0.1)
    far = tuple(replace(factor, distribution=wb.uncertainty.Normal(0.0, 1.0, -60.0, 60.0)) for factor in factors)
    space = Space(far, MOTOR.parameters, MOTOR.states)
    with pytest.raises(ValueError, match="lead together too far: '[JR]'"):
        space.rows(np.zeros((1, 2)))
    with pytest.raises(ValueError, match="'direction 1' and 'J' both move 'J'"):
        Space((*factors, wb.Factor("J", ("J",), wb.Uniform(0.01, 0.02))), MOTOR.parameters)
    with pytest.raises(ValueError, match="along a direction"):
        wb.Knob.of(factors[0])
    table = wb.uncertainty.factor_table(Space(factors, MOTOR.parameters), "factors", "Factors.")
    assert table.rows[0][1].startswith(f"J = {wide.values['J']:.4g} ")


def test_estimates_are_put_in_place_by_their_paths(known):
    assert known.values["J"] == known.apply(wb.DCMotor()).J
    assert known.apply(MOTOR).parameters["R"].default == known.values["R"]
    assert known.apply(wb.DCMotor(), values={"J": 0.5}).J == 0.5
    held = known.apply(wb.OdePlant(MOTOR))
    assert wb.open_loop(held).parameters["b"].default == known.values["b"]
    with pytest.raises(LookupError, match="There is no '[JbRL]' among the"):
        known.apply(wb.TwoMasses())
    with pytest.raises(LookupError, match="path of a block"):
        known.apply(wb.DCMotor(), path="plant.")
    with pytest.raises(ValueError, match="J"):
        known.apply(wb.DCMotor(), values={"J": -1.0})


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda found: found.profile("j"), "There is no 'j'"),
        (lambda found: found.profile("J", 1.0), "between 0 and 1"),
        (lambda found: found.profile("J", limits=(1.0, 2.0)), "one below and one above"),
        (lambda found: found.bootstrap(0), "count"),
        (lambda found: found.bootstrap(10, kind="wild"), "parametric"),
        (lambda found: found.bootstrap(10).intervals(), "at least 39 draws"),
        (lambda found: found.factors(["offset of i"]), "There is no 'offset of i'"),
        (lambda found: found.factors([]), "at least one parameter"),
    ],
)
def test_what_cannot_be_asked_of_a_fit_is_refused_by_name(known, ask, words):
    with pytest.raises((ValueError, LookupError), match=words):
        ask(known)


def test_a_log_without_noise_has_no_doubt_to_draw_from():
    exact = fit(MOTOR, log(T, V, X), ("J", "R"))
    for ask in (lambda: exact.profile("J"), lambda: exact.bootstrap(5), exact.factors):
        with pytest.raises(ValueError, match="nothing is left in doubt"):
            ask()


@pytest.mark.release
@pytest.mark.parametrize("is_known", [True, False])
def test_profiles_and_bootstraps_of_a_thousand_logs_hold_the_truth_as_often_as_they_say(is_known):
    t, v = steps(81, 3)
    x, count, level = motion(t, v), 1000, 0.9
    by_profile, by_draws = [], []
    for seed in range(count):
        found = fit(MOTOR, log(t, v, x, SIGMA, seed), FREE, noise=NOISE if is_known else None, hold_out=0.0)
        drawn = found.bootstrap(99, seed).intervals(level)
        for hits, ends in ((by_profile, {n: found.profile(n, level).interval for n in FREE}), (by_draws, drawn)):
            hits.append([ends[name][0] <= TRUE[name] <= ends[name][1] for name in FREE])
    low, high = binom.ppf([0.0005, 0.9995], count, level) / count
    for hits in (by_profile, by_draws):
        shares = np.mean(hits, axis=0)
        assert (shares >= low).all()
        assert (shares <= high).all()
