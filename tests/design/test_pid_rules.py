"""Rules, models of a step, weights, filters and running loops of PID designs."""

import math

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.matrices import DesignError
from workbench.design.pid_design import (
    StepModel,
    amigo,
    half_rule_model,
    lambda_tuning,
    notch,
    prefilter,
    simc,
    step_model,
)

THREE_LAGS = control.tf([1.0], [1.0, 3.0, 3.0, 1.0])
FOUR_LAGS = control.tf([1.0], [6.4e-5, 0.009984, 0.25792, 1.248, 1.0])


@pytest.mark.parametrize(("order", "T", "T2", "L"), [(1, 1.1, 0.0, 0.148), (2, 1.0, 0.22, 0.028)])
def test_the_half_rule_reduces_four_lags_as_by_hand(order, T, T2, L):
    # lags of 1, 0.2, 0.04 and 0.008 s: the half rule adds half of 0.2 to the lag, and the rest to the delay, by hand
    model = half_rule_model(FOUR_LAGS, order=order)
    assert pytest.approx((T, T2, L), rel=1e-6) == (model.T, model.T2, model.L)


def test_simc_of_four_lags_has_the_gains_of_its_formula():
    # Kc = T / (K (tau_c + L)), Ti = min(T, 4 (tau_c + L)): README.txt beside Skogestad (2006), IECR 45, 7817-7822
    design = simc(FOUR_LAGS, half_rule_model(FOUR_LAGS))
    assert (design.k, design.Ti) == pytest.approx((3.716, 1.1), abs=1e-3)
    series = simc(FOUR_LAGS, half_rule_model(FOUR_LAGS, order=2))
    Kc, Ti, Td = 1.0 / 0.056, 0.224, 0.22  # tau_c = 0.028: min(1, 8 * 0.028)
    assert (series.k, series.ki, series.kd) == pytest.approx((Kc * (1 + Td / Ti), Kc / Ti, Kc * Td), rel=1e-6)


def test_a_lead_cancels_the_lag_near_it_and_an_inverse_response_counts_as_delay():
    with_lead = half_rule_model(control.tf([0.5, 1.0], [2.0, 3.0, 1.0]))  # (0.5 s + 1)/((2 s + 1)(s + 1))
    assert pytest.approx((2.25, 0.25)) == (with_lead.T, with_lead.L)
    late = half_rule_model(control.tf([-0.3, 1.0], [2.0, 1.0]), delay=0.2)
    assert pytest.approx((2.0, 0.5)) == (late.T, late.L)
    integrating = half_rule_model(control.tf([2.0], [1.0, 1.0, 0.0]), delay=0.1)
    assert (integrating.K, integrating.L, integrating.integrating) == (2.0, pytest.approx(0.6), True)


def test_what_the_half_rule_is_not_for_is_refused():
    for plant, words in (
        (control.tf([1.0], [1.0, 0.2, 1.0]), "complex"),
        (control.tf([1.0], [1.0, -1.0]), "right half-plane"),
        (control.tf([1.0], [1.0, 0.0, 0.0]), "two at the origin"),
    ):
        with pytest.raises(DesignError, match=words):
            half_rule_model(plant)


def test_amigo_and_lambda_keep_their_formulas():
    plant, model = control.tf([2.0], [3.0, 1.0]), StepModel(2.0, 3.0, 1.0)
    pi = amigo(plant, model, delay=1.0)
    assert pi.k == pytest.approx(0.15 / 2 + (0.35 - 3 / 16) * 3 / 2)
    assert pi.Ti == pytest.approx(0.35 + 13 * 9 / (9 + 36 + 7))
    assert pi.certificate.Ms.gain.value < 1.5  # the rule aims at 1.4
    pid = amigo(plant, model, "PID", 1.0)
    assert (pid.k, pid.Ti, pid.Td) == pytest.approx(((0.2 + 1.35) / 2, (0.4 + 2.4) / 1.3, 1.5 / 3.3))
    integrating = amigo(control.tf([1.0], [1.0, 0.0]), StepModel(1.0, math.inf, 0.5, integrating=True), delay=0.5)
    assert (integrating.k, integrating.Ti) == pytest.approx((0.7, 6.7))
    slow = lambda_tuning(plant, model, tau_c=3.0, delay=1.0)
    assert (slow.k, slow.Ti) == pytest.approx((3 / 8, 3.0))


def test_a_rule_that_does_not_stabilise_its_plant_is_refused():
    with pytest.raises(DesignError, match="not stable"):
        simc(THREE_LAGS, StepModel(0.01, 1.0, 0.01))


def test_a_record_of_a_step_gives_its_model_and_an_unsettled_one_none():
    rng = np.random.default_rng(3)
    t = np.linspace(0, 30, 3001)
    y = 5 + np.where(t > 2, -3 * (1 - np.exp(-(t - 2) / 4)), 0.0)
    model = step_model(t, y + 0.005 * rng.standard_normal(len(t)), step=2.0)
    assert pytest.approx((-1.5, 4.0, 2.0), rel=0.02) == (model.K, model.T, model.L)
    assert model.error < 0.01
    with pytest.raises(DesignError, match="settled"):
        step_model(t[:800], y[:800])


def test_the_weight_of_the_reference_keeps_its_peak():
    design = wb.tune_pid(control.tf([1.0], [6.0, 1.0]), delay=1.0, Ms=1.4, reference_peak=1.05)
    omega = np.geomspace(1e-4, 30, 20000)
    s = 1j * omega
    P = np.exp(-s) / (6 * s + 1)
    F = P * (design.k * design.b + design.ki / s) / (1 + P * (design.k + design.ki / s))
    assert 0 < design.b < 1
    assert np.abs(F).max() == pytest.approx(1.05, rel=2e-3)
    assert design.reference_peak == pytest.approx(1.05, rel=2e-3)


def test_a_load_gives_the_integrals_of_the_error_that_a_simulation_has():
    motor = wb.DCMotor()
    plant = wb.linearize(wb.open_loop(motor), 0.0, [0.0, 0.0])
    design = wb.tune_pid(plant, delay=0.02, Ms=2.0)
    assert design.IAE >= design.IE > 0
    smooth = wb.tune_pid(control.tf([1.0], [1.0, 3.0, 3.0, 1.0]), Ms=1.4)
    assert pytest.approx(smooth.IE, rel=2e-3) == smooth.IAE  # the error keeps its sign
    # 1/(6 s + 1) with a delay of 1 s: IAE 2.0237, by a simulation of the sampled plant with steps of 1 ms
    late = wb.pid_design.pi_optimum(control.tf([1.0], [6.0, 1.0]), 1.4, 1.4, 1.0)
    assert pytest.approx(2.0237, rel=2e-3) == late.IAE


@pytest.mark.parametrize("form", ["PI", "PID"])
def test_a_design_runs_as_a_law_and_as_a_system_of_python_control(form):
    motor = wb.DCMotor()
    design = wb.tune_pid(wb.linearize(wb.open_loop(motor), 0.0, [0.0, 0.0]), delay=0.02, form=form)
    law, reference = wb.PID.of(design), wb.Step("omega", "rad/s", 1.0)
    assert law.memory.names == (("integral",) if form == "PI" else ("integral", "filter"))
    runs = [
        wb.simulate(wb.ClosedLoop(motor, controller=c, reference=reference), until=0.5)
        for c in (law, design.controller)
    ]
    assert np.abs(np.asarray(runs[0]["omega"]) - np.asarray(runs[1]["omega"])).max() < 1e-9
    assert wb.PID.of(design, low=-24.0, high=24.0).high == 24.0


def test_a_law_about_an_operating_point_commands_its_input_at_rest():
    motor = wb.DCMotor()
    speed = 10.0
    current = float(motor.b) * speed / float(motor.K)
    volts = float(motor.R) * current + float(motor.K) * speed
    plant = wb.linearize(wb.open_loop(motor), 0.0, [speed, current], u=[volts])
    law = wb.PID.of(wb.tune_pid(plant, delay=0.02).with_weights(0.5, 0.0))
    assert float(law.u0[0] + law.Kp[0] * (0.5 - 1) * speed) == pytest.approx(volts)


def test_what_is_no_design_or_has_no_layouts_is_refused():
    with pytest.raises(ValueError, match="must be the result of `tune_pid`"):
        wb.PID.of(3.0)
    with pytest.raises(ValueError, match="needs `reads` and `drives`"):
        wb.PID.of(wb.tune_pid(THREE_LAGS))


def test_a_notch_stabilises_a_resonance_that_its_law_does_not():
    plant, law = control.tf([1.0], [1.0, 0.02, 1.0]), control.tf([0.2], [1, 0])
    assert not wb.stability_margins(plant * law).stable
    design = notch(plant, law)
    assert design.certificate.Ms.gain.value < 1.5
    assert wb.stability_margins(plant * design.law).Ms.gain.value == design.certificate.Ms.gain.value
    with pytest.raises(DesignError, match="no stable pole with a damping"):
        notch(control.tf([1.0], [1.0, 3.0, 1.0]), law)


def test_a_prefilter_gives_its_bandwidth_and_leaves_the_loop():
    law = wb.tune_pid(THREE_LAGS, Ms=2.0, Mt=2.0).loop_filter
    design = prefilter(THREE_LAGS, law, bandwidth=0.3)
    assert wb.bandwidth(design.response).frequency.value == pytest.approx(0.3, rel=1e-8)
    assert design.peak >= 1
    with pytest.raises(DesignError, match="the loop itself has a bandwidth"):
        prefilter(THREE_LAGS, law, bandwidth=30.0)
