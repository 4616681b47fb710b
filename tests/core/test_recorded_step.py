"""A step along a record: the motion between its instants, its derivatives, and one motion on every engine."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import workbench as wb
from workbench.core.recorded_step import SignalRecord, record_rows, recorded_step, with_directions
from workbench.engine.arithmetic import march_of
from workbench.engine.job import Job
from workbench.engine.kernel import casadi_machine, numpy_kernel
from workbench.engine.record_runs import run_along

MOTOR = wb.open_loop(wb.DCMotor())
T = np.cumsum(np.random.default_rng(0).uniform(0.005, 0.02, 60)) - 0.005
V = 12 * np.sin(7 * T)
HELD = SignalRecord(T, ("v",), V[:-1, None], V[:-1, None])
LINES = SignalRecord(T, ("v",), V[:-1, None], V[1:, None])


def voltage(record, t):
    return np.interp(t, T, V) if record is LINES else V[max(int(np.searchsorted(T, t, side="right")) - 1, 0)]


def by_scipy(record, p):
    x, rows = MOTOR.states.default, [MOTOR.states.default]
    for a, b in pairwise(T):

        def rate(t, x, middle=(a + b) / 2):
            q = p.copy()
            q[-1] = voltage(record, t if record is LINES else middle)
            return MOTOR.rate_at(t, x, q)

        x = solve_ivp(rate, (a, b), x, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
        rows.append(x)
    return np.array(rows)


@pytest.mark.parametrize("record", [HELD, LINES], ids=["held", "lines"])
def test_the_states_at_the_instants_are_those_of_an_independent_solver_restarted_there(record):
    p = MOTOR.parameters.default
    x = run_along(recorded_step(MOTOR, record), p[None], MOTOR.states.default[None])[0]
    expected = by_scipy(record, p)
    # Runge-Kutta steps of 20 ms at most, of a motor whose fastest mode decays at 10/s: 0.2^5/120 of a state a step
    assert np.abs(x - expected).max() < 3e-6 * np.abs(expected).max()


def test_every_engine_marches_along_a_record_and_portable_arithmetic_has_the_same_bits():
    step, p = recorded_step(MOTOR, LINES), np.tile(MOTOR.parameters.default, (3, 1))
    p[:, 0] *= [0.5, 1.0, 2.0]
    compiled = np.zeros((3, len(T), 2))
    casadi, numpy = compiled.copy(), compiled.copy()
    job = Job(step, p, 1, 0, np.arange(3), arithmetic="portable")
    march_of(job)(job, compiled, lambda share: None)
    numpy_kernel.march(job, numpy, lambda share: None)
    np.testing.assert_array_equal(compiled, numpy)
    casadi_machine.march(Job(step, p, 1, 0, np.arange(3), arithmetic="casadi"), casadi, lambda share: None)
    np.testing.assert_allclose(casadi, compiled, rtol=1e-12, atol=1e-14)  # another order of the same operations


def test_directions_are_the_derivatives_by_parameters_initial_states_and_a_shift_of_the_instants():
    base, n = recorded_step(MOTOR, LINES), 2
    move = np.zeros(len(T))
    move[10:20] = 1.0  # some instants move, and the line between them with their own values
    slopes = record_rows(move, np.zeros((len(T) - 1, 1)), np.zeros((len(T) - 1, 1)))
    step = with_directions(base, (0, 3), {"shift": slopes})
    start = np.zeros((4, step.states.size))
    start[:3, 2 * n :] = np.eye(3)
    start[3, n] = 1.0  # of the initial speed
    x = run_along(step, np.tile(MOTOR.parameters.default, (4, 1)), start)
    small = 1e-6

    def ends(p=MOTOR.parameters.default, x0=(0.0, 0.0), t=T):
        record = SignalRecord(t, ("v",), V[:-1, None], V[1:, None])
        return run_along(recorded_step(MOTOR, record), p[None], np.array([x0]))[0, -1]

    for row, place in enumerate((0, 3)):
        d = small * MOTOR.parameters.default[place] * np.eye(MOTOR.parameters.size)[place]
        slope = (ends(MOTOR.parameters.default + d) - ends(MOTOR.parameters.default - d)) / (2 * d[place])
        agree(x[row, -1, n : 2 * n], slope)
    slope = (ends(t=T + small * move) - ends(t=T - small * move)) / (2 * small)
    agree(x[2, -1, n : 2 * n], slope)
    slope = (ends(x0=(small, 0.0)) - ends(x0=(-small, 0.0))) / (2 * small)
    agree(x[3, -1, n : 2 * n], slope)


def agree(derivative, difference):
    """Up to the rounding of a difference over 2e-6 of a number."""
    assert np.abs(derivative - difference).max() < 1e-6 * np.abs(difference).max()


def test_no_step_reads_beyond_its_record():
    step = recorded_step(MOTOR, LINES)
    with pytest.raises(ValueError, match="59 steps that are recorded"):
        wb.simulate(step, until=60.0)


def test_a_record_whose_instants_decrease_is_refused():
    with pytest.raises(ValueError, match="do not decrease"):
        SignalRecord(T[::-1], ("v",), V[:-1, None], V[1:, None])
