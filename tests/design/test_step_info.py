"""The figures of a step response are those of closed forms, of python-control and of sums in sixty digits."""

import math

import control
import mpmath
import numpy as np
import pytest

import workbench as wb
from workbench.design.matrices import DesignError

s = control.tf("s")
FIGURES = ("rise_time", "settling_time", "overshoot", "undershoot", "peak", "peak_time", "final")
NAMES = {
    "rise_time": "RiseTime",
    "settling_time": "SettlingTime",
    "overshoot": "Overshoot",
    "undershoot": "Undershoot",
    "peak": "Peak",
}


def encloses(found, exact, width):
    """True if the bounds hold an exact number and are no wider than a relative width."""
    return found.low <= exact <= found.high and found.high - found.low <= width * max(1.0, abs(found.value))


def second_order(zeta):
    """Overshoot, peak time, rise and settling time of 1 / (s^2 + 2 zeta s + 1), in sixty digits by mpmath."""
    mpmath.mp.dps = 60
    zeta = mpmath.mpf(2 * zeta) / 2  # the double that is written into the transfer function
    wd = mpmath.sqrt(1 - zeta**2)

    def y(t):
        return 1 - mpmath.exp(-zeta * t) * (mpmath.cos(wd * t) + zeta / wd * mpmath.sin(wd * t))

    def crossing(level, low, high):
        return mpmath.findroot(lambda t: y(t) - level, (low, high), solver="anderson")

    peak = mpmath.pi / wd
    rise = crossing(mpmath.mpf("0.9"), peak / 3, peak) - crossing(mpmath.mpf("0.1"), peak / 100, peak / 2)
    k = 1
    while mpmath.exp(-zeta * (k + 1) * peak) > mpmath.mpf("0.02"):
        k += 1  # the last extremum that leaves the band
    settling = crossing(1 - (-1) ** k * mpmath.mpf("0.02"), k * peak, (k + 1) * peak)
    return 100 * mpmath.exp(-zeta * peak), peak, rise, settling


@pytest.mark.parametrize("zeta", [0.1, 0.3, 0.5, 0.7])
def test_a_second_order_system_has_the_figures_of_its_formula(zeta):
    info = wb.step_info(control.tf([1], [1, 2 * zeta, 1]))
    overshoot, peak_time, rise, settling = second_order(zeta)
    assert encloses(info.overshoot, overshoot, 1e-14)
    assert encloses(info.peak_time, peak_time, 1e-14)
    assert encloses(info.rise_time, rise, 1e-14)
    assert encloses(info.settling_time, settling, 1e-14)
    assert encloses(info.peak, 1 + overshoot / 100, 1e-14)


def test_a_lag_never_reaches_its_final_value():
    info = wb.step_info(control.tf([3], [2, 1]))
    assert encloses(info.rise_time, 2 * mpmath.log(9), 1e-14)
    assert encloses(info.settling_time, 2 * mpmath.log(50), 1e-14)
    assert (info.overshoot.value, info.overshoot.high) == (0, 0)
    assert (info.peak.value, info.peak_time.value) == (3, math.inf)


def test_a_light_damping_settles_after_forty_million_seconds():
    info = wb.step_info(control.tf([1], [1, 2e-7, 1]))
    # envelope: exp(-1e-7 t) = 0.02 at 39120230 s; the last crossing is within half a turn of it
    assert abs(info.settling_time.value - math.log(50) / 1e-7) < math.pi
    assert info.settling_time.error < 1e-7
    assert encloses(info.peak_time, mpmath.pi / mpmath.sqrt(1 - (mpmath.mpf(2e-7) / 2) ** 2), 1e-15)


def test_a_small_resonance_overshoots_where_a_grid_sees_nothing():
    # 1 / (s + 1) and a resonance of 0.1 % at 60 rad/s, which decays with 0.5 1/s
    info = wb.step_info(1 / (s + 1) + 1e-3 * 3600 / (s**2 + s + 3600))
    assert info.overshoot.low > 0
    assert info.overshoot.error < 1e-12


SYSTEMS = [
    4 / (s**2 + s + 4),
    (1 - s) / (s + 1) ** 2,
    (1 - s) / (s + 1),
    (2 - s) * (3 - s) / ((s + 1) * (s**2 + s + 6)),
    -3 * (s + 5) / ((s + 1) * (s + 2) * (s + 3)),
    1 / (s + 1) ** 3,
    (s + 0.1) / ((s + 0.09) * (s**2 + 0.3 * s + 1)),
    control.tf([1], np.poly([-0.1] * 4)),  # whose coefficients round, so that four poles lie close to each other
    control.ss([[-1, 5], [0, -2]], [[0], [1]], [[1, 0]], [[0.3]]),
]


@pytest.mark.parametrize("system", SYSTEMS)
def test_the_figures_are_those_of_python_control_within_its_grid(system):
    slowest = min(-system.poles().real)
    t = np.linspace(0, 25 / slowest, 6001)
    info, theirs = wb.step_info(system), control.step_info(system, t)
    y = control.step_response(system, t).outputs
    most = float(np.abs(np.diff(np.asarray(y))).max()) * max(
        1, 100 / abs(float(info.final.value))
    )  # of a step of the grid, in %
    for name, key in NAMES.items():
        allowed = 2.01 * t[1] if name.endswith("time") else 2 * most + 1e-4  # 1e-4: what is left at the last time
        assert getattr(info, name).value == pytest.approx(theirs[key], abs=allowed), name
    if math.isfinite(info.peak_time.value):
        assert (
            info.peak_time.value == pytest.approx(theirs["PeakTime"], abs=2 * t[1]) or info.peak_time.high == math.inf
        )


DISCRETE = [
    control.c2d(4 / (s**2 + s + 4), 0.1),
    control.c2d((1 - s) / (s + 1) ** 2, 0.25),
    control.tf([0.5, 0.1], [1, -0.5, 0.2, 0, 0], 0.1),
    control.tf([0.5], [1, 0.5], 1.0),
    control.tf([1, 0.2], [1, -0.9, 0.81 / 4], 0.1),
]


@pytest.mark.parametrize("system", DISCRETE)
def test_a_computer_has_the_figures_of_its_samples(system):
    t = system.dt * np.arange(2000)
    info, theirs = wb.step_info(system), control.step_info(system, t)
    for name, key in NAMES.items():
        assert getattr(info, name).value == pytest.approx(theirs[key], rel=1e-9, abs=1e-9), name


def test_a_dead_beat_response_reaches_its_final_value_in_two_periods():
    info = wb.step_info(control.tf([1], [1, 0, 0], 0.1))
    assert [getattr(info, name).value for name in FIGURES] == [0, 0.2, 0, 0, 1, 0.2, 1]


def test_a_sample_on_a_level_is_decided_by_fractions():
    # y = 0, 1/2, 3/4, ... 1 - 2^-k; the band of 2 % is left for the last time at k = 5
    info = wb.step_info(control.tf([0.5], [1, -0.5], 1.0))
    assert (info.settling_time.value, info.rise_time.value) == (6, 3)


def test_a_response_to_a_load_that_returns_to_zero_has_a_peak_alone():
    info = wb.step_info(s / (s + 1) ** 2)
    assert encloses(info.peak, mpmath.exp(-1), 1e-15)
    assert encloses(info.peak_time, 1, 1e-15)
    assert math.isnan(info.settling_time.value)
    assert "returns to zero" in info.remarks[0]


def test_a_constant_is_there_at_once():
    info = wb.step_info(control.tf([-2], [1]))
    assert [getattr(info, name).value for name in FIGURES] == [0, 0, 0, 0, 2, 0, -2]


REFUSED = [
    (control.tf([1], [1, 0]), "has an integrator, a pole at s = 0"),
    (control.tf([1], [1, -1], 0.1), "has an integrator, a pole at z = 1"),
    (control.tf([1], [1, -2, 5]), r"not stable, as its pole near 1[+-]2j"),
    (control.tf([1, -1], [1, 1, -2]), "not stable, as its pole near 1 "),  # which cancels
    (control.tf([1], [1, 0, 1]), "not stable, as its pole near -?0[+-]1j"),
    (control.tf([1], [1, 1.5], 0.1), "inside the unit circle"),
    (control.tf([1, 0, 0], [1, 1]), "must be proper"),
    (control.ss(-np.eye(200), np.ones((200, 1)), np.ones((1, 200)), 0), "200. Reduce its order"),
    (control.ss(-np.eye(2), np.eye(2), np.eye(2), 0), "one channel"),
    (control.tf([1], [1, 1], True), "period in s"),
    (3.0, "`StateSpace` or `TransferFunction`"),
]


@pytest.mark.parametrize(("system", "words"), REFUSED)
@pytest.mark.parametrize("call", [wb.step_info, wb.bandwidth])
def test_a_system_without_such_figures_is_refused_by_name(call, system, words):
    with pytest.raises(ValueError, match=words) as found:
        call(system)
    assert str(found.value).startswith(f"`{call.__name__}(")


def test_a_response_that_turns_too_often_is_refused(monkeypatch):
    # two resonances that beat for 1e6 turns, and whose largest value is somewhere among them
    beat = 1 / (s**2 + 1e-7 * s + 1) + 1 / (s**2 + 1e-7 * s + 1.0001) - 1.99 / (s + 1)
    monkeypatch.setattr("workbench.design.step_response.response_pieces.MOST_PIECES", 200)
    with pytest.raises(DesignError, match="turns more often"):
        wb.step_info(beat)
