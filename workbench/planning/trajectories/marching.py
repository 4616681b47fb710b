"""The march of a plan by the simulator: each interval from its node, and the whole from the start."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, StepMap
from workbench.core.step import rk4
from workbench.core.validation.refusals import Array
from workbench.engine.batch import run_step
from workbench.planning.trajectories.plan_problem import PlanProblem
from workbench.planning.trajectories.plan_values import ArcValues, Values

STEPS = 8  # of the march in an interval
ROUNDING = 1e-3  # of the largest value of a state that moves by less


@dataclass(frozen=True, eq=False)
class MarchedArc:
    """The march of a phase: states (N, K + 1, nx) within each interval, and the integral of the cost (N,) over it."""

    x: Array
    cost: Array


@lru_cache(maxsize=32)
def _interval_step(ode: Ode, rate: ca.Function, places: tuple[int, ...], steps: int) -> StepMap:
    """A step of the equation over a share of an interval, whose begin, length and inputs are parameters."""
    nx, nu = ode.states.size, len(places)
    extra = Layout(
        (
            Entry("interval.begin", np.array(0.0)),
            Entry("interval.length", np.array(1.0)),
            Entry("interval.first", np.zeros(nu)),
            Entry("interval.last", np.zeros(nu)),
        )
    )
    share, q = ca.SX.sym("share"), ca.SX.sym("cost")
    x, e = ode.states.symbols(), extra.symbols()
    t0, h, first, last = e[0], e[1], e[2 : 2 + nu], e[2 + nu :]
    fast, cost_rate = rate(t0 + share * h, x, first + share * (last - first))
    states = ode.states + Layout((Entry("interval.cost", np.array(0.0)),))
    inner = Ode(
        "interval", states, extra, Layout(), share, ca.vertcat(x, q), e, h * ca.vertcat(fast, cost_rate), ca.SX(0, 1)
    )
    del nx
    return rk4(inner, 1.0 / steps)


def march(problem: PlanProblem, values: Values, steps: int = STEPS) -> tuple[MarchedArc, ...]:
    """Each interval of each phase marched from its own first node."""
    marched, begin = [], 0.0
    for phase, arc in zip(problem.phases, values, strict=True):
        step = _interval_step(problem.ode, phase.rate, problem.input_places, steps)
        nodes = begin + arc.T * arc.shares
        p = np.column_stack([nodes[:-1], np.diff(nodes), arc.begins, arc.ends])
        x0 = np.column_stack([arc.x[:-1], np.zeros(len(arc.mesh))])
        runs = run_step(step, p, x0, until=1.0, every=1.0 / steps)
        x = runs.x
        marched.append(MarchedArc(x[:, :, :-1], x[:, -1, -1]))
        begin = float(nodes[-1])
    return tuple(marched)


def ranges(values: Values) -> Array:
    """The range (nx,) of each state, or a thousandth of its size where it hardly moves."""
    x = np.concatenate([arc.x for arc in values])
    sizes = np.maximum(np.abs(x).max(axis=0), ROUNDING)
    return np.asarray(np.maximum(np.ptp(x, axis=0), ROUNDING * sizes))


def defects(values: Values, runs: tuple[MarchedArc, ...]) -> list[Array]:
    """For each phase, the largest miss (N,) of the next node over the range of the state."""
    size = ranges(values)
    return [np.abs((run.x[:, -1] - arc.x[1:]) / size).max(axis=1) for arc, run in zip(values, runs, strict=True)]


def objective(problem: PlanProblem, values: Values, runs: tuple[MarchedArc, ...]) -> float:
    """The objective of the march."""
    T = sum(arc.T for arc in values)
    return float(sum(run.cost.sum() for run in runs) + float(problem.end_cost(T, values[-1].x[-1])))


def run_from_start(problem: PlanProblem, values: Values, steps: int = STEPS) -> list[Array]:
    """The states (N + 1, nx) at the nodes of each phase in one run from the start under the recorded inputs."""
    runs, x, begin = [], values[0].x[0], 0.0
    for phase, arc in zip(problem.phases, values, strict=True):
        step = _interval_step(problem.ode, phase.rate, problem.input_places, steps)
        nodes = begin + arc.T * arc.shares
        p = np.column_stack([nodes[:-1], np.diff(nodes), arc.begins, arc.ends])
        states = [x]
        for row in p:
            end = run_step(step, row[np.newaxis], np.append(states[-1], 0.0)[np.newaxis], until=1.0, every=1.0)
            states.append(end.x[0, -1, :-1])
        runs.append(np.array(states))
        x = states[-1] if phase.jump is None else np.array(phase.jump(states[-1])).ravel()
        begin = float(nodes[-1])
    return runs


def roughness(arc: ArcValues) -> Array:
    """The roughness (N, nu) of inputs: what a constant, or a straight line, leaves out of them in an interval.

    Of held inputs half the change to the neighbour that differs more; of linear ones an eighth of the change of slope
    to that neighbour, times the length of the interval.
    """
    edge = np.zeros((1, arc.u.shape[1]))
    if arc.is_held:
        change = np.abs(np.diff(arc.u, axis=0)) / 2
        return np.asarray(np.maximum(np.vstack([edge, change]), np.vstack([change, edge])))
    h = arc.mesh[:, np.newaxis]
    bend = np.abs(np.diff(np.diff(arc.u, axis=0) / h, axis=0)) / 8
    return np.asarray(h * np.maximum(np.vstack([edge, bend]), np.vstack([bend, edge])))
