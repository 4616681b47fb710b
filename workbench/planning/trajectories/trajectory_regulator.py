"""The linear-quadratic regulator along a plan: gains over time by the certified Riccati flow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from workbench.core import Layout
from workbench.core.motion_record import GainRecord
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, matrix
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import one_thread
from workbench.design.riccati_flow import RiccatiFlow, rde
from workbench.planning.trajectories.plan_values import ArcValues
from workbench.planning.trajectories.trajectory_plan import Plan

RTOL = 1e-7  # of P in each interval


@dataclass(frozen=True, eq=False)
@show
class TrajectoryRegulator:
    """Gains K(t) of u = u_ref - K (x - x_ref) along a plan, with the cost to go e'P(t)e of the linearised plant.

    `wb.planning.trajectory_lqr` makes one. `wb.TrajectoryFeedback(near.states, near.inputs, near.gains)` is the law.

    Parameters
    ----------
    plan
        The plan.
    times
        (m,), the nodes of the plan in s.
    K
        (m, nu, nx), the gains at the nodes.
    P
        (m, nx, nx), the solution of the Riccati equation.
    error
        The sum of the estimated relative errors of P over all intervals.
    """

    plan: Plan
    times: Array
    K: Array
    P: Array
    error: float

    @property
    def gains(self) -> GainRecord:
        """The gains over time, as `wb.TrajectoryFeedback` takes them."""
        return GainRecord(self.times, self.K)

    @property
    def states(self) -> Layout:
        """The states."""
        return self.plan.states

    @property
    def inputs(self) -> Layout:
        """The inputs."""
        return self.plan.inputs


@check_arguments
@one_thread()
def trajectory_lqr(plan: Plan, Q: Numbers, R: Numbers, P1: Numbers | None = None) -> TrajectoryRegulator:
    """The time-varying linear-quadratic regulator along a plan:

        -P' = A'P + PA - P B R^-1 B' P + Q,      P(T) = P1,      K = R^-1 B' P,

    where A(t) and B(t) are the Jacobians along the plan. It minimises the integral of e'Qe + v'Rv and e'P1e at the end,
    for small deviations e and v.

    Parameters
    ----------
    plan
        The plan.
    Q, R
        (nx, nx) and (nu, nu).
    P1
        (nx, nx), the weight of the end; Q by default.

    Raises
    ------
    ValueError
        If a matrix does not fit.
    DesignError
        If P escapes to infinity within the plan.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, chapter 2.

    Examples
    --------
    >>> turn = wb.plan(wb.open_loop(wb.DCMotor()), 1.0, cost="energy", end={"omega": 1.0, "i": 0.5})
    >>> wb.planning.trajectory_lqr(turn, Q=np.eye(2), R=[[1.0]]).K.shape == (len(turn.t), 1, 2)
    True
    """
    nx, nu = plan.problem.nx, plan.problem.nu
    weights = {"Q": (Q, nx), "R": (R, nu), "P1": (Q if P1 is None else P1, nx)}
    Q, R, P = (matrix(f"trajectory_lqr({name}=...)", value, n, n) for name, (value, n) in weights.items())
    ends, flows = np.cumsum(plan.durations), list[RiccatiFlow]()
    jumps = [phase.jump for phase in plan.problem.phases]
    for i in reversed(range(len(plan.values))):
        if flows and (jump := jumps[i]) is not None:
            slope = _jump_slope(jump, plan.values[i].x[-1])
            P = slope.T @ P @ slope
        arc = plan.values[i]
        nodes = ends[i] - arc.T + arc.T * arc.shares
        for k in reversed(range(len(arc.mesh))):
            A, B = _slopes(plan, i, arc, k, nodes)
            flows.append(rde(A, B, Q, R, P, nodes[k : k + 2], rtol=RTOL))
            P = flows[-1].P[0]
    flows.reverse()
    times, places = np.unique(np.concatenate([[flow.times[0] for flow in flows], [flows[-1].times[1]]]), True)
    gains = [flow.K[0] for flow in flows] + [flows[-1].K[1]]
    solutions = [flow.P[0] for flow in flows] + [flows[-1].P[1]]
    error = float(sum(flow.error.max() for flow in flows))
    K, solution = (np.array([rows[int(k)] for k in places]) for rows in (gains, solutions))
    return TrajectoryRegulator(plan, times, K, solution, error)


def _slopes(
    plan: Plan, phase: int, arc: ArcValues, k: int, nodes: Array
) -> tuple[Callable[[float], Array], Callable[[float], Array]]:
    """A(t) and B(t) along an interval, as functions of the time in s."""
    problem, ode = plan.problem, plan.problem.ode
    p, places = problem.phases[phase].p.copy(), list(problem.input_places)
    every = [place for name in ode.inputs for place in ode.parameters.indices(name)]
    columns = [every.index(place) for place in places]  # of B, which has the inputs that are not planned, too
    first, length = float(nodes[k]), float(nodes[k + 1] - nodes[k])
    powers = arc.powers(k)
    begin, change = arc.begins[k], arc.ends[k] - arc.begins[k]

    @lru_cache(maxsize=64)
    def both(t: float) -> tuple[Array, Array]:
        share = min(max((t - first) / length, 0.0), 1.0)
        x = powers @ share ** np.arange(powers.shape[1])
        p[places] = begin + share * change
        return np.array(ode.A(t, x, p)), np.array(ode.B(t, x, p))[:, columns]

    return (lambda t: both(t)[0]), (lambda t: both(t)[1])


def _jump_slope(jump: ca.Function, x: Array) -> Array:
    symbol = ca.SX.sym("x", x.size)
    return np.array(ca.Function("slope", [symbol], [ca.jacobian(jump(symbol), symbol)])(x))
