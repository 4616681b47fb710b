"""References and disturbances: exact derivatives, and bounds that hold."""

import casadi as ca
import numpy as np
import pytest
from scipy.signal import square

from workbench.core import lift
from workbench.signals import Hold, Sines, SineTorque, SmoothSquareWave, SquareWave

WAVE = SmoothSquareWave([1.0, -0.5], frequency=0.5, rise=0.05)
SINES = Sines([1.0, 2.0], [3.0, 0.7], [0.1, -0.4])


def motion(reference, times):
    """q, qd, qdd, each (N, n)."""
    t = ca.SX.sym("t")
    function = ca.Function("motion", [t], [ca.densify(ca.SX(part)) for part in reference.at(t).values()])
    return [np.array(part).T for part in function(np.asarray(times)[None])]


def torque(disturbance, times):
    t = ca.SX.sym("t")
    return np.array(ca.Function("D", [t], [ca.densify(ca.SX(disturbance.at(t)))])(np.asarray(times)[None])).T


@pytest.mark.parametrize("reference", [SINES, WAVE, Hold([0.3, -0.2])])
def test_the_derivatives_of_a_reference_are_those_of_its_position(reference):
    t, h = np.linspace(0.01, 7.0, 701), 1e-5
    before, now, after = (motion(reference, t + shift) for shift in (-h, 0.0, h))
    for order in (0, 1):
        difference = (after[order] - before[order]) / (2 * h)
        # h^2 / 6 times a third (fourth) derivative of at most 2 / rise^3 (16 / rise^4), and eps / h
        np.testing.assert_allclose(now[order + 1], difference, rtol=0, atol=1e-10 / 6 * 16 / 0.05**4)


def test_the_velocity_of_a_sine_is_its_complex_step():
    t, h = np.linspace(0.0, 7.0, 101)[:, None], 1e-20
    a, w, phase = SINES.amplitude, SINES.frequency, SINES.phase
    exact = (a * np.sin(w * (t + 1j * h) + phase)).imag / h
    np.testing.assert_allclose(motion(SINES, t.ravel())[1], exact, rtol=0, atol=1e-14)


def test_a_square_wave_is_that_of_scipy():
    f = 0.3
    # off the jumps, where the two may differ by the rounding of pi f t
    t = np.linspace(0.0, 20.0, 997)
    t = t[np.abs(f * t - np.round(f * t)) > 1e-9]
    wave = SquareWave([2.0, -1.0], frequency=f)
    expected = np.outer((square(np.pi * f * t) + 1) / 2, [2.0, -1.0])
    q, qd, qdd = motion(wave, t)
    np.testing.assert_array_equal(q, expected)
    assert not qd.any()
    assert not qdd.any()


def test_a_square_wave_begins_high_and_falls_on_the_hour():
    q = motion(SquareWave([1.0], frequency=0.5), [0.0, 1.999, 2.0, 3.999, 4.0])[0].ravel()
    np.testing.assert_array_equal(q, [1, 1, 0, 0, 1])


def test_the_smooth_wave_tends_to_the_square_one_as_its_rise_goes_to_zero():
    f, t = 0.5, np.linspace(0.0, 8.0, 2001)
    hard = motion(SquareWave([1.0], frequency=f), t)[0]
    gaps = []
    for rise in (0.08, 0.04, 0.02, 0.01):
        soft = motion(SmoothSquareWave([1.0], frequency=f, rise=rise), t)[0]
        gaps.append(np.abs(soft - hard).mean())
        far = np.abs(np.sin(np.pi * f * t)) > 20 * np.pi * f * rise  # tanh(20) is 1 - 4e-18
        np.testing.assert_allclose(soft[far], hard[far], rtol=0, atol=1e-15)
    # what is left lies near the jumps, in proportion to the rise
    np.testing.assert_allclose(np.array(gaps[:-1]) / gaps[1:], 2.0, rtol=0.15)


def test_near_a_jump_the_smooth_wave_is_a_tanh_over_its_rise():
    near = np.linspace(-0.1, 0.1, 21)
    q = motion(SmoothSquareWave([1.0], frequency=0.5, rise=0.05), 4.0 + near)[0].ravel()
    # sin(x) / x differs from 1 by x^2 / 6 = 4e-3 at 0.1 s of a wave of period 4 s
    np.testing.assert_allclose(q, (np.tanh(near / 0.05) + 1) / 2, atol=4e-3)


def test_the_bounds_of_a_disturbance_hold_and_are_nearly_reached():
    D = SineTorque([2.0, 1.0], [1.0, np.sqrt(2.0)], [0.3, -0.2])
    t, h = np.linspace(0.0, 2000.0, 400_001), 1e-5
    size = np.linalg.norm(torque(D, t), axis=1)
    rate = np.linalg.norm((torque(D, t + h) - torque(D, t - h)) / (2 * h), axis=1)
    # frequencies without a common period come as near to peaking together as one likes, given time
    assert 0.999 * D.D_max < size.max() <= D.D_max
    assert 0.999 * D.L_D < rate.max() <= D.L_D * (1 + 1e-9)


def test_the_peak_of_one_sine_is_its_bound():
    D = SineTorque([3.0], [2.0])
    assert (D.D_max, D.L_D) == (3.0, 6.0)
    np.testing.assert_allclose(torque(D, [np.pi / 4]), [[3.0]], rtol=1e-15)


@pytest.mark.parametrize("signal", [SINES, WAVE, SquareWave([1.0, 2.0], 0.5), Hold([0.3, -0.2])])
def test_a_lifted_reference_says_the_same(signal):
    t = ca.SX.sym("t")
    lifted = lift(signal)
    twin = ca.vertcat(*[ca.SX(part) for part in lifted.block.at(t).values()])
    plain = ca.vertcat(*[ca.SX(part) for part in signal.at(t).values()])
    gap = ca.Function("gap", [t, lifted.symbols], [twin - plain])
    for time in (0.0, 0.3, 2.1):
        np.testing.assert_allclose(np.array(gap(time, lifted.layout.default)), 0, atol=1e-12)  # rounding of w t


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: SquareWave([1.0], frequency=0.0), r"`SquareWave\(frequency=...\)`"),
        (lambda: SmoothSquareWave([1.0], frequency=1.0, rise=-0.1), r"`SmoothSquareWave\(rise=...\)`"),
        (lambda: Sines([1.0, 2.0], [1.0, 2.0, 3.0]), r"`Sines\(frequency=...\)` must be an array of shape \(n = 2\)"),
        (
            lambda: Sines([[1.0]], 2.0),
            r"`Sines\(amplitude=...\)` must be an array of shape \(n = 1\); got shape \(1, 1\)",
        ),
        (lambda: SineTorque([np.nan], [1.0]), "must be finite"),
    ],
)
def test_a_signal_that_cannot_be_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_one_frequency_stands_for_all_joints():
    np.testing.assert_array_equal(Sines([1.0, 2.0], 3.0).frequency, [3.0, 3.0])
    assert Sines([1.0, 2.0], 3.0).dof == 2
