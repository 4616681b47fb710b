"""The planned motions: two swing-ups and a motion of the arm in minimum time, with the gains along them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.laws import ARM

REST = 2.0  # s behind the end of a plan, in which the end is held
JUDGED = 1.0  # s, the last ones, over which the error is taken
FUNNEL_RUNS = 400
END = (1.2, 0.8)  # rad, of the arm


@dataclass(frozen=True)
class Motion:
    """A motion that is planned within limits and followed within wider ones."""

    key: str
    name: str
    plant: wb.Plant
    until: tuple[float, float]  # s, the least and the greatest duration
    cost: str
    end: Mapping[str, object]
    limits: Mapping[str, tuple[float, float]]
    hard: tuple[float, ...]  # of the inputs in the loop
    goal: tuple[str, tuple[float, ...]]  # an output, and its value at the end
    near: float  # of the root mean square error at the end, within which a run has arrived
    rest_inputs: tuple[float, ...]
    Q: tuple[float, ...]
    R: tuple[float, ...]
    period: float
    noise: Mapping[str, float]
    quantum: Mapping[str, float]
    process: tuple[float, ...]  # of the extended Kalman filter
    unknowns: tuple[tuple[str, str], ...]  # names and paths of what the designer does not know exactly
    starts: tuple[tuple[str, float], ...]  # states at the start, with half of their ranges
    funnel: tuple[Mapping[str, float], Mapping[str, float]] = field(default_factory=lambda: ({}, {}))

    @property
    def unit(self) -> str:
        """The unit of the error at the end."""
        return "rad"


@dataclass(frozen=True)
class PlannedMotion:
    """A plan with the gains along it, in plain numbers, and what its certificate says."""

    t: wb.Array
    x_begins: wb.Array
    x_ends: wb.Array
    rate_begins: wb.Array
    rate_ends: wb.Array
    u_begins: wb.Array
    u_ends: wb.Array
    times: wb.Array
    K: wb.Array
    objective: float
    defect: float
    run_defect: float
    is_passed: bool
    active_limits: tuple[str, ...]
    funnel_share: float
    funnel_low: float
    funnel_high: float

    def motion(self, plant: wb.Plant) -> wb.core.MotionRecord:
        """The motion as a reference takes it."""
        parts = (self.x_begins, self.x_ends, self.rate_begins, self.rate_ends, self.u_begins, self.u_ends)
        return wb.core.MotionRecord(self.t, plant.states, plant.inputs, *parts)


def plan_motion(key: str) -> PlannedMotion:
    """The plan of a motion, the gains along it and its sampled funnel."""
    one = MOTIONS[key]
    ode = wb.open_loop(one.plant)
    until = one.until[0] if one.until[0] == one.until[1] else one.until
    plan = wb.plan(ode, until, cost=one.cost, end=dict(one.end), limits=dict(one.limits))
    Q, R = np.diag(one.Q), np.diag(one.R)
    rest = wb.linearize(ode, 0.0, plan.x[-1], u=np.array(one.rest_inputs))
    near = wb.planning.trajectory_lqr(plan, Q, R, P1=wb.lqr(rest, Q=Q, R=R).X)
    spread, within = one.funnel
    funnel = wb.planning.funnel(near, dict(spread), dict(within), runs=FUNNEL_RUNS, seed=1)
    own = plan.motion
    return PlannedMotion(
        own.t,
        own.x_begins,
        own.x_ends,
        own.rate_begins,
        own.rate_ends,
        own.u_begins,
        own.u_ends,
        near.times,
        near.K,
        plan.objective,
        plan.certificate.defect,
        plan.certificate.run_defect,
        plan.certificate.is_passed,
        tuple(plan.active_limits),
        funnel.share,
        *funnel.interval,
    )


def _cart() -> Motion:
    names = (("mass of the cart", "M"), ("mass of the pole", "m"), ("length", "l"), ("friction", "b"))
    return Motion(
        "cart",
        "swing-up of the cart-pole",
        wb.CartPole(phi=np.pi),
        (2.0, 2.0),
        "energy",
        {"x": 0.0, "xd": 0.0, "phi": 0.0, "phid": 0.0},
        {"F": (-16.0, 16.0), "x": (-0.8, 0.8)},
        (20.0,),
        ("phi", (0.0,)),
        0.1,
        (0.0,),
        (10.0, 1.0, 10.0, 1.0),
        (0.1,),
        0.01,
        {"x": 5e-4, "phi": 1e-3},
        {"x": 1e-3, "phi": 2 * np.pi / 4096},
        (1e-3, 1e-1, 1e-3, 1e0),
        tuple((name, f"plant.{path}") for name, path in names),
        (("x", 0.02), ("phi", 0.05)),
        ({"phi": 0.05, "x": 0.02}, {"phi": 0.5, "x": 0.5}),
    )


def _furuta() -> Motion:
    names = (
        ("mass of the pendulum", "m_2"),
        ("inertia of the pendulum", "J_2"),
        ("inertia of the arm", "J_1"),
        ("friction of the arm", "b_1"),
    )
    return Motion(
        "furuta",
        "swing-up of the Furuta pendulum",
        wb.FurutaPendulum(),
        (2.0, 2.0),
        "energy",
        {"theta_1": 0.0, "theta_2": np.pi, "theta_1d": 0.0, "theta_2d": 0.0},
        {"tau": (-0.8, 0.8), "theta_1": (-2.0, 2.0)},
        (1.0,),
        ("theta_2", (np.pi,)),
        0.1,
        (0.0,),
        (10.0, 10.0, 1.0, 1.0),
        (20.0,),
        0.01,
        {"theta_1": 1e-3, "theta_2": 1e-3},
        {"theta_1": 2 * np.pi / 4096, "theta_2": 2 * np.pi / 4096},
        (1e-3, 1e-3, 1e-1, 1e0),
        tuple((name, f"plant.{path}") for name, path in names),
        (("theta_1", 0.05), ("theta_2", 0.05)),
        ({"theta_2": 0.05, "theta_1": 0.05}, {"theta_2": 0.5, "theta_1": 0.5}),
    )


def _arm() -> Motion:
    gravity = ca.Function("G", [q := ca.SX.sym("q", 2)], [ARM.gravity_vector(q)])
    hold = np.array(gravity(np.array(END))).ravel()
    links = "plant.arm.links"
    return Motion(
        "arm",
        "motion of the paper's arm in minimum time",
        wb.Manipulator(ARM, q=(0.0, 0.0)),
        (0.3, 3.0),
        "time",
        {"q": list(END), "qd": [0.0, 0.0]},
        {"tau[0]": (-45.0, 45.0), "tau[1]": (-18.0, 18.0)},
        (60.0, 25.0),
        ("q", END),
        0.05,
        (float(hold[0]), float(hold[1])),
        (2500.0, 2500.0, 25.0, 25.0),
        (0.04, 0.04),
        0.01,
        {"q": 5e-4},
        {"q": 1e-3},
        (1e-3, 1e-3, 1.0, 1.0),
        (
            ("first mass", f"{links}[0].mass"),
            ("second mass", f"{links}[1].mass"),
            ("first length", f"{links}[0].length"),
            ("second length", f"{links}[1].length"),
        ),
        (("q[0]", 0.03), ("q[1]", 0.03)),
        ({"q[0]": 0.03, "q[1]": 0.03}, {"q[0]": 0.2, "q[1]": 0.2}),
    )


MOTIONS = {one.key: one for one in (_cart(), _furuta(), _arm())}
