"""Local sensitivities: closed forms, differences, global indices, and gradients that mean nothing."""

import casadi as ca
import numpy as np
import pytest

from tests.support.arms import arm_instruments
from tests.support.cases import heavy_but
from tests.support.equations import decay, explosion, oscillator
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines
from workbench.core import Entry, Layout, Ode
from workbench.core.numbers import Bounds
from workbench.engine import simulate
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor, Space
from workbench.engine.metrics import (
    effort,
    iae,
    ise,
    late_error,
    peak_error,
    rmse,
    settling_time,
    step_with_metrics,
    total_variation,
)
from workbench.engine.metrics.accumulators import final_values
from workbench.study.uncertainty import SobolDesign, sobol
from workbench.study.uncertainty.local_sensitivity import local_sensitivities


def relay(rate) -> Ode:
    """x' = rate(x, a) from 1, with x as its error and a = 2."""
    states, parameters = Layout((Entry("x", np.ones(1)),)), Layout((Entry("a", np.array(2.0)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return Ode.of("relay", states, parameters, (t, x, p), {"x": rate(x, p)}, {"e": x})


def steered() -> ClosedLoop:
    return ClosedLoop(
        Manipulator(paper_arm(), q=[0.5, -0.5]),
        ArmFullState(2),
        ArmPID(Kp=[300.0, 100.0], Ki=[100.0, 50.0], Kd=[50.0, 20.0]),
        Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]),
    )


def test_gradients_of_an_oscillator_are_those_of_its_closed_form():
    w, T = 2.0, 2.0
    found = local_sensitivities(oscillator(), [rmse(), ise()], ["omega", "plant.q"], until=T, h=0.01)
    # q = x0 cos(w t): ISE = x0^2 (T / 2 + sin(2 w T) / (4 w))
    ISE = T / 2 + np.sin(2 * w * T) / (4 * w)
    slope = T * np.cos(2 * w * T) / (2 * w) - np.sin(2 * w * T) / (4 * w**2)
    # RK4's own error at this step is 1e-9 or so of each
    np.testing.assert_allclose(found.gradient["ISE"], [[slope, 2 * ISE]], rtol=1e-7)
    RMSE = np.sqrt(ISE / T)
    np.testing.assert_allclose(found.gradient["RMSE"], [[slope / (2 * T * RMSE), RMSE]], rtol=1e-7)
    np.testing.assert_allclose(found.value["RMSE"], [RMSE], rtol=1e-8)
    assert found.warnings == ()
    assert found.labels == ("omega", "plant.q[0]")
    np.testing.assert_array_equal(found.at, [2.0, 1.0])


def test_a_gradient_is_that_of_the_steps_that_are_taken_however_coarse():
    # one step of RK4 multiplies by R(z), z = -a h, and the peak from then on is |R(z)|, whose derivative is -h R'(z)
    a, h = 3.0, 0.5
    found = local_sensitivities(decay(a), [late_error(h)], ["rate", "x"], until=h, h=h)
    z = -a * h
    R, dR = 1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24, 1 + z + z**2 / 2 + z**3 / 6
    np.testing.assert_allclose(found.gradient["late error"], [[-h * dR, R]], rtol=1e-12)  # rounding
    assert abs(R - np.exp(z)) > 0.01


@pytest.mark.parametrize("digital", heavy_but([False, True], False))
def test_gradients_of_a_smooth_loop_are_the_slopes_of_its_runs(digital):
    equation = steered().digital(0.01) if digital else steered().ode()
    names = ["controller.Kp", "controller.Kd[1]", "plant.arm.links[1].mass", "plant.q[0]"]
    metrics = [rmse(), iae(), effort(), peak_error(), total_variation(0.01)]
    found = local_sensitivities(equation, metrics, names, until=1.0, h=0.002)
    assert found.warnings == ()
    for metric in metrics:
        assert found.gradient[metric.name].shape == (2, 5)
        assert np.abs(found.gradient[metric.name]).max() > 0


def test_neighbouring_runs_have_the_same_noise():
    noisy = steered().digital(0.01, arm_instruments(2, noise_q=[1e-3, 1e-3], noise_qd=[1e-2, 1e-2]))
    found = local_sensitivities(noisy, [rmse()], ["controller.Kp"], until=0.5, h=0.01)
    # over different noise the slopes of a gain of 300 would be off by the noise of the metric over a step of 0.03
    np.testing.assert_allclose(found.gradient["RMSE"], found.slope["RMSE"], rtol=1e-5, atol=1e-9)


def test_a_linear_share_is_the_first_order_index_where_ranges_are_narrow():
    ode, h = oscillator(), 0.02
    wide = {"omega": (1.98, 2.02), "plant.q": (0.99, 1.01), "plant.qd": (-0.05, 0.05)}
    space = Space(tuple(Factor(n, (n,), Uniform(*r)) for n, r in wide.items()), ode.parameters, ode.states)
    design = SobolDesign(3, 1024)
    step = step_with_metrics(ode, [rmse()], h)
    p, x0 = space.rows(design.points())
    x0 = np.hstack([x0, np.zeros((len(x0), step.states.size - 2))])
    values = final_values(simulate(step, p=p, x0=x0, until=2.0, every=2.0), [rmse()])["RMSE"]
    found = sobol(design, values, ["RMSE"])["RMSE"]
    deviations = np.array([(b - a) / 12**0.5 for a, b in wide.values()])
    shares = local_sensitivities(ode, [rmse()], list(wide), until=2.0, h=h).linear_shares("RMSE", np.diag(deviations))
    # curvature over ranges of a few percent
    np.testing.assert_allclose(shares[0], found.S1.value, atol=0.01)


def test_numbers_that_move_together_share_their_variance_with_its_sign():
    # ISE = x0^2 (1 - exp(-2 a T)) / (2 a): a rise of x0 that comes with the right rise of the rate changes nothing
    found = local_sensitivities(decay(1.0), [ise()], ["rate", "x"], until=1.0, h=0.01)
    (rate, start) = found.gradient["ISE"][0]
    together = np.array([[1.0, -rate / start], [0.0, 0.1]])
    np.testing.assert_allclose(found.linear_shares("ISE", together), [[0.0, 1.0]], atol=1e-20)


def test_one_direction_that_leaves_all_bounds_takes_no_other_with_it():
    # x comes to rest in a layer far thinner than a step, where S grows without bound; y, beside it, knows nothing of it
    states = Layout((Entry("x", np.ones(1)), Entry("y", np.ones(1))))
    parameters = Layout((Entry("a", np.array(2.0)), Entry("b", np.array(1.0))))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    layer = ca.fmax(-1, ca.fmin(1, x[0] / 0.0005))
    rates = {"x": -p[0] * layer + 0.3 * p[0], "y": -p[1] * x[1]}
    ode = Ode.of("beside", states, parameters, (t, x, p), rates, {"e": x})
    found = local_sensitivities(ode, [ise()], ["a", "b"], until=30.0, h=0.003)
    assert np.isnan(found.gradient["ISE"][:, 0]).all()
    # ISE of y = 1 / (2 b) once all is decayed
    np.testing.assert_allclose(found.gradient["ISE"][1, 1], -0.5, rtol=1e-6)


def test_a_number_at_its_bound_is_moved_to_the_side_that_is_left():
    states = Layout((Entry("x", np.ones(1)),))
    drag = Layout(
        (Entry("drag", np.array(0.0), "1/s", Bounds(0, np.inf)), Entry("top", np.array(1.0), "", Bounds(0, 1)))
    )
    t, x, p = ca.SX.sym("t"), states.symbols(), drag.symbols()
    ode = Ode.of("drag", states, drag, (t, x, p), {"x": -p[0] * x**2}, {"e": p[1] * x})
    found = local_sensitivities(ode, [ise()], ["drag", "top"], until=1.0, h=0.01)
    # x = 1 / (1 + d t): ISE = top^2 / (1 + d), at d = 0 with the slopes -1 and 2
    np.testing.assert_allclose(found.gradient["ISE"], [[-1.0, 2.0]], atol=1e-6)
    np.testing.assert_allclose(found.slope["ISE"], [[-1.0, 2.0]], atol=1e-6)  # of second order
    assert found.warnings == ()


def test_a_gradient_across_a_jump_is_warned_of_and_names_the_switch():
    # x' = -a sign(x) comes to rest at 1 / a: from there on it chatters, and no derivative of a step sees an instant
    ode = relay(lambda x, a: -a * ca.sign(x))
    before = local_sensitivities(ode, [late_error(0.3)], ["a", "x"], until=0.4, h=0.01)
    assert before.warnings == ()
    assert before.switches == ("sign",)
    after = local_sensitivities(ode, [late_error(1.5)], ["a", "x"], until=2.0, h=0.0032)
    (warning,) = after.warnings
    assert warning == "the gradient of 'late error' in a, x[0] is not the slope of its runs, which goes through sign."


def test_derivatives_along_a_run_that_chatters_leave_all_bounds_and_are_none():
    # a layer far thinner than a step: the run stays bounded, its derivatives do not
    ode = relay(lambda x, a: -a * ca.fmax(-1, ca.fmin(1, x / 0.0005)) + 0.3 * a)
    found = local_sensitivities(ode, [rmse()], ["a"], until=30.0, h=0.003)
    assert np.isnan(found.gradient["RMSE"]).all()
    assert np.isfinite(found.value["RMSE"]).all()
    assert "is not the slope of its runs, which goes through min, max" in found.warnings[0]


def test_a_metric_without_a_value_has_no_derivative():
    ode = oscillator()
    found = local_sensitivities(ode, [settling_time()], ["omega"], until=1.0, h=0.01)
    assert np.isinf(found.value["settling time"]).all()
    assert len(found.warnings) == 1


def test_a_run_that_diverges_is_refused():
    with pytest.raises(ValueError, match="needs a run that lasts; this one diverged at"):
        local_sensitivities(explosion(), [rmse()], ["x"], until=2.0, h=0.01)


def test_a_half_of_a_symmetric_matrix_cannot_be_moved_by_itself():
    states = Layout((Entry("x", np.ones(1)),))
    weights = Layout((Entry("Q", np.eye(2), "", Bounds(symmetric=True)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), weights.symbols()
    ode = Ode.of("weighted", states, weights, (t, x, p), {"x": -p[0] * x}, {"e": x})
    with pytest.raises(ValueError, match=r"'Q\[1,0\]' cannot be moved by itself within its bounds"):
        local_sensitivities(ode, [rmse()], ["Q"], until=1.0, h=0.1)


@pytest.mark.parametrize("names", [[], ["omega", "omega"], ["plant.q", "plant.q[0]"]])
def test_names_must_be_different_numbers(names):
    with pytest.raises(ValueError, match="must be numbers, each once, at least one"):
        local_sensitivities(oscillator(), [rmse()], names, until=1.0, h=0.1)


def test_misspelt_names_are_answered_with_the_nearest():
    with pytest.raises(LookupError, match="no 'omeg'.*Did you mean 'omega'"):
        local_sensitivities(oscillator(), [rmse()], ["omeg"], until=1.0, h=0.1)
    found = local_sensitivities(oscillator(), [rmse()], ["omega"], until=1.0, h=0.1)
    with pytest.raises(LookupError, match="no 'RMS' among the 1 metrics here. Did you mean 'RMSE'"):
        found.holds("RMS")
