"""Systems on the edge of what a figure means, each against a closed form in sixty digits."""

import math

import control
import mpmath
import numpy as np
import pytest

import workbench as wb
from workbench.design.frequency import hold_loop

mpmath.mp.dps = 60


@pytest.mark.parametrize("excess", [0.0, 1e-12])
def test_a_touch_of_the_unit_circle_is_one_crossover_and_the_least_more_are_two(excess):
    k = 2.0 * (1 + excess)  # k s / (s + 1)^2 has the gain k / 2 at 1 rad/s, and its most there
    found = wb.stability_margins(control.tf([k, 0.0], [1.0, 2.0, 1.0]))
    half = mpmath.mpf(k) / 2
    exact = sorted({half - mpmath.sqrt(half**2 - 1), half + mpmath.sqrt(half**2 - 1)})
    assert len(found.gain_crossovers) == len(exact)
    for row, omega in zip(found.gain_crossovers, exact, strict=True):
        assert row.frequency.low <= omega <= row.frequency.high
        assert row.frequency.error < 1e-15


def test_a_pair_of_poles_on_the_axis_that_cancels_leaves_the_loop_unstable():
    found = wb.stability_margins(control.tf([1.0, 0.0, 4.0], np.polymul([1.0, 0.0, 4.0], [1.0, 2.0, 1.0])))
    assert not found.stable
    assert [row.frequency.value for row in found.gain_crossovers] == [0]  # of 1 / (s + 1)^2, which is left


def test_a_damping_of_a_billionth_decides_the_gain():
    found = wb.stability_margins(control.tf([1e-10], [1.0, 2e-9, 1.0, 0.0]))
    limit = mpmath.mpf(2e-9) / mpmath.mpf(1e-10)  # s (s^2 + d s + 1) + k n = 0 at s = j, where k n = d
    assert found.gain_high.low <= limit <= found.gain_high.high
    assert found.gain_high.error < 1e-14


def test_two_equal_peaks_of_two_channels_are_one_norm():
    d = 1e-3
    A = np.kron(np.eye(2), [[0.0, 1.0], [-1.0, -d]])
    B, C = np.kron(np.eye(2), [[0.0], [1.0]]), np.kron(np.eye(2), [[1.0, 0.0]])
    gain = wb.hinf_norm(control.ss(A, B, C, np.zeros((2, 2)))).gain
    exact = 1 / (mpmath.mpf(d) * mpmath.sqrt(1 - mpmath.mpf(d) ** 2 / 4))
    assert gain.low <= exact <= gain.high


def test_a_fast_pole_behind_a_hold_leaves_the_slow_one():
    h, fast = 0.05, 1e5  # exp(-5000) is no double
    plant = control.ss([[-fast, 0.0], [1.0, -1.0]], [[fast], [0.0]], [[0.0, 1.0]], 0.0)
    omega = np.array([0.1, 1.0, 0.5, 0.9]) * np.pi / h
    omega.sort()
    loop = hold_loop(plant, control.ss([], [], [], 1.5, h), 0.0).response(omega).loop[:, 0, 0]
    p = mpmath.mpf(fast)
    parts = {mpmath.mpf(0): mpmath.mpf(1), mpmath.mpf(-1): -p / (p - 1), -p: 1 / (p - 1)}  # of p / ((s + p)(s + 1) s)
    for w, value in zip(omega, loop, strict=True):
        z = mpmath.expj(mpmath.mpf(w) * mpmath.mpf(h))
        exact = complex(1.5 * (z - 1) * sum(c / (z - mpmath.exp(q * mpmath.mpf(h))) for q, c in parts.items()))
        assert abs(value - exact) <= 1e-10 * abs(exact)


def test_four_integrators_at_a_millisecond_and_half_a_period_late_keep_ten_digits():
    h, delay = 1e-3, 5e-4
    plant = control.ss(np.eye(4, k=1), np.eye(4)[:, 3:], np.eye(4)[:1], 0.0)
    omega = np.array([0.01, 0.1, 0.5, 0.9]) * np.pi / h
    loop = hold_loop(plant, control.ss([], [], [], 0.02, h), delay).response(omega).loop[:, 0, 0]
    eulerian = [[1], [1], [1, 1], [1, 4, 1], [1, 11, 11, 1]]  # sum k^m x^k = x E_m(x) / (1 - x)^(m + 1)
    for w, value in zip(omega, loop, strict=True):
        x = mpmath.expj(-mpmath.mpf(w) * mpmath.mpf(h))
        total = mpmath.mpf(0)
        for m, row in enumerate(eulerian):  # of the samples (k h - delay)^4 / 24 of a late step
            ways = math.comb(4, m) * mpmath.mpf(h) ** m * (-mpmath.mpf(delay)) ** (4 - m)
            total += ways * x * sum(a * x**i for i, a in enumerate(row)) / (1 - x) ** (m + 1)
        exact = complex(mpmath.mpf(0.02) * (1 - x) * total / 24)
        assert abs(value - exact) <= 1e-10 * abs(exact)


def test_modes_that_nothing_moves_or_that_do_not_show_are_zeros_of_the_pencil_alone():
    system = control.ss(np.diag([-1.0, -2.0, -3.0, -4.0]), [[1], [1], [0], [0]], [[1, 0, 1, 0]], 0)
    found = wb.pole_zero_structure(system)
    assert found.minimal_order == 1
    np.testing.assert_array_equal(np.sort(found.invariant_zeros.values.real), [-4, -3, -2])
    assert not len(found.transmission_zeros.values)
