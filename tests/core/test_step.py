"""The classical Runge-Kutta step."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from workbench.core import Entry, Layout, Ode, rk4
from workbench.engine import simulate


def forced(name: str = "logistic") -> Ode:
    """x' = x (1 - x) cos t, whose solution is x = 1 / (1 + (1/x0 - 1) exp(-sin t))."""
    states, parameters = Layout((Entry("x", np.array(0.2)),)), Layout((Entry("r", np.array(1.0)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return Ode.of(name, states, parameters, (t, x, p), {"x": p * x * (1 - x) * ca.cos(t)}, {"y": t * x})


def end(h: float, until: float = 2.0) -> float:
    ode = forced()
    F, x = rk4(ode, h).F, ode.states.default
    for k in range(round(until / h)):
        x = F(k, x, ode.parameters.default, [])
    return float(x)


def test_rk4_is_of_order_four():
    exact = 1 / (1 + 4 * np.exp(-np.sin(2.0)))
    steps = np.array([0.1, 0.05, 0.025, 0.0125])
    errors = np.array([abs(end(h) - exact) for h in steps])
    orders = np.log2(errors[:-1] / errors[1:])
    # the slope over the halvings; the last errors are 1e-10, far above rounding
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(slope - 4) < 0.1, orders


def test_one_step_of_a_linear_mode_is_multiplied_by_the_stated_polynomial():
    states = Layout((Entry("x", np.array(1.0)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), ca.SX(0, 1)
    for lam in (-3.0, 0.7):
        ode = Ode.of("mode", states, Layout(), (t, x, p), {"x": lam * x}, {})
        step = rk4(ode, 0.4)
        np.testing.assert_allclose(float(step.F(0, 1.0, [], [])), np.polyval(step.amplification, 0.4 * lam), rtol=1e-15)


def test_the_outputs_of_a_step_are_taken_at_its_beginning():
    step = rk4(forced(), 0.1)
    assert float(step.y(3, 0.5, 1.0, [])) == pytest.approx(3 * 0.1 * 0.5, rel=1e-15)


def test_the_step_keeps_the_names_and_the_flow():
    ode = forced()
    step = rk4(ode, 0.1)
    assert (step.states, step.parameters, step.outputs) == (ode.states, ode.parameters, ode.outputs)
    assert step.flow is ode
    assert (step.h, step.substeps, step.noises) == (0.1, 1, 0)


def test_memory_can_be_carried_beside_the_step():
    step = rk4(forced(), 0.1)
    extra = Layout((Entry("largest", np.array(0.0)),))
    z = extra.symbols()
    more = step.with_memory(extra, z, ca.fmax(z, step.rule.x))
    np.testing.assert_array_equal(np.array(more.F(0, [0.5, 0.3], 1.0, [])).ravel()[1], 0.5)
    assert more.states.names == ("x", "largest")


def test_memory_sees_the_state_and_the_time_at_the_beginning_of_the_step():
    step = rk4(forced(), 0.1)
    extra = Layout((Entry("seen", np.zeros(2)),))
    more = step.with_memory(extra, extra.symbols(), ca.vertcat(step.rule.x, step.rule.t))
    runs = simulate(more, until=0.3, engine="numpy")
    np.testing.assert_array_equal(runs.x[0, 1:, 1], runs.x[0, :-1, 0])
    np.testing.assert_array_equal(runs.x[0, 1:, 2], np.arange(3) * 0.1)


def test_a_rule_written_out_is_the_same_rule():
    step = rk4(forced(), 0.1)
    out = replace(step, rule=step.rule.written_out)
    x = [np.array(one.F(3, [0.5], 1.0, [])).ravel() for one in (step, out)]
    np.testing.assert_array_equal(x[0], x[1])
    runs = [simulate(one, until=1.0).x for one in (step, out)]
    # the same sums, of which others may be rounded together with their products
    np.testing.assert_allclose(runs[0], runs[1], rtol=1e-14)


def test_a_rule_that_does_not_say_what_each_state_becomes_is_refused():
    rule = rk4(forced(), 0.1).rule
    with pytest.raises(ValueError, match=r"one entry for each of the 1 states; got 1 and 2"):
        replace(rule, update=ca.SX(2, 1))


@pytest.mark.parametrize("h", [0.0, -0.1, np.nan, np.inf])
def test_a_step_that_is_no_positive_number_is_refused(h):
    with pytest.raises(ValueError, match=r"`rk4\(h=...\)` must be a positive, finite number of seconds; got"):
        rk4(forced(), h)


@pytest.mark.parametrize("h", ["short", None, [0.1, 0.2]])
def test_a_step_that_is_no_number_is_refused(h):
    with pytest.raises(ValueError, match=r"`rk4\(h=...\)` must be a positive, finite number of seconds; got"):
        rk4(forced(), h)


@pytest.mark.parametrize(
    ("h", "says"),
    [
        ("0.1", "a positive, finite number of seconds; got '0.1'"),
        (True, "got True"),
        ([0.1], "got .0.1."),
        (1e-320, "got 1e-320, which a float does not hold"),
    ],
)
def test_a_step_that_is_text_or_too_small_for_a_float_is_refused(h, says):
    with pytest.raises(ValueError, match=r"`rk4\(h=...\)` must be .*" + says):
        rk4(forced(), h)
