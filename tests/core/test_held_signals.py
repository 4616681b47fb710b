"""Signals that change by jumps alone are known from the equations, and drawn as what they are."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from workbench.core.piecewise_constant import is_piecewise_constant
from workbench.report.pictures.traces import curve
from workbench.study import case_runs
from workbench.study.study import Case, Study

MOTOR = wb.DCMotor()


def loop():
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0, low=-24.0, high=24.0)
    return wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))


CONTINUOUS, DIGITAL = loop().ode(), loop().digital(0.02).flow


@pytest.mark.parametrize(
    ("flow", "signal", "held"),
    [
        (CONTINUOUS, "omega", False),
        (CONTINUOUS, "omega_ref", True),
        (CONTINUOUS, "e_omega", False),
        (CONTINUOUS, "v_applied", False),
        (CONTINUOUS, "plant.i", False),
        (DIGITAL, "omega", False),
        (DIGITAL, "omega_ref", True),
        (DIGITAL, "v", True),
        (DIGITAL, "v_applied", True),
        (DIGITAL, "hold.v", True),
        (DIGITAL, "nothing of it", False),
    ],
)
def test_a_signal_is_held_if_its_derivative_is_zero_between_jumps(flow, signal, held):
    assert is_piecewise_constant(flow, signal, 0) is held


@pytest.mark.parametrize("flow", [CONTINUOUS, DIGITAL], ids=["continuous", "digital"])
def test_a_held_signal_keeps_its_bits_along_the_flow_and_others_do_not(flow):
    made = ca.Function("made", [flow.t, flow.x, flow.p], [ca.densify(flow.rate), ca.densify(flow.output)])
    p, random, still = flow.parameters.default, np.random.default_rng(4), np.ones(flow.outputs.size, dtype=bool)
    for _ in range(20):
        t, x = random.uniform(0.2, 1.0), random.normal(size=flow.states.size)  # behind the step at 0.1 s
        rate, y = made(t, x, p)
        still &= np.array(made(t + 1e-3, x + 1e-3 * np.array(rate).ravel(), p)[1] == y, dtype=bool).ravel()
    places = [(name, place) for name in flow.outputs.names for place in range(flow.outputs[name].size)]
    assert [is_piecewise_constant(flow, name, place) for name, place in places] == still.tolist()
    assert 0 < still.sum() < len(still)


def looks(equation):
    case = Case("speed", "PI", wb.Run(equation, (), until=0.4, every=0.02, h=2e-3))
    (outcome,) = case_runs.run(Study("s", "T", "Q?", "M.", lambda _: [], cases=(case,), live=None)).outcomes
    over = curve(outcome, "v_applied", over=("omega", 0))
    return [curve(outcome, name).look for name in ("omega", "omega_ref", "v_applied")] + [over.look]


def test_a_curve_of_a_held_signal_is_drawn_as_steps_over_the_time_alone():
    assert looks(loop()) == ["line", "steps", "line", "line"]
    assert looks(loop().digital(0.02)) == ["line", "steps", "steps", "line"]


def test_a_notebook_draws_held_signals_as_steps_too():
    runs = wb.simulate(loop().digital(0.02), until=0.4)
    omega, volts = runs.plot("omega", "v_applied").axes
    assert [line.get_drawstyle() for line in omega.lines] == ["default", "steps-post"]
    assert [line.get_drawstyle() for line in volts.lines] == ["steps-post"]
