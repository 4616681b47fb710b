"""Certified margins of one loop: closed forms, python-control, the definition of each margin, and refusals."""

import math

import control
import numpy as np
import pytest
from scipy.linalg import block_diag

from workbench.design.frequency import c2d, stability_margins
from workbench.design.frequency.estimated_margins import estimated_margins
from workbench.design.frequency.half_planes import unstable_roots
from workbench.design.frequency.positive_roots import positive_roots
from workbench.design.matrices import DesignError


def encloses(value, exact):
    """True if the bounds hold the exact number, and are narrow."""
    return value.low <= exact <= value.high and value.error <= 1e-10 * abs(exact)


def test_the_margins_of_a_triple_lag_are_those_of_its_closed_form():
    # 4 / (s + 1)^3: -180 degrees at sqrt 3, where |L| = 1/2; |1 + L|^2 is least at sqrt 2
    found = stability_margins(control.tf([4], [1, 3, 3, 1]))
    assert found.stable
    (gain,), (phase,) = found.gain_crossovers, found.phase_crossovers
    assert encloses(phase.frequency, math.sqrt(3))
    assert encloses(phase.margin, 2.0)
    assert encloses(gain.frequency, math.sqrt(4 ** (2 / 3) - 1))
    assert encloses(found.Ms.gain, 3.0)
    assert encloses(found.Mt.gain, 1 + math.sqrt(2))
    assert found.Ms.frequency == pytest.approx(math.sqrt(2), rel=1e-15)
    assert found.gain_low.value == 0


@pytest.mark.parametrize("delay", [1e-6, 0.3, 1.0, 1.5])
def test_an_integrator_with_a_delay_loses_its_margins_at_a_quarter_turn(delay):
    found = stability_margins(control.tf([1], [1, 0]), delay)
    assert encloses(found.gain_high, math.pi / 2 / delay)
    assert found.delay_margin.value == pytest.approx(math.pi / 2 - delay, rel=1e-12)
    for k, row in enumerate(found.phase_crossovers):
        assert encloses(row.frequency, (math.pi / 2 + 2 * math.pi * k) / delay)
    assert not stability_margins(control.tf([1], [1, 0]), 1.58).stable


def test_a_peak_that_is_narrower_than_any_grid_is_seen():
    # 0.08 / (s (s^2 + 0.001 s + 100)): L(10 j) = -0.8
    margins = stability_margins(control.tf([0.08], [1, 0.001, 100, 0])).margins
    assert margins.gain_high.value == pytest.approx(1.25, rel=1e-12)
    # |S| has a pole at 1/5 of the damping beside 10 rad/s, so Ms is 5 to first order
    assert margins.Ms.gain.value == pytest.approx(5, rel=1e-6)
    sharper = stability_margins(control.tf([1.8e-7], [1, 2e-7, 1, 0])).margins
    assert sharper.gain_high.value == pytest.approx(1 / 0.9, rel=1e-12)


def test_a_delay_that_stabilises_is_counted_and_then_destabilises():
    # 1 - 0.5 exp(-s tau) / (s^2 + 1) = 0 has roots on the axis without a delay, which move left
    oscillator = control.tf([-0.5], [1, 0, 1])
    states = [stability_margins(oscillator, delay).stable for delay in (0.0, 0.2, 1.0, 2.5, 2.6)]
    assert states == [False, True, True, True, False]  # lost at pi / sqrt(3/2) = 2.565


def test_a_touch_counts_once_and_a_hidden_mode_decides():
    touch = stability_margins(control.tf([1, 0], [1, 1, 1]))
    assert [(row.frequency.value, row.margin.value) for row in touch.gain_crossovers] == [(1.0, 180.0)]
    assert not stability_margins(control.tf([1, -1], [1, 0, -1])).stable
    assert not stability_margins(control.tf([1, -1], [1, 0, -1]), 0.1).stable
    assert stability_margins(control.tf([1, 2], [1, 3, 2])).stable


def test_the_real_axis_is_crossed_at_zero_at_infinity_and_at_nyquist_too():
    assert stability_margins(control.tf([-0.5], [1, 1])).gain_high.value == 2.0
    (row,) = stability_margins(control.tf([-0.5, 0], [1, 1])).phase_crossovers
    assert (row.frequency.value, row.margin.value) == (math.inf, 2.0)
    total = stability_margins(control.tf([0.5], [1, -1], 1.0))
    assert total.gain_high.value == 4.0
    assert total.phase_crossovers[0].frequency.value == pytest.approx(math.pi, rel=1e-15)


def test_a_gain_above_one_at_infinity_stands_no_delay():
    assert stability_margins(control.tf([2], [1])).delay_margin.value == 0
    assert not stability_margins(control.tf([2, 1], [1, 1]), 1e-3).stable
    constant = stability_margins(control.tf([1], [1]))
    assert constant.disk_margin.value == math.inf
    assert len(constant.remarks) == 2


@pytest.mark.parametrize("seed", range(12))
def test_random_loops_have_the_margins_of_python_control(seed):
    rng = np.random.default_rng(seed)
    loop = control.tf(rng.normal(size=3), np.poly(-(10.0 ** rng.uniform(-1, 1, 4))))
    found = stability_margins(loop)
    gains, phases, _, at_phase, at_gain, _ = control.stability_margins(loop, returnall=True)
    ours = {row.frequency.value: row.margin.value for row in found.phase_crossovers}
    for w in [w for w in at_phase if w > 0]:
        near = min(ours, key=lambda omega: abs(omega - w))
        assert (near, ours[near]) == pytest.approx((w, gains[list(at_phase).index(w)]), rel=1e-6)
    assert [row.frequency.value for row in found.gain_crossovers] == pytest.approx(list(at_gain), rel=1e-6)
    assert [row.margin.value for row in found.gain_crossovers] == pytest.approx(list(phases), rel=1e-6)
    assert found.stable == bool((control.feedback(1, loop).poles().real < 0).all())


@pytest.mark.parametrize("seed", range(8))
def test_peaks_with_a_delay_are_not_below_those_on_a_dense_grid_and_enclose_them(seed):
    rng = np.random.default_rng(seed)
    num, den = [float(rng.uniform(0.2, 0.8))], np.poly([*-(10.0 ** rng.uniform(-1, 1, 3)), 0.0][seed % 2 :])
    found = stability_margins(control.tf(num, den), 0.4)
    if found.margins is None:
        return
    s = 1j * np.logspace(-8, 3, 400_000)  # a peak may be the limit at zero
    late, own = np.polyval(num, s) * np.exp(-0.4 * s), np.polyval(den, s)
    for peak, grid in ((found.Ms, own / (own + late)), (found.Mt, late / (own + late))):
        most = float(np.abs(grid).max())
        assert most * (1 - 1e-12) <= peak.gain.high
        assert peak.gain.low <= most * (1 + 1e-6 * most**2)  # a high peak is narrow, and falls between the points
        assert peak.gain.error < 1e-9 * most
    balance = float(np.abs((own - late) / (own + late)).max())
    assert found.disk_margin.value == pytest.approx(2 / balance, rel=1e-6 * balance**2)


def test_periods_of_delay_are_poles_at_zero():
    late = stability_margins(control.tf([0.4], [1, -1], 2.0), delay=2.0)
    assert late == stability_margins(control.tf([0.4], [1, -1, 0], 2.0))
    assert late.phase_crossovers[0].frequency.value == pytest.approx(math.pi / 6, rel=1e-14)  # of 2 s


def test_a_state_space_has_the_margins_of_its_transfer_function():
    A, B, C = np.array([[0.0, 1.0], [-2.0, -0.25]]), np.array([[0.0], [1.5]]), np.array([[1.0, 0.5]])
    found = stability_margins(control.ss(A, B, C, [[0.25]]))
    assert found == stability_margins(control.tf([0.25, 0.8125, 2.0], [1, 0.25, 2]))


LAG = 0.005  # s


def flexible(modes, period=0):
    """Many lightly damped modes, whose rates are held through a lag; with a period, as samples show them."""
    w = np.geomspace(1.0, 100.0, modes)
    A = block_diag(*[[[0.0, one], [-one, -0.04 * one]] for one in w])
    B, C = np.tile([[0.0], [1.0]], (modes, 1)), 0.5 * np.tile([[0.0, 1.0]], (1, modes))
    loop = control.ss(A, B, C, 0) * control.ss(-1 / LAG, 1 / LAG, 1, 0)
    return c2d(loop, period) if period else loop


@pytest.mark.parametrize("loop", [flexible(8), flexible(6, 0.002), 3 * control.ss(control.tf([25], [1, 10, 10, 10]))])
def test_estimated_margins_hold_the_exact_ones_within_their_errors(loop):
    exact, near = stability_margins(loop), estimated_margins(loop, 0.0)
    assert exact.stable == near.stable
    pairs = []
    for name in ("gain_crossovers", "phase_crossovers"):
        assert len(getattr(exact, name)) == len(getattr(near, name))
        for a, b in zip(getattr(exact, name), getattr(near, name), strict=True):
            pairs += [(a.frequency, b.frequency), (a.margin, b.margin)]
    if exact.margins:
        names = ("gain_low", "gain_high", "phase_margin", "delay_margin", "disk_margin")
        pairs += [(getattr(exact.margins, name), getattr(near.margins, name)) for name in names]
        pairs += [(exact.margins.Ms.gain, near.margins.Ms.gain), (exact.margins.Mt.gain, near.margins.Mt.gain)]
    for a, b in pairs:
        assert b.low <= a.high
        assert a.low <= b.high
        assert b.error <= 3e-6 * abs(b.value) + 1e-300 or b.error == 0


@pytest.mark.heavy
def test_a_loop_of_two_hundred_states_has_margins_that_a_dense_grid_confirms_and_says_that_they_are_estimates():
    loop = flexible(100)
    found = stability_margins(loop)
    assert found.stable
    assert "201 states" in found.remarks[0]
    # the response of the modes in closed form
    w, omega = np.geomspace(1.0, 100.0, 100), np.geomspace(0.1, 1000.0, 100_001)
    L = sum(0.5j * omega / (one**2 - omega**2 + 0.04j * one * omega) for one in w) / (1 + LAG * 1j * omega)
    assert found.Ms.gain.value == pytest.approx(np.abs(1 / (1 + L)).max(), rel=1e-4)
    assert found.disk_margin.value == pytest.approx(2 / np.abs((1 - L) / (1 + L)).max(), rel=1e-4)
    turns = np.flatnonzero(np.diff(np.sign(np.abs(L) - 1)))
    assert [row.frequency.value for row in found.gain_crossovers] == pytest.approx(list(omega[turns]), rel=1e-4)


@pytest.mark.parametrize(
    ("loop", "delay", "words"),
    [
        (control.tf([1, 0, 1], [1, 1]), 0.0, "must be proper"),
        (control.tf([-1, -2], [1, 1]), 0.0, "well-posed"),
        (control.tf([1], [1, 1]), -1.0, "not negative"),
        (control.tf([1], [1, 1], 0.1), 0.05, "whole periods"),
        (control.tf([1], [1, 1], True), 0.0, "period in s"),
        (control.ss(-np.eye(2), np.eye(2), np.eye(2), 0), 0.0, "one channel"),
        (control.ss(-np.eye(41), np.ones((41, 1)), np.ones((1, 41)), 0), 0.1, "zero for a continuous loop with more"),
        (control.ss(-np.eye(401), np.ones((401, 1)), np.ones((1, 401)), 0), 0.0, "at most 400 states"),
        (control.tf([1], np.ones(43)), 0.0, "at most 40 poles as a `TransferFunction`"),
        ("1/s", 0.0, "a `StateSpace` or `TransferFunction`"),
        (control.tf([1], [1, 0]), math.pi / 2, "so near that doubles do not tell"),
    ],
)
def test_a_loop_without_margins_is_refused_by_name(loop, delay, words):
    with pytest.raises(ValueError, match=words):
        stability_margins(loop, delay)
    assert issubclass(DesignError, ValueError)


def test_roots_are_isolated_however_near_and_counted_by_half_planes():
    # (x - 1)(1e6 x - 1000001)(x - 3)^2
    roots = positive_roots([9 * 1000001, -15 * 1000001 - 9000000, 7 * 1000001 + 15000000, -1000001 - 7000000, 1000000])
    assert [root.multiplicity for root in roots] == [1, 1, 2]
    assert [float(root.middle) for root in roots] == [1.0, 1.000001, 3.0]
    assert unstable_roots([-1, 0, 0, 1]) == (1, 0)  # s^3 - 1
    assert unstable_roots([1, 0, 1]) == (0, 2)
    assert unstable_roots([1, 0, 0, 0, 1]) == (2, 0)
