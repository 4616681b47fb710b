"""Exact limit cycles of relays against Tsypkin's series, closed forms and the engine."""

import casadi as ca
import control
import numpy as np
import pytest

from workbench.core import Entry, Layout, Ode, rk4
from workbench.design.chattering import (
    LinearPart,
    Relay,
    harmonic_balance,
    record_oscillation,
    relay_cycles,
)
from workbench.design.matrices import DesignError
from workbench.engine import simulate

K, TAU = 5.0, 0.01
s = control.tf("s")
TWO_LAGS = 1 / (s * (TAU * s + 1) ** 2)
ONE_LAG = 1 / (s * (TAU * s + 1))


def chain(lags):
    """s' = u behind so many lags of TAU, u = -K sign(s): the loop as an `Ode`."""
    states = Layout((Entry("s", np.array(0.1)), *(Entry(f"u{i}", np.array(0.0)) for i in range(lags))))
    t, x = ca.SX.sym("t"), states.symbols()
    rates = {"s": x[lags]}
    u = -K * ca.sign(x[0])
    for i in range(lags, 0, -1):
        rates[f"u{i - 1}"] = ((u if i == 1 else x[i - 1]) - x[i]) / TAU
    return Ode.of("chain", states, Layout(), (t, x, ca.SX(0, 1)), rates, {"y": x[0]})


def oscillation(step, until):
    run = simulate(step, until=until, every=step.h)
    late = run.t > until / 2
    return record_oscillation(run.t[late], run["s"][0, late])


def test_the_engine_nearly_keeps_the_balanced_oscillation():
    seen = oscillation(rk4(chain(2), 1e-5), 3.0)
    balance = harmonic_balance(TWO_LAGS, Relay(K)).oscillations[0]
    # the harmonics that the balance neglects: the third is 2.2 % of the first
    np.testing.assert_allclose([balance.amplitude, balance.frequency], [seen.amplitude, seen.frequency], rtol=0.05)


def test_an_integrator_beneath_a_computer_switches_at_every_instant_with_any_offset():
    period = 1e-3
    (cycle,) = relay_cycles(control.c2d(control.ss(1 / s), period), K)
    # s goes to and fro by K period, so its peak lies between half of that and all of it
    expected = [np.pi / period, K * period / 2, K * period]
    np.testing.assert_allclose([cycle.frequency, cycle.amplitude, cycle.highest], expected, rtol=1e-12)
    assert cycle.samples == 1


@pytest.mark.parametrize("delay", [False, True])
@pytest.mark.parametrize("start", [0.1, 0.03])
def test_a_recursion_by_hand_ends_in_one_of_the_sampled_cycles(delay, start):
    period = 2e-3
    late = control.tf([1], [1, 0], period)
    system = control.c2d(control.ss(ONE_LAG), period)
    x, waiting, record = np.linalg.pinv(system.C)[:, 0] * start, 0.0, []
    for _ in range(4000):
        y = (system.C @ x)[0]
        u = -K * np.sign(y)
        x = system.A @ x + system.B[:, 0] * (waiting if delay else u)
        waiting = u
        record.append(y)
    tail = np.array(record[2000:])
    up = np.flatnonzero((tail[:-1] <= 0) & (tail[1:] > 0))
    (length,) = set(np.diff(up))
    cycles = {2 * c.samples: c for c in relay_cycles(system * control.ss(late) if delay else system, K)}
    found = cycles[length]
    assert found.amplitude * (1 - 1e-6) <= np.abs(tail).max() <= found.highest * (1 + 1e-6)


def test_a_relay_that_is_not_sampled_or_has_no_gain_is_refused():
    with pytest.raises(ValueError, match="relay_cycles.*must be sampled"):
        relay_cycles(ONE_LAG, K)
    with pytest.raises(ValueError, match=r"relay_cycles\(K=...\)"):
        relay_cycles(ONE_LAG, -K)
    for most in (0, 2.5, True):
        with pytest.raises(ValueError, match=r"relay_cycles\(most=...\)"):
            relay_cycles(control.c2d(control.ss(ONE_LAG), 1e-3), K, most=most)


def test_a_sine_is_measured_as_it_is():
    t = np.arange(0, 3, 1e-3)
    seen = record_oscillation(t, 0.2 + 0.5 * np.sin(40 * t))
    # a passage lies between two instants, found by a straight line: (40 h)^2 / 8 of the height
    np.testing.assert_allclose([seen.amplitude, seen.offset, seen.frequency], [0.5, 0.2, 40.0], rtol=2e-4)
    assert record_oscillation(t[:200], np.sin(40 * t[:200])).frequency is None


@pytest.mark.parametrize(
    ("t", "y", "words"), [([0, 1], [0, np.nan], "finite"), ([1, 0], [0, 1], "t rising"), ([0, 1], ["a", 1], "numbers")]
)
def test_a_record_that_is_none_is_refused(t, y, words):
    with pytest.raises(ValueError, match=words):
        record_oscillation(t, y)


def test_a_linear_part_that_swings_as_the_relay_does_is_refused():
    with pytest.raises(DesignError, match="none of up to 2000"):
        relay_cycles(LinearPart([[-1.0]], [1.0], [1.0], period=0.1), 1.0)


def test_a_cycle_of_hundreds_of_instants_is_found():
    """Three lags sampled a thousand times in each of them: a recursion by hand says how long half a period is."""
    A = np.diag([-1.0, -2.0, -3.0]) + np.diag([1.0, 1.0], 1)
    lags = LinearPart.of(control.c2d(control.ss(A, [[0], [0], [1]], [[1, 0, 0]], 0), 2e-3))
    x, s = np.array([0.1, 0.0, 0.0]), np.empty(30_000)
    for i in range(len(s)):
        s[i] = lags.c @ x
        x = lags.A @ x - lags.b * (1 if s[i] >= 0 else -1)
    halves = set(np.diff(np.flatnonzero(np.diff(np.sign(s[15_000:])))).tolist())
    assert len(halves) == 1
    (cycle,) = (c for c in relay_cycles(lags, 1.0) if {c.samples} == halves)
    assert cycle.samples > 200
    assert cycle.amplitude == pytest.approx(np.abs(s[15_000:]).max(), rel=1e-9)
