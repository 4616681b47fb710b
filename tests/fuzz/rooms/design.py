from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import casadi as ca
import control
import numpy as np

from workbench import design
from workbench.arms import observer_gains
from workbench.arms.dynamics import Dynamics
from workbench.arms.laws import SlidingMode
from workbench.arms.manipulator import FirstOrderLag, Manipulator
from workbench.arms.mechanics.planar_arm import PlanarArm, PointMass
from workbench.arms.observers import FullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Hold
from workbench.core import Entry, Layout, Ode
from workbench.design import chattering, frequency, linear, riccati, riccati_flow, step_response

from ..parts import LOOP, signals

ROOMS = (design, linear, frequency, riccati, riccati_flow, chattering, observer_gains, step_response)
MODULES = tuple(room.__name__ for room in ROOMS)

A, B, C, Q, R = np.array([[0.0, 1.0], [-2.0, -0.3]]), np.array([[0.0], [1.0]]), np.eye(1, 2), np.eye(2), np.eye(1)
SYSTEM = control.ss(A, B, C, np.zeros((1, 1)))
LAG = control.ss([[0.0, 1.0, 0.0], [0.0, -9.0, 1.0], [0.0, 0.0, -9.0]], [[0.0], [0.0], [1.0]], [[81.0, 0.0, 0.0]], 0)
SAMPLED = chattering.LinearPart([[1.0]], [0.01], [1.0], 0.01)
TIMES = np.linspace(0.0, 1.0, 5)
SPAN = np.linspace(0, 9, 400)
SWING = Dynamics.of(PlanarArm((PointMass(2.0, 0.5),), 9.81))
MISMATCH = observer_gains.Mismatch.of(SWING)
GAINS = observer_gains.Gains(np.array([[80.0]]), np.array([[1600.0]]))
REGION = observer_gains.Region(np.array([3.0]), np.array([7.0]))


def layer() -> tuple[Ode, np.ndarray]:
    """A loop with a boundary layer on its first joint alone, and its parameters."""
    arm, folded = PlanarArm((PointMass(1.0, 1.0), PointMass(1.0, 1.0)), 0.0), [0.0, np.pi]
    law = SlidingMode(arm, Lambda=[6.0] * 2, K=[5.0] * 2, phi=0.01, saturation="clip")
    plant = Manipulator(arm, q=folded, actuator=FirstOrderLag(0.01))
    loop = ClosedLoop(plant, FullState(2), law, Hold(folded)).ode()
    p = loop.parameters.default.copy()
    p[loop.parameters.labels.index("controller.K[1]")] = 0.0
    return loop, p


def swing() -> Ode:
    """x1' = x2, x2' = -k sin x1 - x2 + u, y = x1."""
    states = Layout((Entry("x", [0.1, 0.0]),))
    parameters = Layout((Entry("k", 2.0), Entry("u", 0.0)))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    rate = ca.vertcat(x[1], -p[0] * ca.sin(x[0]) - x[1] + p[1])
    return replace(Ode.of("swing", states, parameters, (t, x, p), {"x": rate}, {"y": x[0]}), inputs=("u",))


ODE = swing()
REST = np.zeros(2)


def calls() -> dict[str, Any]:
    solved = riccati.care(A, B, Q, R)
    switch, (loop, p) = chattering.BoundaryLayer(5.0, 0.3), layer()
    return {
        **{name: getattr(room, name) for room in ROOMS for name in room.__all__},  # what a call makes, and no call
        **_linear(),
        **_frequency(),
        "care": partial(riccati.care, A, B, Q, R, np.zeros((2, 1)), np.eye(2)),
        "dare": partial(riccati.dare, A, B, Q, R, np.zeros((2, 1)), np.eye(2)),
        "discrete_lyapunov": partial(riccati.discrete_lyapunov, A / 4, Q, np.eye(2)),
        "lyapunov": partial(riccati.lyapunov, A, Q, np.eye(2)),
        "lqr": partial(riccati.lqr, A, B, Q, R, np.zeros((2, 1)), False),
        "lqe": partial(riccati.lqe, A, B, C, R, R, False),
        "steady_kalman": partial(riccati.steady_kalman, ODE, Q, R, ("y",), period=0.1, x=REST, u=[0.0], p=None),
        "lqg": partial(riccati.lqg, SYSTEM, Q, R, Q, R, np.zeros((2, 1)), Q),
        "rde": partial(riccati_flow.rde, A, B, Q, R, Q, TIMES, rtol=1e-8),
        "fpre": partial(riccati_flow.fpre, A, B, Q, R, Q, TIMES, rtol=1e-8),
        "sdre": partial(riccati_flow.sdre, lambda x: (A + np.diag(x), B), np.zeros((2, 2)), Q, R),
        "Relay": partial(chattering.Relay, 5.0),
        "BoundaryLayer": partial(chattering.BoundaryLayer, 5.0, 0.3),
        "LinearPart": partial(chattering.LinearPart, A, B[:, 0], C[0], 0.0),
        "cut": partial(chattering.cut, loop, loop.states.default, p),
        "harmonic_balance": partial(chattering.harmonic_balance, LAG, switch),
        "record_oscillation": partial(
            chattering.record_oscillation, np.linspace(0, 9, 400), np.sin(7 * np.linspace(0, 9, 400))
        ),
        "relay_cycles": partial(chattering.relay_cycles, SAMPLED, 5.0, 40),
        **_gains(),
        "Riccati": partial(riccati.Riccati, solved.X, solved.K, solved.poles, solved.certificate),
    }


def _linear() -> dict[str, Any]:
    cut, loop = LOOP.broken(), control.ss([[-1.0]], [[1.0]], [[2.0]], 0)
    (arriving,) = cut.outputs_at(0.0, cut.states.default).values()
    acting = cut.parameters.pack({"drive": arriving})[0]
    return {
        "along": partial(linear.along, ODE, TIMES, np.zeros((5, 2)), None),
        "broken_loop": partial(linear.broken_loop, cut, 0.0, cut.states.default, frozen=True, side=None),
        "broken_loops": partial(linear.broken_loops, linear.along(cut, [0.0], [cut.states.default], acting)),
        "controllability": partial(linear.controllability, SYSTEM, 1e-9),
        "observability": partial(linear.observability, SYSTEM, 1e-9),
        "disk_margin": partial(linear.disk_margin, loop),
        "equilibria": partial(linear.equilibria, ODE, {"x[0]": (-1.0, 4.0), "x[1]": (-1.0, 1.0)}, None, None, starts=4),
        "frequency_response": partial(linear.frequency_response, SYSTEM, np.array([1.0, 2.0])),
        "freeze": partial(linear.freeze, cut, ("plant.q",)),
        "lead_lag": partial(linear.lead_lag, control.tf([10.0], [1.0, 1.0, 0.0]), 5.0, 50.0, 2.0),
        "place": partial(linear.place, SYSTEM, [-1.0, -2.0]),
        "Placement": partial(linear.Placement, np.ones((1, 2)), np.array([-1.0, -2.0]), 0.0),
        "linearize": partial(linear.linearize, ODE, 0.0, REST, None, [0.0], at_rest=True),
        "loop_margins": partial(linear.loop_margins, loop),
        "lyapunov_exponents": partial(linear.lyapunov_exponents, ODE, 2.0, 0.01, None, [0.1, 0.0], skip=0.0),
        "one_loop": partial(linear.one_loop, loop, 0),
        "operating_point": partial(linear.operating_point, ODE, {"x[0]": 0.5, "x[1]": 0.0}, None, 0.0, None),
        "poles": partial(linear.poles, SYSTEM),
        "sensitivity": partial(linear.sensitivity, SYSTEM),
        "to_control": partial(linear.to_control, ODE, None, "swing"),
    }


def _frequency() -> dict[str, Any]:
    law = control.ss([[0.5]], [[1.0]], [[0.2]], [[0.1]], 0.1)
    rows = (np.stack([M] * 2) for M in (A, B, C, np.zeros((1, 1))))
    return {
        "bandwidth": partial(frequency.bandwidth, SYSTEM, 3.0),
        "exact_figures": partial(step_response.exact_figures, SYSTEM),
        "sensitivity_bandwidth": partial(frequency.sensitivity_bandwidth, SYSTEM, 3.0),
        "step_info": partial(step_response.step_info, SYSTEM),
        "c2d": partial(frequency.c2d, SYSTEM, 0.1, "zoh", None),
        "common_period": partial(frequency.common_period, [0.1, 0.25]),
        "condition_number": partial(frequency.condition_number, np.eye(2)),
        "h2_norm": partial(frequency.h2_norm, SYSTEM),
        "hinf_norm": partial(frequency.hinf_norm, SYSTEM),
        "hold_loop": partial(frequency.hold_loop, SYSTEM, law, 0.03),
        "lift_rates": partial(frequency.lift_rates, SYSTEM, [law], None),
        "pole_zero_structure": partial(frequency.pole_zero_structure, SYSTEM),
        "relative_gains": partial(frequency.relative_gains, np.eye(2)),
        "row_responses": partial(frequency.row_responses, *rows, np.array([1.0, 2.0]), None),
        "stability_margins": partial(frequency.stability_margins, SYSTEM, 0.0, None),
    }


def _gains() -> dict[str, Any]:
    q, eye = np.zeros((3, 1)), np.eye(1)
    known = observer_gains.certify(SWING, GAINS, REGION, 1.0)
    return {
        "Gains": partial(observer_gains.Gains, 80 * eye, 1600 * eye),
        "Mismatch": partial(observer_gains.Mismatch.of, SWING),
        "Region": partial(observer_gains.Region, [3.0], [7.0], [-1.0], [1.0]),
        "audit": partial(observer_gains.audit, SWING, GAINS, REGION, 0.5, 1.0, known),
        "by_lmi": partial(observer_gains.by_lmi, SWING, REGION, 1.0),
        "by_poles": partial(observer_gains.by_poles, 2, -40.0, -40.0),
        "certify": partial(observer_gains.certify, SWING, GAINS, REGION, 1.0),
        "check": partial(observer_gains.check, MISMATCH, GAINS, REGION, known.P, 1.0),
        "frozen_poles": partial(observer_gains.frozen_poles, MISMATCH, GAINS, q, q, q),
        "over": partial(observer_gains.over, MISMATCH, GAINS, REGION, 20),
        "high_gain": partial(observer_gains.high_gain, 2, 2.0, 1.0, 0.1),
        "kalman": partial(observer_gains.kalman, SWING, [0.1], [0.0], [0.0], np.eye(1), np.eye(1)),
        "least_double_pole": partial(observer_gains.least_double_pole, SWING, REGION, 1.0),
        "lipschitz": partial(observer_gains.lipschitz, MISMATCH, REGION),
        "noise": partial(observer_gains.noise, GAINS),
        "peaking": partial(observer_gains.peaking, GAINS),
        "tolerated": partial(observer_gains.tolerated, GAINS),
        "Frozen": partial(observer_gains.along, MISMATCH, GAINS, REGION, q, q, q),
    }


def arguments() -> dict[str, Any]:
    column = [[0.1]]
    return {
        **signals(),
        **dict.fromkeys(("q", "qd", "tau", "squares"), lambda thing: np.array(column)),
        "a": lambda thing: 0.5,
        "g": lambda thing: 0.1,
        "w": lambda thing: 3.0,
        "share": lambda thing: 0.5,
        "gain": lambda thing: 1.0,
        "period": lambda thing: 0.01,
        "region": lambda thing: REGION,
        "arm": lambda thing: REGION,
        "dynamics": lambda thing: SWING,
        "system": lambda thing: LAG,
        "times": lambda thing: [0.1, 0.2],
        "frequencies": lambda thing: np.array([1.0, 2.0]),
        "c": lambda thing: np.array(column),
        "r": lambda thing: np.array(column),
    }
