"""The choice of a step: what a tolerance binds, the method that pays, and the record of it."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.equations import decay, explosion, oscillator
from workbench.core import Entry, Layout, Ode, SampledSystem, runge_kutta_step
from workbench.core.methods import METHODS, RESTARTED_METHOD, RK4, STABILISED_METHOD
from workbench.core.state_corners import corners_of
from workbench.engine import simulate
from workbench.engine.metrics import ise, measure, peak_error, rmse
from workbench.engine.metrics.accumulators import final_values
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.engine.metrics.step_for_metrics import step_for
from workbench.engine.stability import longest_steps
from workbench.engine.step_choice import StepChoice
from workbench.study.case_runs import run

HOW = {"until": 2.0, "tolerance": 1e-4}


def choose_step(equation, metrics, p, x0, *, until, **how):
    """The step for some metrics of an equation, over pilot runs p, x0."""
    return step_for(MeasuredEquation.of(equation, metrics, until), p, x0, until=until, **how)


def column(ode):
    return np.tile(ode.parameters.default, (1, 1)), np.tile(ode.states.default, (1, 1))


def saturated(limit: float = 0.5) -> Ode:
    """x'' = -4 sat(x), an oscillation whose force has corners at +-limit, 16 of them in 10 s."""
    states = Layout((Entry("x", np.array([2.0, 0.3])),))
    t, x = ca.SX.sym("t"), states.symbols()
    force = -4 * ca.fmin(ca.fmax(x[0], -limit), limit)
    return Ode.of("saturated", states, Layout(), (t, x, ca.SX(0, 1)), {"x": ca.vertcat(x[1], force)}, {"e": x[0]})


def stiff() -> Ode:
    """x' = -1000 (x - y), y' = -y: a fast decay beside a slow one."""
    states = Layout((Entry("x", np.full(1, 1000 / 999)), Entry("y", np.ones(1))))  # x stays 1000 / 999 y
    t, x = ca.SX.sym("t"), states.symbols()
    rates = {"x": -1000 * (x[0] - x[1]), "y": -x[1]}
    return Ode.of("stiff", states, Layout(), (t, x, ca.SX(0, 1)), rates, {"e": x[0]})


def error_of(ode, choice, metric=ise, until=2.0):
    """The true relative error of a metric at a choice, against steps a twentieth as long."""
    name = metric().name
    measured = MeasuredEquation.of(ode, [metric()])
    steps = (measured.step(h, choice.method) for h in (choice.h, choice.h / 20))
    value, wanted = (final_values(simulate(step, until=until), [metric()])[name][0, 0] for step in steps)
    return abs(value / wanted - 1)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-5, 1e-7])
def test_the_error_at_a_chosen_step_is_near_the_tolerance_and_not_far_below(tolerance):
    ode = oscillator()
    choice = choose_step(ode, [ise()], *column(ode), until=20.0, tolerance=tolerance)
    assert choice.error <= tolerance
    # of order four and with steps in parts of a twentieth: not by halves, which leave up to a sixteenth
    assert choice.error > tolerance / 5 or choice.h == pytest.approx(0.2)


def test_a_tolerance_is_of_the_metrics_that_are_asked_for_and_not_of_all_states():
    states = Layout((Entry("q", np.ones(1)), Entry("r", np.array([1.0, 0.0]))))
    t, x = ca.SX.sym("t"), states.symbols()
    rates = {"q": -x[0], "r": 30 * ca.vertcat(x[2], -x[1])}  # the second turns fast and nobody asks for it
    ode = Ode.of("two", states, Layout(), (t, x, ca.SX(0, 1)), rates, {"e": x[0]})
    asked = choose_step(ode, [ise()], *column(ode), **HOW)
    every = choose_step(ode, [], *column(ode), **HOW)
    assert asked.h > 3 * every.h
    assert (asked.of, every.of) == ("'ISE'", "'r[0]'") or every.of == "'r[1]'"


def test_every_pilot_run_keeps_the_tolerance():
    ode = decay()
    rates = np.linspace(1.0, 50.0, 16)[:, np.newaxis]
    choice = choose_step(ode, [ise()], rates, np.ones((16, 1)), **HOW)
    for rate in rates:
        alone = measure(ode, [ise()], rate[np.newaxis], until=2.0, h=choice.h, tolerance=1e-4)
        assert alone.check.is_passed, str(alone.check)


def test_a_step_divides_horizon_kept_times_and_grids():
    ode = oscillator()
    choice = choose_step(ode, [ise()], *column(ode), until=7.0, every=0.35, tolerance=1e-6)
    for length in (7.0, 0.35):
        # a float holds 7 s to 1e-16
        assert length / choice.h == pytest.approx(round(length / choice.h), rel=1e-9)


@pytest.mark.heavy
def test_a_sampled_loop_takes_any_whole_number_of_substeps():
    k, ode = ca.SX.sym("k"), oscillator()
    sampled = SampledSystem(ode, 0.5, k, ca.SX(0, 1), ode.x)
    counts = [
        sampled.substeps(choose_step(sampled, [ise()], *column(ode), until=20.0, tolerance=t).h)
        for t in np.geomspace(1e-2, 1e-6, 5)
    ]
    assert counts == sorted(counts)
    assert any(count & (count - 1) for count in counts)  # not all of them powers of two


def test_the_stabilised_method_is_chosen_where_stability_alone_asks_for_short_steps():
    ode = stiff()
    choice = choose_step(ode, [ise()], *column(ode), until=2.0, tolerance=1e-3)
    assert choice.method == "stabilised"
    # beyond the end of the stability interval of RK4, 2.785, and within its own
    assert 2.785e-3 < choice.h < 5.8e-3
    assert error_of(ode, choice) <= 1e-3
    assert measure(ode, [ise()], until=2.0, tolerance=1e-3).check.is_passed


def test_restarts_are_chosen_where_corners_cost_the_method_its_order():
    ode = saturated()
    choice = choose_step(ode, [rmse()], *column(ode), until=10.0, tolerance=1e-7)
    assert choice.method == "restarted"
    plain = choose_step(smooth(), [rmse()], *column(smooth()), until=10.0, tolerance=1e-7)
    assert plain.method == "rk4"


def smooth() -> Ode:
    """The same without a corner that is met."""
    return saturated(100.0)


def test_restarts_give_fourth_order_back_to_a_saturated_loop():
    errors = {}
    truth = simulate(runge_kutta_step(saturated(), 2e-5, "restarted"), until=10.0, every=10.0).x[0, -1]
    for method in ("rk4", "restarted"):
        ends = [
            simulate(runge_kutta_step(saturated(), h, method), until=10.0, every=10.0).x[0, -1] for h in (0.1, 0.00625)
        ]
        errors[method] = [np.abs(end - truth).max() for end in ends]
    # a sixteenth of the step: a factor of 65,000 by fourth order, and of 256 by the second order of corners
    assert errors["restarted"][0] / errors["restarted"][1] > 5_000
    assert errors["restarted"][1] < errors["rk4"][1] / 20


@pytest.mark.parametrize("how", [{"engine": "numpy", "arithmetic": "portable"}, {"engine": "casadi"}])
@pytest.mark.parametrize("method", sorted(METHODS))
def test_every_engine_runs_every_method(method, how):
    step = runge_kutta_step(saturated(), 0.02, method)
    found, wanted = (
        simulate(step, until=5.0, **kind).x[0, -1] for kind in (how, {"engine": "native", "arithmetic": "portable"})
    )
    if how["engine"] == "numpy":
        np.testing.assert_array_equal(found, wanted)
    # rounding of 250 steps in another order
    np.testing.assert_allclose(found, wanted, rtol=1e-11)


@pytest.mark.parametrize("method", [RK4, STABILISED_METHOD])
def test_a_method_has_its_order_and_its_amplification(method):
    c, b = np.array(method.nodes), np.array(method.weights) / method.divisor
    a = np.array(method.ahead[:-1])
    assert b.sum() == pytest.approx(1, abs=1e-15)
    np.testing.assert_allclose(c[1:], a, rtol=1e-15)  # each stage is made of the one before it alone
    for power in range(1, method.order):
        assert b @ c**power == pytest.approx(1 / (power + 1), abs=1e-15)
    assert b[1:] @ (a * c[:-1]) == pytest.approx(1 / 6, abs=1e-15)
    powers = [b.sum(), b[1:] @ a, b[2:] @ (a[1:] * a[:-1]), b[3] * a.prod()]
    np.testing.assert_allclose([*powers[::-1], 1.0], method.amplification, rtol=1e-14)


def test_the_stabilised_method_reaches_twice_as_far_along_decaying_modes():
    reach = [longest_steps(np.array([-1.0 + 0j]), method.amplification)[0] for method in (RK4, STABILISED_METHOD)]
    np.testing.assert_allclose(reach, [2.785, 5.799], rtol=1e-3)
    inside = np.polyval(STABILISED_METHOD.amplification, -np.linspace(0.5, 5.6, 500))
    assert np.abs(inside).max() < 0.82


def test_corners_are_those_of_states_that_move():
    assert corners_of(saturated()).g.numel() == 2
    assert corners_of(oscillator()) is None
    assert RESTARTED_METHOD.corners


def test_a_choice_is_read_from_its_record_bit_by_bit():
    choice = StepChoice(1 / 3, "rk4", 1e-3, 0.1 + 0.2, "'RMSE'", float("nan"), float("inf"), 16)
    again = StepChoice.from_record(choice.record)
    assert again.record == choice.record
    assert (again.h, again.error, again.limit) == (choice.h, choice.error, choice.limit)


def test_the_same_question_has_the_same_answer():
    one, two = (choose_step(saturated(), [rmse()], *column(saturated()), **HOW) for _ in range(2))
    assert one == two


def test_a_metric_that_keeps_no_tolerance_is_named():
    with pytest.raises(ValueError, match=r"No step `h` keeps the tolerance of 1e-18: that of .* 'ISE' so much"):
        choose_step(oscillator(), [ise(), peak_error()], *column(oscillator()), until=2.0, tolerance=1e-18)
    with pytest.raises(ValueError, match="none of the 1 pilot runs stays finite up to 2 s"):
        choose_step(explosion(), [ise()], np.zeros((1, 0)), np.ones((1, 1)), **HOW)


def slow_with_a_fast_mode(rate: float) -> Ode:
    """x' = -x / 1000, beside z' = -rate z, which no step beyond 2.8 / rate survives."""
    states = Layout((Entry("x", np.array([1.0])), Entry("z", np.array([1.0]))))
    t, x = ca.SX.sym("t"), states.symbols()
    rates = {"x": -x[0] / 1000, "z": -rate * x[1]}
    return Ode.of("slow", states, Layout(), (t, x, ca.SX(0, 1)), rates, {"e": x[0]})


def test_a_mode_too_fast_for_the_usual_steps_is_followed_or_its_limit_is_named(monkeypatch):
    monkeypatch.setattr("workbench.engine.step_choice.DOUBLINGS", 5)  # 1,600 steps are the usual most
    fast, far = slow_with_a_fast_mode(10.0), slow_with_a_fast_mode(1e4)
    choice = choose_step(fast, [ise()], *column(fast), until=1000.0, tolerance=1e-3)
    assert choice.h < choice.limit < 1000.0 / 1600
    with pytest.raises(ValueError, match=r"its fastest mode needs steps below 0\.00028 s: name a shorter `h`"):
        choose_step(far, [ise()], *column(far), until=1000.0, tolerance=1e-3)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-7])
def test_a_choice_with_its_method_is_the_same_on_every_road(tolerance):
    asked = wb.Run(saturated(), (rmse(),), until=10.0, tolerance=tolerance)
    found = measure(saturated(), [rmse()], until=10.0, tolerance=tolerance)
    case = wb.Case("one", "saturated", asked)
    [outcome] = run(wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(case,))).outcomes
    assert found.choice == outcome.measurement.choice
    assert found.choice.method == ("restarted" if tolerance == 1e-7 else found.choice.method)
    np.testing.assert_array_equal(found.values, outcome.measurement.values)
    np.testing.assert_array_equal(found.errors, outcome.measurement.errors)


def test_a_run_restarted_at_corners_has_the_same_bits_in_any_company():
    step = runge_kutta_step(saturated(), 0.02, "restarted")
    starts = np.random.default_rng(3).uniform(-2.0, 2.0, (40, 2))
    many = simulate(step, x0=starts, until=5.0, every=5.0).x[:, -1]
    for i in (0, 7, 39):
        np.testing.assert_array_equal(simulate(step, x0=starts[i : i + 1], until=5.0, every=5.0).x[0, -1], many[i])
