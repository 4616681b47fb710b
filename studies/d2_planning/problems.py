"""The three plants of the comparison: the paper's arm, the quadruple tank and a quadrotor in a plane."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import casadi as ca
import numpy as np

import workbench as wb
from studies.d2_planning.target import LoadedPlant, Target
from studies.paper.laws import ARM

Pair = tuple[float, float]
Knobs = dict[str, float]


@dataclass(frozen=True)
class VariedNumber:
    """A number of the plant that is drawn for each run, as a share of the model's number."""

    name: str
    paths: tuple[str, ...]
    low: float
    high: float


@dataclass(frozen=True)
class Problem:
    """A plant that is brought to a target by two inputs: its computer, its limits, and what is drawn."""

    key: str
    name: str
    plant: wb.Plant
    unit: str  # of the inputs
    output_unit: str
    tracks: tuple[str, ...]  # outputs that follow a reference
    x0: tuple[float, ...]  # the rest about which all is linearised
    u0: Pair
    r0: Pair
    period: float  # s
    horizon: float  # s, of a run
    substeps: int
    stages: int
    low: Pair
    high: Pair
    levels: tuple[float, ...]  # of the limits, as shares of `high` (and of `low`)
    noise: tuple[tuple[str, float], ...]
    quantum: tuple[tuple[str, float], ...]
    unknowns: tuple[VariedNumber, ...]
    starts: tuple[tuple[str, float, float], ...]  # states that are drawn, with their ranges
    targets: tuple[Pair, Pair]
    drift: Pair  # standard deviation of a period's change of the states and of d, for the observer
    sizes: tuple[float, ...]  # of states that count alike in the quadratic cost; rates by a knob
    acceptable: tuple[float, float, float]  # RMSE, late RMSE, total variation
    lost_beyond: float  # a late RMSE beyond which a run is lost

    @property
    def model(self) -> LoadedPlant:
        """The model of the observer."""
        return LoadedPlant(self.plant, self.unit)

    @property
    def outputs(self) -> wb.Layout:
        """The outputs that follow a reference."""
        return wb.Layout(tuple(self.plant.outputs[name] for name in self.tracks))

    def with_limits(self, level: float) -> Problem:
        """The same with other limits."""
        low, high = ((level * end[0], level * end[1]) for end in (self.low, self.high))
        return replace(self, low=low if min(self.low) < 0 else self.low, high=high)


@dataclass(frozen=True)
class LinearModel:
    """The plant at its rest, sampled exactly: x+ = A x + B u, y = C x, and the map from a reference to its rest."""

    A: wb.Array
    B: wb.Array
    C: wb.Array
    X: wb.Array
    G: wb.Array


@cache
def linear_model(key: str) -> LinearModel:
    """The linear model of a problem."""
    problem = PROBLEMS[key]
    ode = wb.open_loop(problem.plant)
    linear = wb.linearize(ode, 0.0, np.array(problem.x0), u=np.array(problem.u0), at_rest=True)
    sampled = wb.c2d(linear, problem.period)
    labels = [label for label in linear.output_labels if label.partition("[")[0] in problem.tracks]
    C = np.asarray(linear.C)[[linear.output_labels.index(label) for label in labels]]
    A, B = np.asarray(sampled.A), np.asarray(sampled.B)
    n, m = B.shape
    system = np.block([[A - np.eye(n), B], [C, np.zeros((len(C), m))]])
    rest = np.linalg.lstsq(system, np.vstack([np.zeros((n, len(C))), np.eye(len(C))]), rcond=None)[0]
    return LinearModel(A, B, C, rest[:n], rest[n:])


def weights(problem: Problem, knobs: Knobs) -> tuple[wb.Array, wb.Array]:
    """Q and R of a quadratic cost: positions or levels count alike, the other states and the inputs by knobs."""
    nx, count = problem.plant.states.size, len(problem.outputs.labels)
    Q = np.diag([1.0] * count + [knobs["rates"]] * (nx - count))
    own = PROBLEMS[problem.key]  # the weights stay those of the usual limits
    span = np.array(own.high) - np.array(own.low)
    return Q, np.diag(knobs["inputs"] / (span / 2) ** 2)


def target_of(problem: Problem) -> Target:
    """The target block of a problem."""
    model, plant = linear_model(problem.key), problem.plant
    x0, u0, r0, low, high = (
        np.array(one, dtype=float) for one in (problem.x0, problem.u0, problem.r0, problem.low, problem.high)
    )
    return Target(
        plant.states, plant.inputs, problem.outputs, problem.unit, x0, u0, r0, model.X, model.G, low=low, high=high
    )


def observer_of(problem: Problem, load: float) -> wb.SteadyKalmanFilter:
    """The observer of all laws of a problem, a steady Kalman filter of the states and of d.

    `load` is the standard deviation of a period's change of d in the filter's model, as a share of the usual one.
    """
    model, plant = problem.model, problem.plant
    ode = wb.open_loop(model)
    x = np.concatenate([problem.x0, np.zeros(2)])
    own, drift = problem.drift
    names = tuple(name for name, _ in problem.noise)
    sigma = {name: np.hypot(value, dict(problem.quantum).get(name, 0.0) / np.sqrt(12)) for name, value in problem.noise}
    R = np.concatenate([np.full(plant.outputs[name].size, sigma[name] ** 2) for name in names])
    Q = np.diag([*np.full(plant.states.size, own**2), *2 * [(load * drift) ** 2]]) / problem.period
    design = wb.steady_kalman(ode, Q, np.diag(R), names, period=problem.period, x=x, u=np.array(problem.u0))
    return wb.SteadyKalmanFilter(model, design.K, problem.period, names, start=x)


def _arm() -> Problem:
    target = (0.8, 0.6)
    gravity = ca.Function("G", [q := ca.SX.sym("q", 2)], [ARM.gravity_vector(q)])
    u0 = np.array(gravity(np.array(target))).ravel()
    return Problem(
        key="arm",
        name="the paper's arm",
        plant=wb.Manipulator(ARM, q=(0.0, 0.0)),
        unit="N m",
        output_unit="rad",
        tracks=("q",),
        x0=(*target, 0.0, 0.0),
        u0=(float(u0[0]), float(u0[1])),
        r0=target,
        period=0.01,
        horizon=3.0,
        substeps=2,
        stages=30,
        low=(-60.0, -25.0),
        high=(60.0, 25.0),
        levels=(0.6, 0.7, 0.85, 1.0, 1.4, 2.0),
        noise=(("q", 5e-4),),
        quantum=(("q", 1e-3),),
        unknowns=(
            VariedNumber("first mass", ("plant.arm.links[0].mass",), 0.85, 1.15),
            VariedNumber("second mass", ("plant.arm.links[1].mass",), 0.85, 1.15),
        ),
        starts=(("q[0]", -0.3, 0.3), ("q[1]", -0.3, 0.3)),
        targets=((0.5, 1.1), (0.3, 0.9)),
        drift=(2e-2, 3.0),
        sizes=(1.0, 1.0, 1.0, 1.0),
        acceptable=(0.3, 0.005, 300.0),
        lost_beyond=0.3,
    )


def _tank() -> Problem:
    plant = wb.QuadrupleTank()
    g_1, g_2, g = plant.gamma_1, plant.gamma_2, plant.g
    r0 = (12.4, 12.7)
    flow = np.array([[g_1 * plant.k_1, (1 - g_2) * plant.k_2], [(1 - g_1) * plant.k_1, g_2 * plant.k_2]])
    out = np.array([plant.a_1 * np.sqrt(2 * g * r0[0]), plant.a_2 * np.sqrt(2 * g * r0[1])])
    v = np.linalg.solve(flow, out)
    h_3 = ((1 - g_2) * plant.k_2 * v[1] / plant.a_1) ** 2 / (2 * g)
    h_4 = ((1 - g_1) * plant.k_1 * v[0] / plant.a_2) ** 2 / (2 * g)
    return Problem(
        key="tank",
        name="the quadruple tank",
        plant=plant,
        unit="V",
        output_unit="cm",
        tracks=("h_1", "h_2"),
        x0=(*r0, float(h_3), float(h_4)),
        u0=(float(v[0]), float(v[1])),
        r0=r0,
        period=4.0,
        horizon=480.0,
        substeps=2,
        stages=30,
        low=(1.0, 1.0),
        high=(5.0, 5.0),
        levels=(0.8, 0.85, 0.9, 1.0, 1.3, 2.0),
        noise=(("h_1", 0.02), ("h_2", 0.02)),
        quantum=(("h_1", 0.02), ("h_2", 0.02)),
        unknowns=(
            VariedNumber("first pump", ("plant.k_1",), 0.93, 1.07),
            VariedNumber("second pump", ("plant.k_2",), 0.93, 1.07),
            VariedNumber("first valve", ("plant.gamma_1",), 0.95, 1.05),
            VariedNumber("second valve", ("plant.gamma_2",), 0.95, 1.05),
        ),
        starts=(("h_1", 10.4, 14.4), ("h_2", 10.7, 14.7)),
        targets=((12.4, 15.4), (12.7, 15.7)),
        drift=(2e-2, 1e-2),
        sizes=(1.0, 1.0, 1.0, 1.0),
        acceptable=(0.8, 0.1, 0.05),
        lost_beyond=1.0,
    )


def _quadrotor() -> Problem:
    plant = wb.PlanarQuadrotor()
    hover = plant.m * plant.g / 2
    return Problem(
        key="quadrotor",
        name="a quadrotor in a plane",
        plant=plant,
        unit="N",
        output_unit="m",
        tracks=("x", "y"),
        x0=(0.0,) * 6,
        u0=(float(hover), float(hover)),
        r0=(0.0, 0.0),
        period=0.02,
        horizon=5.0,
        substeps=2,
        stages=40,
        low=(0.0, 0.0),
        high=(4.0, 4.0),
        levels=(0.75, 0.85, 1.0, 1.25, 1.75, 2.5),
        noise=(("x", 5e-3), ("y", 5e-3), ("theta", 3e-3)),
        quantum=(("x", 1e-3), ("y", 1e-3), ("theta", 1e-3)),
        unknowns=(
            VariedNumber("mass", ("plant.m",), 0.9, 1.1),
            VariedNumber("inertia", ("plant.I",), 0.8, 1.2),
            VariedNumber("arm", ("plant.r",), 0.95, 1.05),
        ),
        starts=(("x", -2.5, -0.5), ("y", -1.0, 1.0), ("theta", -0.3, 0.3)),
        targets=((-0.5, 0.5), (-0.5, 0.5)),
        drift=(2e-2, 1e-1),
        sizes=(1.0, 1.0, 1.0, 1.0, 1.0, 1.0),
        acceptable=(0.5, 0.05, 5.0),
        lost_beyond=0.5,
    )


PROBLEMS = {one.key: one for one in (_arm(), _tank(), _quadrotor())}
