"""A bandwidth is the first of all crossings, by closed forms, python-control and MATLAB's definition."""

import math

import control
import mpmath
import numpy as np
import pytest

import workbench as wb
from workbench.design.frequency import sensitivity_bandwidth

s = control.tf("s")


@pytest.mark.parametrize("zeta", [0.1, 0.5, 1.0, 3.0])
def test_a_second_order_system_has_the_bandwidth_of_its_formula(zeta):
    mpmath.mp.dps = 60
    found = wb.bandwidth(control.tf([5], [1, 2 * zeta, 1])).frequency
    a, level = 1 - 2 * mpmath.mpf(zeta) ** 2, mpmath.mpf(10) ** (mpmath.mpf(3) / 10)
    exact = mpmath.sqrt(a + mpmath.sqrt(a**2 - 1 + level))
    assert found.low <= exact <= found.high
    assert found.error < 1e-15 * found.value


@pytest.mark.parametrize(
    "system",
    [
        1 / (s + 1),
        10 * (s + 2) / ((s + 1) * (s + 3) * (s + 4)),
        control.ss([[-1, 2], [0, -5]], [[0], [1]], [[1, 0]], 0),
    ],
)
def test_it_is_that_of_python_control(system):
    # whose bisection ends at 1e-12 and starts from a grid
    assert wb.bandwidth(system).frequency.value == pytest.approx(control.bandwidth(system), rel=1e-9)


def test_a_notch_between_two_points_of_a_grid_ends_the_band():
    # a notch of the relative width 1e-7 about 1 rad/s in a system that follows up to 1000
    notch = (s**2 + 1e-9 * s + 1) / (s**2 + 1e-7 * s + 1)
    found = wb.bandwidth(notch * 1000 / (s + 1000))
    assert found.frequency.value == pytest.approx(1, rel=1e-6)
    assert [row.is_falling for row in found.crossings] == [True, False, True]
    assert found.crossings[-1].frequency.value == pytest.approx(1000 * math.sqrt(10**0.3 - 1), rel=1e-5)


def test_a_gain_that_stays_has_no_end_of_its_band():
    found = wb.bandwidth((s + 1) / (s + 2))
    assert (found.frequency.value, found.crossings) == (math.inf, ())


def test_in_a_computer_it_ends_at_nyquists_frequency():
    h, a = 0.1, 0.9
    found = wb.bandwidth(control.tf([1 - a], [1, -a], h)).frequency
    # |1 - a|^2 10^0.3 = 1 - 2 a cos(w h) + a^2
    cosine = (1 + a**2 - (1 - a) ** 2 * 10**0.3) / (2 * a)
    assert found.value == pytest.approx(math.acos(cosine) / h, rel=1e-13)
    assert wb.bandwidth(control.tf([1, 0], [1, -0.1], h)).frequency.value == math.inf


def test_the_drop_may_be_another():
    assert wb.bandwidth(1 / (s + 1), 20 * math.log10(math.sqrt(5))).frequency.value == pytest.approx(2, rel=1e-14)


def test_a_sensitivity_is_of_use_up_to_where_it_rises_above_the_level():
    # S = s / (s + 1): |S|^2 = w^2 / (1 + w^2) = 10^-0.3
    found = sensitivity_bandwidth(s / (s + 1))
    assert found.frequency.value == pytest.approx(math.sqrt(1 / (10**0.3 - 1)), rel=1e-14)
    assert [row.is_falling for row in found.crossings] == [False]
    assert sensitivity_bandwidth(1 / (s + 1)).frequency.value == 0


def test_a_loop_has_the_bandwidths_of_its_kinds():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    linear = wb.linear_loop(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)))
    found = linear.bandwidth("closed", "omega_ref", "omega").frequency.value
    gain = np.abs(linear.response([found], "closed", "omega_ref", "omega").values)
    assert 20 * np.log10(gain) == pytest.approx(-3, abs=1e-9)
    rises = linear.bandwidth("S").frequency.value
    assert 20 * np.log10(np.abs(linear.response([rises], "S").values)) == pytest.approx(-3, abs=1e-9)
    info = linear.step_info("omega_ref", "omega")
    system = linear.system("closed", "omega_ref", "omega")
    t = np.linspace(0, 5, 50_001)
    assert info.overshoot.value == pytest.approx(control.step_info(system, t)["Overshoot"], abs=1e-3)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: wb.bandwidth(1 / (s + 1), 0.0), "drop"),
        (lambda: wb.bandwidth(1 / (s + 1), -3.0), "drop"),
        (lambda: wb.bandwidth(1 / (s + 1), 1e4), "at most 1000 dB"),
        (lambda: wb.bandwidth(s / (s + 1)), "passes nothing there"),
    ],
)
def test_bad_input_gets_a_sentence(call, words):
    with pytest.raises(ValueError, match=words):
        call()
