"""Optimal PI and PID laws against dense searches that share no code with them, and against published numbers."""

import math

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.matrices import DesignError
from workbench.design.pid_design import pi_optimum, pid_optimum

LAGS = ([1.0], [1.0, 3.0, 3.0, 1.0], 0.0)
CASES = {
    "a lag with a delay": (([1.0], [2.0, 1.0], 1.0), 1.4, math.inf),
    "much lag, both limits active": (([1.0], [200.0, 1.0], 1.0), 1.4, 1.4),
    "three lags": (LAGS, 1.6, 1.6),
    "an integrator": (([1.0], [0.7, 1.0, 0.0], 0.3), 2.0, 2.0),
    "inverse response": (([-0.9, 1.0], [1.0, 3.0, 3.0, 1.0], 0.0), 1.4, 1.4),
    "a resonance": (([1.0], [1.0, 0.05, 1.0], 0.3), 1.6, math.inf),
    "an unstable pole": (([1.0], [1.0, -1.0], 0.1), 2.0, 2.0),
    "a negative gain": (([-3.0], [5.0, 6.0, 1.0], 0.2), 1.4, math.inf),
    "a direct path": (([-1.0, 2.0], [1.0, 1.0], 0.0), 2.0, 2.0),
}


def feasible(process, k, ki, kd, N, Ms, Mt):
    """Which gains meet the limits and stabilise, by |S|, |T| and the turn of the characteristic function on a grid."""
    num, den, delay = process
    omega = np.unique(
        np.concatenate(
            [np.geomspace(1e-4, 60 / max(delay, 0.1), 500), np.linspace(0.05, 12, 200), np.linspace(0.9, 1.1, 200)]
        )
    )
    s = 1j * omega
    law = k + ki / s + kd * s / (1 + s / N)
    top = s * law * np.polyval(num, s) * np.exp(-s * delay)
    below = s * np.polyval(den, s)
    size = np.abs(top + below)
    good = (np.abs(below) <= Ms * size).all(axis=-1) & (np.abs(top) <= Mt * size).all(axis=-1)
    where = np.nonzero(good)[0]
    start = np.real(ki[where]) * num[-1]
    path = np.concatenate([start + 0j, (top + below)[where]], axis=1)
    turn = np.unwrap(np.angle(path), axis=1)
    good[where] = np.abs((turn[:, -1] - turn[:, 0]) / (np.pi / 2) - len(den)) < 0.6
    return good


def column(values):
    return np.asarray(values, dtype=float).ravel()[:, np.newaxis]


@pytest.mark.parametrize("case", CASES)
def test_no_gains_of_a_dense_grid_have_a_larger_integral_gain(case):
    process, Ms, Mt = CASES[case]
    num, den, delay = process
    design = pi_optimum(control.tf(num, den), Ms, Mt, delay)
    assert design.certificate.Ms.gain.value <= Ms
    assert design.certificate.Mt.gain.value <= Mt
    span = np.linspace(-2, 4, 91) * (abs(design.k) + abs(design.ki))
    k, ki = np.meshgrid(span, design.ki * np.geomspace(1.002, 30, 40))
    assert not feasible(process, column(k), column(ki), 0.0, 1.0, Ms, Mt).any()
    assert abs(design.ki) <= design.bound <= 1.05 * abs(design.ki)


@pytest.mark.parametrize("case", CASES)
def test_an_optimum_touches_its_limits_where_it_says(case):
    (num, den, delay), Ms, Mt = CASES[case]
    design = pi_optimum(control.tf(num, den), Ms, Mt, delay)
    limits = {"S": Ms, "T": Mt}
    for contact in design.contacts:
        s = 1j * contact.frequency
        L = (design.k + design.ki / s) * np.polyval(num, s) / np.polyval(den, s) * np.exp(-s * delay)
        value = abs(1 / (1 + L)) if contact.function == "S" else abs(L / (1 + L))
        assert value == pytest.approx(limits[contact.function], rel=1e-8)
    assert 1 <= len(design.contacts) <= 2 or case == "a direct path"


def test_three_lags_with_a_peak_of_one_have_the_gains_of_a_closed_form():
    # |T| <= 1 is h(x) = (1 + x)^3 + 2 k (1 - 3 x) - 2 ki (3 - x) >= 0 with x = omega^2; h = h' = dh/dk = 0 by hand
    design = pi_optimum(control.tf(*LAGS[:2]), 2.0, 1.0)
    assert (design.k, design.ki) == pytest.approx((28 / 27, 4 / 9), rel=1e-8)
    (contact,) = design.contacts
    assert (contact.function, contact.frequency) == ("T", pytest.approx(1 / math.sqrt(3), rel=1e-6))


def test_gain_and_time_of_a_plant_only_scale_the_law():
    design = pi_optimum(control.tf([1.0], [2.0, 1.0]), 1.4, 1.4, 1.0)
    scaled = pi_optimum(control.tf([-50.0], [2e-3, 1.0]), 1.4, 1.4, 1e-3)
    assert scaled.k == pytest.approx(-design.k / 50, rel=1e-9)
    assert scaled.ki == pytest.approx(-design.ki / 50e-3, rel=1e-9)


def test_a_state_space_has_the_law_of_its_transfer_function():
    plant = control.tf([1.0], [1.0, 3.0, 3.0, 1.0])
    one, other = pi_optimum(plant, 1.6), pi_optimum(control.ss(plant), 1.6)
    assert other.k == pytest.approx(one.k, rel=1e-9)
    assert other.ki == pytest.approx(one.ki, rel=1e-9)


# k, ki of a dense search that zooms, sharing no code, for Mt = 1: the first touches at rest and once more
AT_REST = {
    "two contacts": (
        [1.931524528935736, 0.14088163752283017, -2.1818940077467888, -0.7086352942969985],
        [1.0, 2.476565752388295, 2.0773150736820014, 0.6629343242636483, 0.055150728575003416],
        3.0,
        -0.025997054,
    ),
    "one contact": (
        [5.97667007616527],
        [1.0, 10.063797615570135, 35.3354391750628, 50.21599788980961, 24.304748791610393, 3.723761978893688],
        1.7,
        0.13635984,
    ),
}


@pytest.mark.parametrize("case", AT_REST)
def test_a_peak_of_one_is_kept_in_T_and_is_no_smaller_than_a_search_finds(case):
    num, den, Ms, ki = AT_REST[case]
    design = pi_optimum(control.tf(num, den), Ms, 1.0)
    assert design.certificate.Mt.gain.value <= 1 + 1e-12
    assert 1 - 1e-6 <= design.ki / ki < 1.001
    assert abs(design.ki) <= design.bound < 1.01 * abs(design.ki)


REFUSALS = {
    "Bode": (([1.0], [1.0, 3.0, 3.0, 1.0], 0.0), {"Ms": 1.0}, "Ms = 1.*Bode"),
    "rest": (([1.0], [1.0, 3.0, 3.0, 1.0], 0.0), {"Mt": 0.9}, "Mt = 0.9.*infeasible"),
    "double integrator": (([1.0], [1.0, 0.0, 0.0], 0.0), {}, "no PI law stabilises"),
    "oscillator": (([1.0], [1.0, 0.0, 1.0], 0.0), {}, "no PI law stabilises"),
    "no largest ki": (([1.0], [1.0, 1.0], 0.0), {}, "no largest ki"),
    "zero at rest": (([1.0, 0.0], [1.0, 2.0, 1.0], 0.0), {}, "zero at s = 0"),
    "too fast an unstable pole": (([1.0], [1.0, -1.0], 0.1), {"Ms": 1.2}, "Ms = 1.2.*least Ms.*1.23"),
    "both together": (([1.0], [1.0, -1.0], 0.1), {"Ms": 1.26, "Mt": 1.26}, "infeasible"),
    "two integrators and no peak": (([1.0], [1.0, 1.0, 0.0], 0.3), {"Mt": 1.0}, "Mt = 1 is infeasible"),
    "nothing asked": (([1.0], [1.0, 1.0], 1.0), {"Ms": math.inf}, "must limit one"),
    "not proper": (([1.0, 1.0, 1.0], [1.0, 1.0], 1.0), {}, "proper"),
    "a delay that foresees": (([1.0], [1.0, 1.0], -1.0), {}, "delay"),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_what_has_no_optimum_is_refused_by_name(case):
    (num, den, delay), limits, words = REFUSALS[case]
    with pytest.raises(ValueError, match=words):
        pi_optimum(control.tf(num, den), **limits, delay=delay)


def test_a_hidden_unstable_mode_and_a_period_are_refused():
    hidden = control.ss([[-1.0, 0.0], [0.0, 1.0]], [[1.0], [0.0]], [[1.0, 1.0]], 0.0)
    with pytest.raises(DesignError, match="not stable and that its input does not move"):
        pi_optimum(hidden)
    with pytest.raises(ValueError, match="continuous time"):
        pi_optimum(control.tf([1.0], [1.0, -0.5], 0.1))


def test_a_derivative_gives_the_integral_gain_of_an_exhaustive_search():
    # the grid in (k, kd, ki) about the optimum, in steps of 1 % of ki, over a third to three times each gain
    design = pid_optimum(control.tf(*LAGS[:2]), 1.4, 1.4, N=20.0)
    k, kd = np.meshgrid(design.k * np.linspace(0.3, 2.5, 45), design.kd * np.linspace(0.3, 2.5, 45))
    for share in (1.01, 1.1, 1.5, 3.0):
        ki = np.full(k.shape, share * design.ki)
        assert not feasible(LAGS, column(k), column(ki), column(kd), 20.0, 1.4, 1.4).any()
    assert design.certificate.Ms.gain.value <= 1.4
    assert design.certificate.Mt.gain.value <= 1.4


@pytest.mark.heavy
def test_a_derivative_stabilises_the_double_integrator():
    design = wb.tune_pid(control.tf([1.0], [1.0, 0.0, 0.0]), form="PID", N=20.0, Ms=1.6)
    assert design.certificate.stable
    assert design.certificate.Ms.gain.value <= 1.6


@pytest.mark.heavy
def test_a_filter_is_chosen_for_a_noise_gain():
    design = pid_optimum(control.tf([1.0], [2.0, 1.0]), 1.6, 1.6, 1.0, noise_gain=8.0)
    omega = np.geomspace(1e-3, 1e4, 200000)
    s = 1j * omega
    law = design.k + design.ki / s + design.kd * s / (1 + s / design.N)
    peak = np.abs(law / (1 + law * np.exp(-s) / (2 * s + 1))).max()
    assert 7.9 < peak <= 8.0 * (1 + 1e-3)
    assert design.noise_gain == pytest.approx(peak, rel=1e-2)
    with pytest.raises(DesignError, match="no room for a derivative"):
        pid_optimum(control.tf([1.0], [2.0, 1.0]), 1.6, 1.6, 1.0, noise_gain=0.5)
    with pytest.raises(ValueError, match="exactly one of the two"):
        pid_optimum(control.tf([1.0], [2.0, 1.0]), delay=1.0)
