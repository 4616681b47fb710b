"""A sampled funnel: the share of starts about a plan from which its regulator keeps a loop near it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.core.recorded_step import SignalRecord, recorded_step
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite, known_name, positive, whole
from workbench.core.validation.refusals import seed as check_seed
from workbench.core.validation.signatures import check_arguments
from workbench.engine.record_runs import run_along
from workbench.planning.trajectories.plan_problem import PhaseProblem
from workbench.planning.trajectories.trajectory_plan import Plan
from workbench.planning.trajectories.trajectory_regulator import TrajectoryRegulator

PARTS = 4  # of each interval, in which the march steps


@dataclass(frozen=True, eq=False)
@show
class Funnel:
    """Runs from random starts about a plan under its regulator, and the share that stays near the plan.

    Parameters
    ----------
    starts
        (B, nx), the starts.
    deviations
        (B, nx), the largest deviation of each state from the plan over each run; infinite where a run diverges.
    ends
        (B, nx), the deviations at the end.
    is_inside
        (B,), whether each run stays.
    confidence
        The probability that the interval of the share holds the true one.
    """

    starts: Array
    deviations: Array
    ends: Array
    is_inside: Array
    confidence: float

    @property
    def share(self) -> float:
        """The share of runs that stay."""
        return float(self.is_inside.mean())

    @property
    def interval(self) -> tuple[float, float]:
        """The interval of Clopper and Pearson (1934) for the share of all starts."""
        from scipy import stats

        n, k, tail = len(self.is_inside), int(self.is_inside.sum()), (1 - self.confidence) / 2
        low = float(stats.beta.ppf(tail, k, n - k + 1)) if k else 0.0
        high = float(stats.beta.ppf(1 - tail, k + 1, n - k)) if k < n else 1.0
        return low, high


@check_arguments
def funnel(
    regulator: TrajectoryRegulator,
    spread: Mapping[str, float],
    within: Mapping[str, float],
    *,
    runs: int = 1000,
    seed: int = 0,
    confidence: float = 0.95,
) -> Funnel:
    """The share of starts from which a plant under u = u_ref - K (x - x_ref), limited as in the plan, stays near it.

    Starts are uniform in a box about the start of the plan. A run stays if no state leaves its distance from the plan.

    Parameters
    ----------
    regulator
        Gains along a plan of one phase, as `trajectory_lqr` makes them.
    spread
        By state, half the width of the box of starts; zero for states without a name.
    within
        By state, the largest deviation at any time; states without a name are free.
    runs, seed
        The number of runs, and the key of the random starts.
    confidence
        The probability that the interval of the share holds the true share.

    Raises
    ------
    ValueError
        If the plan has several phases, or a number is out of range.
    LookupError
        If there is no such state.

    Examples
    --------
    >>> turn = wb.plan(wb.open_loop(wb.DCMotor()), 1.0, cost="energy", end={"omega": 1.0, "i": 0.5})
    >>> near = wb.planning.trajectory_lqr(turn, Q=np.eye(2), R=[[1.0]])
    >>> wb.planning.funnel(near, {"omega": 0.1}, {"omega": 0.11}, runs=100).share
    1.0
    """
    plan = regulator.plan
    if len(plan.values) > 1:
        raise ValueError("`funnel(regulator=...)` must be of a plan of one phase; sample each phase by itself.")
    count = whole("funnel(runs=...)", runs)
    level = finite("funnel(confidence=...)", confidence)
    if not 0 < level < 1:
        raise ValueError(f"`funnel(confidence=...)` must lie between 0 and 1; got {level:g}.")
    width, most = _by_state(plan, "spread", spread, 0.0), _by_state(plan, "within", within, np.inf)
    rng = np.random.default_rng(check_seed("funnel(seed=...)", seed))
    starts = plan.x[0] + width * rng.uniform(-1.0, 1.0, (count, len(width)))
    x, along = _run(regulator, starts)
    apart = np.abs(x - along)
    apart = np.where(np.isfinite(apart), apart, np.inf)
    deviations = apart.max(axis=1)
    return Funnel(starts, deviations, apart[:, -1], (deviations <= most).all(axis=1), level)


def _by_state(plan: Plan, what: str, values: Mapping[str, float], other: float) -> Array:
    """(nx,), the values by state."""
    row = np.full(plan.states.size, other)
    for name, value in values.items():
        known_name(name, (*plan.states.names, *plan.states.labels), "states of this plan")
        row[plan.states.indices(name)] = positive(f"funnel({what}={{{name!r}: ...}})", value)
    return row


def _run(regulator: TrajectoryRegulator, starts: Array) -> tuple[Array, Array]:
    """The states (B, K, nx) of all runs at K instants, and those of the plan (K, nx)."""
    plan = regulator.plan
    arc, phase = plan.values[0], plan.problem.phases[0]
    shares = np.concatenate([np.linspace(a, b, PARTS, endpoint=False) for a, b in _pairs(arc.shares)] + [[1.0]])
    along, times = arc.states_at(shares), arc.T * shares
    middles = (shares[:-1] + shares[1:]) / 2
    k = np.clip(np.searchsorted(arc.shares, middles, side="right") - 1, 0, len(arc.mesh) - 1)
    inputs = []
    for end in (shares[:-1], shares[1:]):
        part = ((end - arc.shares[k]) / np.diff(arc.shares)[k])[:, np.newaxis]
        inputs.append(arc.begins[k] + part * (arc.ends - arc.begins)[k])
    gains = np.column_stack(
        [np.interp(times, regulator.times, row) for row in regulator.K.reshape(len(regulator.times), -1).T]
    )
    ode, labels = _closed_ode(plan, phase)
    record = SignalRecord(
        times, labels, np.hstack([inputs[0], along[:-1], gains[:-1]]), np.hstack([inputs[1], along[1:], gains[1:]])
    )
    step = recorded_step(ode, record)
    x = run_along(step, np.repeat(ode.parameters.default[np.newaxis], len(starts), axis=0), starts)
    return x, along


def _pairs(nodes: Array) -> list[tuple[float, float]]:
    return list(zip(nodes[:-1].tolist(), nodes[1:].tolist(), strict=True))


def _closed_ode(plan: Plan, phase: PhaseProblem) -> tuple[Ode, tuple[str, ...]]:
    """The plant under feedback about a trajectory whose numbers are parameters, and their labels."""
    nx, nu = plan.problem.nx, plan.problem.nu
    layout = Layout((Entry("u_ref", np.zeros(nu)), Entry("x_ref", np.zeros(nx)), Entry("gain", np.zeros(nu * nx))))
    t, x, p = ca.SX.sym("t"), plan.states.symbols(), layout.symbols()
    K = ca.reshape(p[nu + nx :], nx, nu).T
    u = p[:nu] - K @ (x - p[nu : nu + nx])
    u = ca.fmax(ca.fmin(u, ca.SX(phase.u.high)), ca.SX(phase.u.low))
    rate, _ = phase.rate(t, x, u)
    return Ode("plan", plan.states, layout, Layout(), t, x, p, rate, ca.SX(0, 1)), layout.labels
