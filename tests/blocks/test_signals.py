"""Motions that arms are to follow: exact derivatives, and what cannot be."""

import casadi as ca
import numpy as np
import pytest
from scipy.signal import square

from workbench.blocks.signals import Constant, Sines, SineTorque, SquareWave
from workbench.core import lift

SINES = Sines("q", "rad", [1.0, 2.0], [3.0, 0.7], [0.1, -0.4])


def motion(reference, times):
    """q, qd, qdd, each (N, n)."""
    t = ca.SX.sym("t")
    function = ca.Function("motion", [t], [ca.densify(ca.SX(part)) for part in reference.at(t).values()])
    return [np.array(part).T for part in function(np.asarray(times)[None])]


@pytest.mark.parametrize("reference", [SINES, Constant("q", "rad", [0.3, -0.2])])
def test_the_derivatives_of_a_reference_are_those_of_its_position(reference):
    t, h = np.linspace(0.01, 7.0, 701), 1e-5
    before, now, after = (motion(reference, t + shift) for shift in (-h, 0.0, h))
    for order in (0, 1):
        difference = (after[order] - before[order]) / (2 * h)
        # h^2 / 6 = 2e-11 times a third (fourth) derivative of at most 81, and eps / h = 2e-11 of a value of at most 6
        np.testing.assert_allclose(now[order + 1], difference, rtol=0, atol=2e-9)


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
    wave = SquareWave("q", "rad", [2.0, -1.0], frequency=f)
    expected = np.outer((square(np.pi * f * t) + 1) / 2, [2.0, -1.0])
    q, qd, qdd = motion(wave, t)
    np.testing.assert_array_equal(q, expected)
    assert not qd.any()
    assert not qdd.any()


def test_a_square_wave_begins_high_and_falls_on_the_hour():
    q = motion(SquareWave("q", "rad", [1.0], frequency=0.5), [0.0, 1.999, 2.0, 3.999, 4.0])[0].ravel()
    np.testing.assert_array_equal(q, [1, 1, 0, 0, 1])


@pytest.mark.parametrize("signal", [SINES, SquareWave("q", "rad", [1.0, 2.0], 0.5), Constant("q", "rad", [0.3, -0.2])])
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
        (lambda: SquareWave("q", "rad", [1.0], frequency=0.0), r"`SquareWave\(frequency=...\)`"),
        (
            lambda: Sines("q", "rad", [1.0, 2.0], [1.0, 2.0, 3.0]),
            r"`Sines\(frequency=...\)` must be an array of shape \(n = 2\)",
        ),
        (
            lambda: Sines("q", "rad", [[1.0]], 2.0),
            r"`Sines\(amplitude=...\)` must be an array of shape \(n = 1\); got shape \(1, 1\)",
        ),
        (lambda: SineTorque([np.nan], [1.0]), "must be finite"),
    ],
)
def test_a_signal_that_cannot_be_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_one_frequency_stands_for_all_joints():
    np.testing.assert_array_equal(Sines("q", "rad", [1.0, 2.0], 3.0).frequency, [3.0, 3.0])
    assert Sines("q", "rad", [1.0, 2.0], 3.0).dof == 2
