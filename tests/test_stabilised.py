"""The stabilised Runge-Kutta-Chebyshev step."""

import numpy as np
import pytest
from equations import decay
from test_step import forced

from workbench.core import rk4
from workbench.core.stabilised import MOST_STAGES, amplification, rkc, stepper

STAGES = (2, 3, 5, 8, 10, MOST_STAGES)


def end(stages: int, h: float, until: float = 2.0) -> float:
    ode = forced()
    F, x = rkc(ode, h, stages).F, ode.states.default
    for k in range(round(until / h)):
        x = F(k, x, ode.parameters.default, [])
    return float(x)


@pytest.mark.parametrize("stages", STAGES)
def test_rkc_is_of_order_two_also_where_the_rate_knows_the_time(stages):
    exact = 1 / (1 + 4 * np.exp(-np.sin(2.0)))
    steps = np.array([0.1, 0.05, 0.025, 0.0125])
    errors = np.array([abs(end(stages, h) - exact) for h in steps])
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(slope - 2) < 0.15, errors


@pytest.mark.parametrize("stages", STAGES)
def test_one_step_of_a_linear_mode_is_multiplied_by_the_stated_polynomial(stages):
    step = rkc(decay(3.0), 0.4, stages)
    assert len(step.amplification) == stages + 1
    for rate in (3.0, -0.7, 0.5 * stages**2):
        # twelve powers of up to 40 cancel to a number below one: at most 1e7 roundings
        np.testing.assert_allclose(
            float(step.F(0, 1.0, rate, [])), np.polyval(step.amplification, -0.4 * rate), rtol=1e-9, atol=1e-9
        )


@pytest.mark.parametrize("stages", STAGES)
def test_the_polynomial_is_the_shifted_chebyshev_polynomial_of_the_method(stages):
    # Sommeijer, Shampine and Verwer (1998): R(z) = a + b T_s(w0 + w1 z), here from T_s(cosh u) = cosh(s u)
    w0 = 1 + 2 / 13 / stages**2
    u = np.arccosh(w0)
    T, dT = np.cosh(stages * u), stages * np.sinh(stages * u) / np.sinh(u)
    ddT = (stages**2 * T - w0 * dT) / (w0**2 - 1)
    w1, b = dT / ddT, ddT / dT**2
    z = np.linspace(-2 * w0 / w1, 0, 101)
    shifted = np.cosh(stages * np.arccosh((w0 + w1 * z).astype(complex))).real
    # the powers cancel: 1e7 roundings at twelve stages
    np.testing.assert_allclose(np.polyval(amplification(stages), z), 1 - b * T + b * shifted, atol=1e-8)


@pytest.mark.parametrize("stages", STAGES)
def test_the_real_stability_interval_is_0_653_of_the_square_of_the_stages_less_one(stages):
    # the same paper: beta = 2/3 (s^2 - 1) (1 - 2/15 eps) with eps = 2/13
    z = -np.linspace(0, 0.75 * stages**2, 20001)
    grows = np.abs(np.polyval(amplification(stages), z)) > 1 + 1e-8
    beta = -z[np.argmax(grows)]
    assert grows.any()
    # an odd polynomial may go on a little, as it leaves the strip on the far side
    assert 0.653 * (stages**2 - 1) <= beta <= 0.7 * stages**2


def test_fast_decay_is_followed_at_a_step_at_which_rk4_explodes():
    ode, h = decay(3000.0), 4e-3
    ends = {}
    for method in ("rk4", "rkc5"):
        F, x = stepper(method)(ode, h).F, 1.0
        for k in range(100):
            x = F(k, x, 3000.0, [])
        ends[method] = abs(float(x))
    assert ends["rk4"] > 1e100
    assert ends["rkc5"] < 0.949**100  # damped by eps / 3 at least within the interval, eps = 2/13


def test_the_step_keeps_names_outputs_and_flow_of_rk4():
    ode = forced()
    step, classical = rkc(ode, 0.1, 4), rk4(ode, 0.1)
    assert (step.states, step.parameters, step.outputs) == (ode.states, ode.parameters, ode.outputs)
    assert step.flow is ode
    assert step.h == 0.1
    assert float(step.y(3, 0.5, 1.0, [])) == float(classical.y(3, 0.5, 1.0, []))


@pytest.mark.parametrize("stages", [1, 0, -3, MOST_STAGES + 1, 2.0, True, "5", None])
def test_a_number_of_stages_that_gives_no_second_order_is_refused(stages):
    with pytest.raises(ValueError, match=r"`rkc\(stages=...\)` must be a whole number from 2 to 12, as .*; got"):
        rkc(forced(), 0.1, stages)


@pytest.mark.parametrize("h", [0.0, -0.1, np.nan, np.inf, "short", None])
def test_a_step_that_is_no_positive_number_is_refused_in_the_name_of_the_method(h):
    with pytest.raises(ValueError, match=r"`rkc\(h=...\)` must be a"):
        rkc(forced(), h, 3)


def test_what_is_no_ode_is_refused_in_the_name_of_the_method():
    with pytest.raises(ValueError, match=r"`rkc\(ode=...\)` must be an `Ode`; got 'x'"):
        rkc("x", 0.1, 3)


def test_a_method_has_a_name():
    ode = forced()
    for method, evaluations in (("rk4", 4), ("rkc2", 2), ("rkc12", 12)):
        assert len(stepper(method)(ode, 0.1).amplification) == evaluations + 1


@pytest.mark.parametrize("name", ["rk5", "rkc", "rkc1", "rkc13", "rkc-2", "euler", ""])
def test_a_method_that_there_is_not_is_refused_by_name(name):
    with pytest.raises(LookupError, match=f"There is no method '{name}': it is 'rk4', or 'rkc2' to 'rkc12'."):
        stepper(name)
