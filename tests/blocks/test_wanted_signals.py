"""References of any signal: closed forms, exact derivatives, units, and jumps that are located."""

import re

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import chirp

from tests.support.compilers import WITHOUT
from tests.support.plain_plants import SPEED, VOLTAGE, Motor
from workbench.blocks.laws import PID
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import (
    Chirp,
    CombinedReference,
    Constant,
    PulseTrain,
    Ramp,
    Sines,
    SquareWave,
    Step,
    Table,
    Trapezoid,
    WayPoints,
)
from workbench.core import lift, rk4
from workbench.engine import simulate
from workbench.engine.metrics import measure, rmse
from workbench.engine.reference import reference_run

OMEGA = ("omega", "rad/s")
PAIR = ("x", "m, rad")
TIMES, VALUES = [0.0, 1.0, 2.0, 4.0], np.array([[0.0, 1.0, 0.0, 3.0], [1.0, 2.0, 3.0, 4.0]]).T
SMOOTH = {
    "sines": Sines("x", "m, rad", [1.0, 2.0], 3.0),
    "hold": Constant(*PAIR, [1.0, 2.0]),
    "linear chirp": Chirp(*PAIR, [2.0, 1.0], 0.1, 1.0, 4.0, 0.3),
    "logarithmic chirp": Chirp(*PAIR, [2.0, 1.0], 0.1, 1.0, 4.0, [0.3, 1.0], "logarithmic"),
    "trapezoid": Trapezoid(*PAIR, [3.0, -0.2], [1.0, 1.0], [2.0, 2.0], 0.5, [0.0, 0.5]),
    "way-points": WayPoints(*PAIR, [0.0, 1.0, 3.0], [[0.0, 1.0], [1.0, -2.0], [4.0, 4.0]]),
    "line": Table(*PAIR, TIMES, VALUES),
    "spline": Table(*PAIR, TIMES, VALUES, "cubic"),
    "ramp": Ramp(*PAIR, [1.0, -2.0], [0.5, 1.0], 3.0),
}
JUMPS = {
    "step": Step(*PAIR, [1.0, 2.0], [0.5, 1.0], -1.0),
    "pulses": PulseTrain(*PAIR, [1.0, 2.0], 1.0, 0.25, 0.5, -1.0),
    "wave": SquareWave(*PAIR, [1.0, 2.0], 0.5),
    "rows": Table(*PAIR, TIMES, VALUES, "hold"),
}


def motion(signal, times):
    """x, xd and xdd, each (N, n)."""
    t = ca.SX.sym("t")
    function = ca.Function("motion", [t], [ca.densify(part) for part in signal.at(t).values()])
    return [np.array(part).T for part in function(np.asarray(times, dtype=float)[None])]


@pytest.mark.parametrize("name", SMOOTH)
def test_the_derivatives_of_a_signal_are_those_of_its_value(name):
    # off the corners, which lie at tenths
    t, h = np.linspace(0.0, 3.9, 391) + 0.0037, 1e-5
    before, now, after = (motion(SMOOTH[name], t + shift) for shift in (-h, 0.0, h))
    # h^2 / 6 times a third derivative, of at most 2 / rise^3 rad or (2 pi)^3, and eps / h
    np.testing.assert_allclose(now[1], (after[0] - before[0]) / (2 * h), rtol=0, atol=3e-7)
    np.testing.assert_allclose(now[2], (after[1] - before[1]) / (2 * h), rtol=0, atol=3e-6)


@pytest.mark.parametrize("name", JUMPS)
def test_a_signal_that_jumps_has_no_slope(name):
    assert not np.any(motion(JUMPS[name], np.linspace(0, 3, 31))[1:])


@pytest.mark.parametrize("signal", (SMOOTH | JUMPS).values(), ids=SMOOTH | JUMPS)
def test_a_signal_says_its_name_with_the_unit_of_each_number(signal):
    assert signal.gives.names == ("x", "xd", "xdd")
    assert signal.primary == ("x",)
    units = [entry.units for entry in signal.gives.entries]
    assert units == [("m", "rad"), ("m/s", "rad/s"), ("m/s^2", "rad/s^2")]


@pytest.mark.parametrize("signal", (SMOOTH | JUMPS).values(), ids=SMOOTH | JUMPS)
def test_a_lifted_signal_says_the_same(signal):
    t, lifted = ca.SX.sym("t"), lift(signal)
    gap = ca.vertcat(*lifted.block.at(t).values()) - ca.vertcat(*signal.at(t).values())
    gap = ca.Function("gap", [t, lifted.symbols], [gap])
    for time in (0.0, 0.3, 2.1):
        # what is folded before may be rounded otherwise, of accelerations up to 100
        np.testing.assert_allclose(np.array(gap(time, lifted.layout.default)), 0, atol=1e-12)


def test_the_parameters_of_a_signal_have_its_units():
    units = {entry.name: entry.unit for entry in lift(SMOOTH["trapezoid"], "reference.").layout.entries}
    assert units["reference.goal"] == "m, rad"
    assert units["reference.speed"] == "m/s, rad/s"
    assert units["reference.acceleration"] == "m/s^2, rad/s^2"
    assert {e.name: e.unit for e in lift(Ramp(*OMEGA, 1.0)).layout.entries}["slope"] == "rad/s^2"


def test_one_number_makes_a_signal_of_one_number():
    assert Step(*OMEGA, 1.0).gives["omega"].size == 1
    assert WayPoints(*OMEGA, [0, 1], [0, 1]).gives["omega"].size == 1
    assert Table(*OMEGA, [0, 1], [0, 1]).gives["omega"].size == 1


def test_a_step_is_up_from_its_time_on():
    x = motion(Step(*OMEGA, 5.0, time=1.0, start=-1.0), [0.0, 1.0 - 1e-12, 1.0, 2.0])[0]
    np.testing.assert_array_equal(x.ravel(), [-1, -1, 5, 5])


@pytest.mark.parametrize("ticks", [1, 3, 7, 15, 30, 70])
def test_a_jump_at_an_instant_is_met_there_however_k_h_is_rounded(ticks):
    """Instants are those of a step h of `ticks` milliseconds: 30 times 0.03 is less than 0.9."""
    h = ticks / 1000
    for k in range(3, 100, 9):
        due, times = k * ticks / 1000, np.array([(k - 1) * h, k * h])
        rows = Table("x", "m", [0.0, due, due + 1], [0.0, 1.0, 1.0], "hold")
        for signal in (Step("x", "m", 1.0, due), PulseTrain("x", "m", 1.0, 2 * due, due, due), rows):
            np.testing.assert_array_equal(motion(signal, times)[0].ravel(), [0.0, 1.0])
        up = PulseTrain("x", "m", 1.0, 2 * due, due)
        np.testing.assert_array_equal(motion(up, times)[0].ravel(), [1.0, 0.0])


@pytest.mark.parametrize("sweep", ["linear", "logarithmic"])
def test_a_chirp_is_that_of_scipy_and_stays_at_its_last_frequency(sweep):
    T, signal = 4.0, Chirp(*OMEGA, 2.0, 0.1, 3.0, 4.0, np.pi / 2, sweep)
    t = np.linspace(0, T, 401)
    x = motion(signal, t)[0].ravel()
    # a phase of 2 pi 6 turns is rounded at 1e-14
    np.testing.assert_allclose(x, 2 * chirp(t, 0.1, T, 3.0, sweep), rtol=0, atol=1e-13)
    x, xd, xdd = (part.ravel() for part in motion(signal, T + np.linspace(0, 3, 31)))
    np.testing.assert_allclose(xdd, -((6 * np.pi) ** 2) * x, rtol=0, atol=1e-10)  # w^2 = 355 times rounding
    np.testing.assert_allclose(x**2 + (xd / (6 * np.pi)) ** 2, 4.0, rtol=1e-12)


def test_pulses_come_once_a_period_from_their_time_on():
    t = np.arange(0, 32) / 16  # sixteenths have no rounding
    x = motion(PulseTrain(*OMEGA, 3.0, 0.5, 0.125, 0.75, -1.0), t)[0].ravel()
    expected = np.where((t >= 0.75) & ((t - 0.75) % 0.5 < 0.125), 3.0, -1.0)
    np.testing.assert_array_equal(x, expected)


@pytest.mark.parametrize(("way", "lasts"), [(3.0, 3.5), (-3.0, 3.5), (0.5, 1.0), (0.32, 0.8), (0.0, 0.0)])
def test_a_trapezoid_keeps_its_limits_and_takes_the_shortest_time(way, lasts):
    signal = Trapezoid(*OMEGA, 1.0 + way, 1.0, 2.0, time=0.25, start=1.0)
    t = 0.25 + np.linspace(-0.25, 5, 2101)
    x, xd, xdd = (part.ravel() for part in motion(signal, t))
    assert abs(xd).max() <= 1.0
    assert set(np.unique(abs(xdd))) <= {0.0, 2.0}
    np.testing.assert_allclose(x[t >= 0.25 + lasts], 1.0 + way, rtol=1e-15)
    np.testing.assert_array_equal(x[t <= 0.25], 1.0)
    if way:  # a moment before the shortest time, D / v + v / a or 2 sqrt(D / a), it is not there
        assert abs(motion(signal, [0.25 + lasts - 1e-3])[0].item() - 1.0 - way) > 0.5e-6


def test_way_points_are_met_at_rest_and_no_other_way_has_less_jerk():
    signal = SMOOTH["way-points"]
    x, xd, xdd = motion(signal, [-0.0, 1.0, 3.0, 9.0])
    np.testing.assert_array_equal(x, [[0, 1], [1, -2], [4, 4], [4, 4]])
    assert not np.any(xd)
    assert not np.any(xdd)
    # Euler-Lagrange: the sixth derivative is zero, so a polynomial of order 5 goes through each way exactly
    t = np.linspace(1.0, 3.0, 41)
    for number in motion(signal, t)[0].T:
        fit = np.polynomial.Polynomial.fit(t, number, 5)
        np.testing.assert_allclose(fit(t), number, rtol=0, atol=1e-13)


def test_a_table_goes_through_its_rows():
    t = np.linspace(0, 4, 81)
    line, spline, rows = (motion(Table(*PAIR, TIMES, VALUES, how), t)[0] for how in ("linear", "cubic", "hold"))
    np.testing.assert_allclose(line, np.stack([np.interp(t, TIMES, v) for v in VALUES.T], axis=1), atol=1e-15)
    np.testing.assert_allclose(spline, CubicSpline(TIMES, VALUES)(t), atol=1e-14)
    last = np.searchsorted(TIMES[:-1], t, side="right") - 1
    np.testing.assert_array_equal(rows, VALUES[last])


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Table(*OMEGA, [0, 1], [0, np.nan]), "a matrix of finite numbers; got nan"),
        (lambda: Table(*OMEGA, [0, 1, 1], [0, 1, 2]), r"must increase.*got 1 s and then 1 s at \[2\]"),
        (lambda: Table(*OMEGA, [0.5, 1], [0, 1]), "must begin at 0 s or before.* got 2 from 0.5 s on"),
        (lambda: Table(*OMEGA, [0.0, 1], [0, 1, 2]), r"got shapes \(2,\) and \(3,\)"),
        (lambda: Table(*OMEGA, [0.0], [0]), "at least two times"),
        (lambda: Table(*OMEGA, np.arange(3000.0), np.arange(3000.0)), "at most 2000 rows"),
        (lambda: WayPoints(*OMEGA, [0, 2, 1], [0, 1, 2]), r"`WayPoints\(times=...\)` must increase"),
        (lambda: PulseTrain(*OMEGA, 1.0, 1.0, 1.0), "must be less than the period of 1 s"),
        (lambda: Chirp(*OMEGA, 1.0, 0.0, 2.0, 1.0, sweep="logarithmic"), "two positive frequencies that differ"),
        (lambda: Trapezoid(*OMEGA, 1.0, 0.0, 1.0), r"`Trapezoid\(speed=...\)`"),
        (lambda: CombinedReference((Step(*OMEGA, 1.0), Ramp(*OMEGA, 1.0))), "'omega' comes 2 times"),
    ],
)
def test_a_signal_that_cannot_be_is_refused_in_one_sentence(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def loop(signal):
    return ClosedLoop(Motor(), controller=PID(SPEED, VOLTAGE, 50.0, 100.0), reference=signal)


ONE = {
    "step": Step(*OMEGA, 1.0, 0.5),
    "ramp": Ramp(*OMEGA, 2.0, 0.5),
    "chirp": Chirp(*OMEGA, 2.0, 0.1, 3.0, 2.0, sweep="logarithmic"),
    "pulses": PulseTrain(*OMEGA, 1.0, 1.0, 0.25, 0.5),
    "trapezoid": Trapezoid(*OMEGA, 3.0, 2.0, 4.0, 0.5),
    "way-points": WayPoints(*OMEGA, [0.0, 1.0, 3.0], [0.0, 1.0, -2.0]),
    "line": Table(*OMEGA, TIMES, VALUES[:, 0]),
    "spline": Table(*OMEGA, TIMES, VALUES[:, 0], "cubic"),
    "rows": Table(*OMEGA, TIMES, VALUES[:, 0], "hold"),
}


FEW = ("step", "ramp")  # one with a jump, and one without


@pytest.mark.parametrize("name", [name if name in FEW else pytest.param(name, marks=pytest.mark.heavy) for name in ONE])
def test_both_engines_and_the_reference_integrator_run_each_signal(name):
    ode, h = loop(ONE[name]).ode(), 2e-3
    run = simulate(rk4(ode, h), until=2.5, arithmetic="portable")
    exact = reference_run(ode, times=np.linspace(0, 2.5, 6))
    omega = exact.x[:, ode.states.names.index("plant.omega")]
    # behind a jump a step of h moves it by a part of h: h times a slope of at most 2; elsewhere the order is 4
    jumps = name in ("step", "pulses", "rows")
    np.testing.assert_allclose(run["omega"].ravel()[::250], omega, rtol=0, atol=2 * h if jumps else 1e-8)
    if name == "pulses":
        assert [e.t for e in exact.events][:3] == pytest.approx([0.125, 0.5, 0.75], abs=1e-12)
    pytest.importorskip("llvmlite", reason=WITHOUT)
    by_numpy = simulate(rk4(ode, h), until=1.2, engine="numpy", arithmetic="portable")  # behind each first row and jump
    np.testing.assert_array_equal(by_numpy.x, run.x[:, :601])


def test_a_run_behind_the_end_of_a_table_is_refused_at_every_door():
    signal = CombinedReference((Table(*OMEGA, [0, 1], [0, 1]), Step("theta", "rad", 1.0)))
    ode, sampled = loop(signal).ode(), loop(signal).digital(0.1)
    says = "at most 1 s, the time at which a table of 'loop' ends; got 2 s"
    for door, run in (
        ("simulate(until", lambda: simulate(rk4(ode, 0.1), until=2.0)),
        ("simulate(until", lambda: simulate(sampled.step(), until=2.0)),
        ("reference(times", lambda: reference_run(ode, times=[0.5, 2.0])),
        ("measure(until", lambda: measure(ode, [rmse("e_omega")], until=2.0, h=0.1)),
        ("measure(until", lambda: measure(sampled, [rmse("e_omega")], until=2.0, h=0.05)),
        ("measure(until", lambda: measure(ode, [rmse("e_omega")], until=2.0, tolerance=1e-3)),
    ):
        with pytest.raises(ValueError, match=rf"^`{re.escape(door)}=...\)` must be {says}"):
            run()
    assert simulate(rk4(ode, 0.1), until=1.0)["omega_ref"].ravel()[-1] == pytest.approx(1.0, abs=1e-15)


def test_several_references_are_followed_together():
    signal = CombinedReference((Step(*OMEGA, 1.0), Sines("theta", "rad", [1.0], [2.0])))
    assert signal.gives.names == ("omega", "omegad", "omegadd", "theta", "thetad", "thetadd")
    assert signal.primary == ("omega", "theta")
    assert loop(signal).follows == ("omega",)
    assert "reference.parts[1].amplitude" in loop(signal).ode().parameters
