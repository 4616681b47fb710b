"""measure with a tolerance: what halving the steps did to each metric, steps that a pilot chooses, and their limits."""

import casadi as ca
import numpy as np
import pytest

from tests.support.equations import decay, explosion, oscillator
from workbench.core import Entry, Layout, Ode, SampledSystem
from workbench.engine import simulate
from workbench.engine.metrics import iae, ise, measure, peak_error, rmse, settling_time, total_variation

A = np.linspace(1.0, 5.0, 9)[:, np.newaxis]
RATES = np.linspace(300.0, 600.0, 21)[:, np.newaxis]


def relaxed(rate, t):
    """The integral of x^2 of `relaxation` in closed form."""
    mixed = (1 - np.exp(-rate * t) * (np.cos(t) + rate * np.sin(t))) / (1 + rate**2)
    return t / 2 - np.sin(2 * t) / 4 + 2 * mixed + (1 - np.exp(-2 * rate * t)) / (2 * rate)


def exact_ise(rate, T):
    return (1 - np.exp(-2 * rate * T)) / (2 * rate)


def relaxation() -> Ode:
    """x' = -rate (x - sin t) + cos t from 1: x = sin t + exp(-rate t), fast at first and slow behind."""
    states, parameters = Layout((Entry("x", np.ones(1)),)), Layout((Entry("rate", np.array(500.0)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return Ode.of("relaxation", states, parameters, (t, x, p), {"x": -p * (x - ca.sin(t)) + ca.cos(t)}, {"e": x})


def hill(height: float) -> Ode:
    """x' = -rate(t) x with a rate of 1, and of `height` from 0.4 to 0.6 s."""
    states = Layout((Entry("x", np.ones(1)),))
    t, x = ca.SX.sym("t"), states.symbols()
    rate = ca.if_else(ca.fabs(t - 0.5) < 0.1, height, 1)
    return Ode.of("hill", states, Layout(), (t, x, ca.SX(0, 1)), {"x": -rate * x}, {"e": x})


def cubic(rate: float) -> Ode:
    """x' = -rate x^3 from 1, which Runge-Kutta loses at a step that is too long."""
    states = Layout((Entry("x", np.ones(1)),))
    t, x = ca.SX.sym("t"), states.symbols()
    return Ode.of("cubic", states, Layout(), (t, x, ca.SX(0, 1)), {"x": -rate * x**3}, {"e": x})


def test_without_a_tolerance_nothing_is_judged():
    found = measure(decay(), (ise(),), until=1.0, h=0.1)
    assert found.check is None


def test_halving_tells_median_worst_and_share_of_the_runs_within_the_tolerance():
    T, h = 2.0, 0.1
    errors = np.abs(measure(decay(), (ise(),), A, until=T, h=h).score("ISE").value / exact_ise(A, T)[:, 0] - 1)
    tolerance = float(2 * np.sort(errors)[5:7].mean())
    found = measure(decay(), (ise(),), A, until=T, h=h, tolerance=tolerance)
    (accuracy,) = found.check.metrics
    # twice the change, of which order four leaves a sixteenth
    assert accuracy.worst == pytest.approx(2 * 15 / 16 * errors.max(), rel=0.1)
    assert accuracy.median == pytest.approx(2 * 15 / 16 * np.median(errors), rel=0.1)
    assert accuracy.within == pytest.approx(6 / 9)
    assert not accuracy.is_met
    assert not found.check.is_passed
    assert f"ISE: tolerance {tolerance:g} NOT met by 66.7 % of 9 runs: median" in str(found.check)


def test_a_tolerance_that_all_metrics_keep_is_said_to_be_met():
    found = measure(decay(), (ise(), iae()), A, until=2.0, h=0.01, tolerance=1e-6)
    assert found.check.is_passed
    assert [line.split(" by ")[0] for line in str(found.check).splitlines()[:2]] == [
        "ISE: tolerance 1e-06 met",
        "IAE: tolerance 1e-06 met",
    ]


def test_a_tolerance_changes_no_number_of_the_measurement():
    plain, judged = (measure(oscillator(), (ise(),), until=1.0, h=0.1, tolerance=t) for t in (None, 1e-9))
    np.testing.assert_array_equal(plain.score("ISE").value, judged.score("ISE").value)
    np.testing.assert_array_equal(plain.score("ISE").error, judged.score("ISE").error)
    assert not judged.check.is_passed


def test_a_run_that_only_the_whole_step_loses_has_no_value_and_is_not_tested():
    found = measure(cubic(10.0), (ise(),), until=2.0, h=0.4, tolerance=1e9)
    assert (np.isfinite(found.diverged_at).all(), np.isnan(found.half_diverged_at).all()) == (True, True)
    assert np.isnan([found.score("ISE").value, found.score("ISE").error]).all()
    (accuracy,) = found.check.metrics
    assert (accuracy.runs, accuracy.lost_runs, accuracy.is_met) == (0, 1, False)


def test_a_run_without_a_value_is_counted_and_never_averaged():
    starts = np.array([[1.0], [0.1], [0.2]])
    (accuracy,) = measure(explosion(), (ise(),), x0=starts, until=2.0, h=1e-3, tolerance=1e-6).check.metrics
    assert (accuracy.runs, accuracy.lost_runs) == (2, 1)
    assert accuracy.worst < 1e-6


def test_a_metric_that_is_zero_and_stays_zero_keeps_any_tolerance():
    (accuracy,) = measure(decay(), (ise(),), x0=np.zeros((1, 1)), until=1.0, h=0.1, tolerance=1e-12).check.metrics
    assert accuracy.worst == 0
    assert accuracy.is_met


def test_each_run_has_a_limit_on_its_step():
    rates = np.random.default_rng(2).permutation(np.linspace(1.0, 100.0, 16))[:, np.newaxis]
    found = measure(decay(), (ise(),), rates, until=1.0, h=0.01)
    # 2.785 is the end of RK4's stability interval
    np.testing.assert_allclose(found.limits, 2.785 / rates[:, 0], rtol=1e-3)
    np.testing.assert_array_equal(found.looked_at, np.arange(16))
    rates = np.random.default_rng(2).permutation(np.linspace(1.0, 400.0, 50))[:, np.newaxis]
    found = measure(decay(), (ise(),), rates, until=1.0, h=0.01, tolerance=1.0)
    np.testing.assert_allclose(found.limits, 2.785 / rates[:, 0], rtol=1e-3)
    assert str(found.check).endswith("is BEYOND its limit of 6.96 ms, along 50 of 50 runs.")


def test_the_limit_does_not_depend_on_how_many_states_are_kept():
    few, many = (measure(hill(500.0), (ise(),), until=1.0, h=0.01, every=every).limit for every in (1.0, 0.01))
    assert (few.limit, few.at) == (many.limit, many.at)
    assert few.limit == pytest.approx(2.785 / 500, rel=1e-3)
    assert 0.4 <= few.at <= 0.6
    assert not few.holds


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
def test_a_pilot_chooses_steps_that_keep_the_tolerance_on_a_closed_form(tolerance):
    T = 2.0
    found = measure(relaxation(), (ise(), rmse()), RATES, until=T, tolerance=tolerance)
    exact = relaxed(RATES, T)[:, 0]
    assert np.abs(found.score("ISE").value / exact - 1).max() <= tolerance
    assert np.abs(found.score("RMSE").value / np.sqrt(exact / T) - 1).max() <= tolerance
    assert found.check.is_passed, str(found.check)
    # the end of the stability interval of RK4 at the fastest rate
    assert found.h < 2.785 / 600


def test_the_error_at_a_chosen_step_covers_that_of_the_value():
    found = measure(relaxation(), (ise(),), RATES, until=2.0, tolerance=1e-2)
    exact, score = relaxed(RATES, 2.0)[:, 0], found.score("ISE")
    assert (np.abs(score.value - exact) <= score.error).mean() > 0.9


def test_a_grid_and_kept_times_bound_the_chosen_steps():
    T, sample, every = 2.4, 4e-3, 0.06
    metrics = (total_variation(sample), peak_error())
    found = measure(oscillator(), metrics, until=T, every=every, tolerance=1e-3)
    for length in (sample, every, T):
        ratio = length / found.h
        # a float holds 2.4 s to 1e-16
        assert ratio == pytest.approx(round(ratio), rel=1e-9)
    np.testing.assert_allclose(found.trajectories.t, np.arange(41) * every, atol=1e-12)
    # the oscillation to a thousandth of its size at every kept time
    np.testing.assert_allclose(found.trajectories["q"][0, :, 0], np.cos(2 * found.trajectories.t), atol=1e-3)
    grid = -2 * np.sin(2 * np.arange(601) * sample)
    assert found.score("TV").value[0] == pytest.approx(np.abs(np.diff(grid)).sum() / T, rel=1e-3)


def test_a_time_is_known_to_the_chosen_step_at_best():
    t, states = ca.SX.sym("t"), Layout((Entry("q", np.zeros(1), "rad"),))
    x = states.symbols()
    ode = Ode.of("lag", states, Layout(), (t, x, ca.SX(0, 1)), {"q": 10 * (1 - x)}, {"q": x, "q_ref": ca.SX(1)})
    found = measure(ode, (settling_time(),), until=2.0, tolerance=1e-3)
    score, longest = found.score("settling time"), found.h
    assert score.error[0] >= longest
    assert score.value[0] == pytest.approx(np.log(50) / 10, abs=longest)


def test_one_run_is_the_same_at_a_chosen_step_in_any_company():
    found = measure(relaxation(), (ise(),), RATES, until=2.0, tolerance=1e-3)
    again = measure(relaxation(), (ise(),), RATES[::-1].copy(), until=2.0, tolerance=1e-3)
    np.testing.assert_array_equal(found.score("ISE").value, again.score("ISE").value[::-1])


def test_progress_at_a_chosen_step_rises_to_one():
    seen: list[float] = []
    measure(relaxation(), (ise(),), RATES, until=2.0, tolerance=1e-3, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1.0)


def test_without_a_step_it_is_chosen_for_a_tolerance_of_0_001():
    plain, named = measure(decay(), (ise(),), until=1.0), measure(decay(), (ise(),), until=1.0, tolerance=1e-3)
    assert (plain.h, plain.tolerance) == (named.h, named.tolerance)


@pytest.mark.parametrize("bad", [0.0, -1e-3, np.nan, np.inf, "small"])
def test_a_tolerance_that_is_none_is_refused(bad):
    with pytest.raises(ValueError, match=r"`measure\(tolerance=...\)` must be"):
        measure(decay(), (ise(),), until=1.0, h=0.1, tolerance=bad)


def test_a_sampled_loop_has_its_substep_chosen_or_is_judged_at_the_one_that_is_named():
    k, ode = ca.SX.sym("k"), decay()
    sampled = SampledSystem(ode, 0.1, k, ca.SX(0, 1), ode.x)
    chosen = measure(sampled, (ise(),), until=1.0, tolerance=1e-3)
    assert chosen.check.is_passed
    assert sampled.substeps(chosen.h) in (1, 2, 4, 8)  # a half of the period, a quarter and so on
    assert measure(sampled, (ise(),), until=1.0, h=0.01, tolerance=1e-6).check.is_passed


def test_kept_times_that_do_not_reach_the_horizon_are_refused():
    with pytest.raises(ValueError, match=r"`simulate\(until=...\)` must be a multiple of `every` = 0.3 s; got 1 s"):
        measure(decay(), (ise(),), until=1.0, every=0.3, tolerance=1e-3)


def test_rows_are_checked_before_a_pilot_runs():
    ode = oscillator()
    with pytest.raises(ValueError, match="omega"):
        measure(ode, (ise(),), np.array([[-1.0]]), until=1.0, tolerance=1e-3)
    with pytest.raises(ValueError, match=r"got 2 rows of p and 3 rows of x0"):
        measure(ode, (ise(),), np.ones((2, 1)), np.ones((3, 2)), until=1.0, tolerance=1e-3)


def test_values_are_those_of_a_simulation_at_the_step():
    found = measure(decay(), (ise(),), until=1.0, h=0.1, tolerance=1.0)
    step = found.trajectories.step
    np.testing.assert_array_equal(found.trajectories.x[:, -1], simulate(step, until=1.0, every=1.0).x[:, -1])


def noisy() -> SampledSystem:
    """x' = -x^3, which noise moves once in 0.1 s: how fast it decays is told by the noise."""
    states = Layout((Entry("x", np.full(1, 3.0)),))
    t, x = ca.SX.sym("t"), states.symbols()
    flow = Ode.of("noisy", states, Layout(), (t, x, ca.SX(0, 1)), {"x": -(x**3)}, {"e": x})
    w = ca.SX.sym("w")
    return SampledSystem(flow, 0.1, ca.SX.sym("k"), w, x + 2 * w)


def test_the_limit_of_a_noisy_run_is_taken_along_the_very_run():
    starts = np.linspace(0.0, 3.0, 40)[:, np.newaxis]
    few, many = (
        measure(noisy(), (ise(),), x0=starts, until=20.0, h=0.01, every=every, seed=7).limits for every in (20.0, 0.1)
    )
    np.testing.assert_array_equal(few, many)
    assert len(set(few.tolist())) == 40
