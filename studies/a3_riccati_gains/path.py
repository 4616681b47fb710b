"""The Riccati matrix of (34) along a run of the proposed law, beside the equations it could be exchanged for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

import workbench as wb
from studies.paper.card import CARD
from studies.paper.comparison import PROPOSED_STEP
from studies.paper.laws import mass_matrices, proposed_repaired

WINDOW = 2.5  # s: the approach, and in the second scenario one jump
EVENLY = 10_001  # evenly spaced times, of which a median over time is taken
TRANSIENT = 0.05  # s: several times the time in which (34) forgets P(0)
INSTANTS = 60  # at which the algebraic equation is solved
RTOL = 1e-4  # of the equations in time: the path between kept states is a spline, and known no better
STEP, EVERY = PROPOSED_STEP / 4, 1e-3 / 12 * 30  # s: P left at P(0) lets K grow by half as much again
B, Q, R = np.diag(CARD["Lambda"]), np.asarray(CARD["Q"]), np.asarray(CARD["R"])
G = B @ np.linalg.solve(R, B.T)
ZERO = np.zeros((2, 2))
FORWARD, SDRE, AT_START = "P(t) of (34)", "SDRE: the CARE at each instant", "P = P(0)"


@dataclass(frozen=True, eq=False)
class Motion:
    """The gain K in N m and P of (34) in N m/rad, (N, 2, 2) each, and q_hat (N, 2) in rad, at times t (N,) of a run."""

    t: wb.Array
    K: wb.Array
    P: wb.Array
    q_hat: wb.Array


class Setting(NamedTuple):
    """A scenario with the weights Q I and R I of (34), in N m/(rad s)."""

    scenario: str
    Q: float
    R: float


@dataclass(frozen=True, eq=False)
class RunComparison:
    """The mean of P over a whole run with (34), (2, 2) in N m/rad, and P beside its rivals early in that run."""

    mean: wb.Array
    comparison: RiccatiComparison


def along(setting: Setting) -> RunComparison:
    """The repaired law with (34) along the run of a setting."""
    loop = proposed_repaired(setting.scenario)
    weighted = setting.Q * np.eye(2), setting.R * np.eye(2)
    ode = replace(loop, controller=replace(loop.controller, Q=weighted[0], R=weighted[1])).ode()
    until = float(CARD[f"{setting.scenario}: horizon"])
    run = wb.measure(ode, (), until=until, h=STEP, every=EVERY).trajectories
    P = run["controller.P"][0]
    mean = np.trapezoid(P, run.t, axis=0) / until
    inside = run.t <= WINDOW + 1e-9
    names = "controller.K", "controller.P", "observer.state.q_hat"
    motion = Motion(run.t[inside], *(run[name][0, inside] for name in names))
    return RunComparison((mean + mean.T) / 2, compare_solutions(motion, *weighted))


@dataclass(frozen=True, eq=False)
class RiccatiComparison:
    """P of (34) and its rivals at times t (N,) of one run, all (N, 2, 2) in N m/rad, and the gain K in N m."""

    t: wb.Array
    K: wb.Array
    P: wb.Array  # (34) as the loop integrated it
    X: wb.Array  # the algebraic equation at each instant: the state-dependent one for (31)
    backward: wb.riccati_flow.RiccatiFlow  # (32) minimised from each time to the end of the window
    forward: wb.riccati_flow.RiccatiFlow  # (34) solved again
    memory: float  # s, the longest in which a difference of two solutions of (34) near X falls to 1/e
    residual: float  # the largest of X
    ratios: Mapping[str, float]  # J over the least J, from the worst start, by the choice of P in u = -R^-1 B' P s

    def gap(self, X: wb.Array) -> tuple[float, float]:
        """The distance of (34) from another choice once P(0) is forgotten: its median over time, and its largest."""
        late = (self.t >= TRANSIENT) & X.any(axis=(1, 2))  # the backward solution ends at zero
        far = distance(self.P[late], X[late])
        return median_in_time(far, self.t[late]), float(far.max())


def compare_solutions(run: Motion, Q: wb.Array = Q, R: wb.Array = R) -> RiccatiComparison:
    """P of (34) along a run, beside its rivals."""
    G = B @ np.linalg.solve(R, B.T)
    t, K, P = run.t, run.K, run.P
    A = -np.linalg.solve(mass_matrices(run.q_hat), K)
    kept = instants(len(t))
    solved = [wb.riccati.care(A[i], B, Q, R) for i in kept]
    X, path = np.array([found.X for found in solved]), CubicSpline(t, A)
    backward = wb.riccati_flow.rde(path, B, Q, R, ZERO, t[kept], rtol=RTOL)
    choices: dict[str, Callable[[float], wb.Array]] = {
        FORWARD: CubicSpline(t, P),
        SDRE: CubicSpline(t[kept], X),
        AT_START: lambda time: np.asarray(P[0]),
        "P = 0": lambda time: ZERO,
    }
    return RiccatiComparison(
        t[kept],
        K[kept],
        P[kept],
        X,
        backward,
        wb.riccati_flow.fpre(path, B, Q, R, P[0], t[kept], rtol=RTOL),
        -0.5 / float(np.linalg.eigvals(A[kept] - G @ X).real.max()),
        max(found.certificate.residual for found in solved),
        {name: worst(cost(path, choice, t[kept], Q, R), backward.P[0]) for name, choice in choices.items()},
    )


def instants(states: int) -> wb.core.Integers:
    """The numbers of those of the kept states at which the algebraic equation is solved: more of the early ones."""
    early = np.geomspace(1, states, INSTANTS) - 1
    return np.union1d(early.round(), np.linspace(0, states - 1, INSTANTS).round()).astype(int)


def cost(
    path: Callable[[float], wb.Array],
    choice: Callable[[float], wb.Array],
    t: wb.Array,
    Q: wb.Array = Q,
    R: wb.Array = R,
) -> wb.Array:
    """Y (2, 2): s' Y s is J of (32) over the times from s with u = -R^-1 B' P s, by a linear equation backward."""
    G = B @ np.linalg.solve(R, B.T)

    def closed_loop_matrix(time: float) -> wb.Array:
        return np.asarray(path(time) - G @ choice(time))

    def weight(time: float) -> wb.Array:
        W = Q + choice(time) @ G @ choice(time)
        return np.asarray((W + W.T) / 2)

    return np.asarray(wb.riccati_flow.rde(closed_loop_matrix, ZERO, weight, R, ZERO, t, rtol=RTOL).P[0])


def worst(Y: wb.Array, least: wb.Array) -> float:
    """The largest s' Y s / s' P s over all s."""
    half: wb.Array = np.linalg.inv(np.linalg.cholesky(least))
    return float(np.linalg.eigvalsh(half @ Y @ half.T)[-1])


def distance(P: wb.Array, X: wb.Array) -> wb.Array:
    """The norm of P - X over that of X, (N,)."""
    return np.asarray(np.linalg.norm(P - X, axis=(1, 2)) / np.linalg.norm(X, axis=(1, 2)))


def median_in_time(values: wb.Array, t: wb.Array) -> float:
    """Half of the time from t[0] to t[-1] the values (N,) are at most this; between their times they are linear."""
    return float(np.median(np.interp(np.linspace(t[0], t[-1], EVENLY), t, values)))


def rise(K: wb.Array, t: wb.Array) -> float:
    """The first time at which the norm of K - K(0) is 1 - 1/e of its largest, in s."""
    moved = np.linalg.norm(K - K[0], axis=(1, 2))
    return float(t[np.argmax(moved >= (1 - np.exp(-1)) * moved.max())])
