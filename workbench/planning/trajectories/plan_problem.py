"""The problem of a plan: equations, cost, limits and boundary values of each phase, as functions and vectors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.validation.refusals import Array

INF = np.inf
SHARES = (0.37, -0.23, 0.71)  # of the sizes: points at which hardly a sine or cosine vanishes
NOTHING = 1e-9  # of the largest entry, below which one is rounding


@dataclass(frozen=True, eq=False)
class Ends:
    """Lowest and highest values (n,) of n quantities; infinite where there is none."""

    low: Array
    high: Array

    @staticmethod
    def free(size: int) -> Ends:
        """No bounds."""
        return Ends(np.full(size, -INF), np.full(size, INF))

    @property
    def ends(self) -> tuple[tuple[str, Array, float], ...]:
        """The lower and the upper end, each with its sign."""
        return (("low", self.low, -1.0), ("high", self.high, 1.0))


@dataclass(frozen=True, eq=False)
class PhaseProblem:
    """One phase: its equations at its own parameters, its duration, its limits and the values at its end."""

    name: str
    p: Array  # (np,), the parameters; the entries of the inputs are not used
    duration: tuple[float, float]  # s
    rate: ca.Function  # (t, x, u) -> x' (nx, 1), cost rate (1, 1)
    path: ca.Function  # (t, x, u) -> (ng, 1), outputs and signals that are limited or have a value at the end
    path_names: tuple[str, ...]
    x: Ends
    u: Ends
    slope: Ends  # of the inputs, per second
    g: Ends
    end: Ends  # of x and u at the end of the phase, (nx + nu,)
    g_end: Ends  # of the outputs and signals at the end, (ng,)
    jump: ca.Function | None = None  # x at the end -> x at the begin of the next phase

    @property
    def is_free(self) -> bool:
        """True if the duration is not fixed."""
        return self.duration[0] != self.duration[1]


@dataclass(frozen=True, eq=False)
class PlanProblem:
    """Minimise the sum of all cost rates over time and the cost at the end, within the limits of each phase."""

    ode: Ode
    inputs: tuple[str, ...]  # labels
    phases: tuple[PhaseProblem, ...]
    start: Ends  # of x and u at the begin, (nx + nu,)
    periodic: tuple[int, ...]  # places of states and inputs, (nx + nu,), whose end is their start
    end_cost: ca.Function  # (t, x) at the end -> (1, 1)
    hold: str
    method: str
    input_places: tuple[int, ...] = field(default=())  # among the parameters

    @property
    def nx(self) -> int:
        """The number of states."""
        return int(self.ode.states.size)

    @property
    def nu(self) -> int:
        """The number of inputs."""
        return len(self.inputs)

    @property
    def names(self) -> tuple[str, ...]:
        """The labels of states and inputs."""
        return (*self.ode.states.labels, *self.inputs)

    @cached_property
    def has_slopes(self) -> bool:
        """True if the rate of an input is limited."""
        return any(np.isfinite(end).any() for phase in self.phases for _, end, _ in phase.slope.ends)

    @cached_property
    def box(self) -> Ends:
        """The limits of x and u over all phases, (nx + nu,)."""
        low = np.min([np.concatenate([phase.x.low, phase.u.low]) for phase in self.phases], axis=0)
        high = np.max([np.concatenate([phase.x.high, phase.u.high]) for phase in self.phases], axis=0)
        return Ends(low, high)


@dataclass(frozen=True)
class Scales:
    """The sizes by which states, inputs and the times of the phases are divided."""

    x: Array
    u: Array
    T: Array

    @staticmethod
    def of_problem(problem: PlanProblem) -> Scales:
        """Sizes from limits and boundary values, 1 where there is neither."""
        box, nx = problem.box, problem.nx
        ends = [box.low, box.high, problem.start.low, problem.start.high]
        ends += [side for phase in problem.phases for side in (phase.end.low, phase.end.high)]
        values = np.abs(np.array(ends))
        finite = np.where(np.isfinite(values), values, 0.0)
        boundary = finite[2:].max(axis=0)
        sizes = np.where(boundary > 0, boundary, np.minimum(finite[:2].max(axis=0), 1e3))
        sizes[nx:] = finite.max(axis=0)[nx:]
        times = np.array([_time_guess(*phase.duration) for phase in problem.phases])
        sizes = _fill(sizes, problem, float(times.sum()))
        return Scales(sizes[:nx], sizes[nx:], times)

    @staticmethod
    def of_values(x: Array, u: Array, T: Array, before: Scales) -> Scales:
        """Sizes from the range of a trajectory, x (M, nx) and u (M, nu); of what does not move, those before."""
        moved = [np.abs(values).max(axis=0) for values in (x, u)]
        sizes = [
            np.where(m > 1e-6 * b, np.maximum(m, 1e-3 * b), b) for m, b in zip(moved, (before.x, before.u), strict=True)
        ]
        return Scales(sizes[0], sizes[1], T)


def _fill(sizes: Array, problem: PlanProblem, T: float) -> Array:
    """Sizes (nx + nu,) where those that are zero, as nothing was said, follow from the others by the equations.

    In the time T a state of size s_i is moved by a rate J_ij s_j: s_i = T |J_ij| s_j, with the Jacobian J of the rate
    at the start, or at a share of these sizes where that is zero or free. Where it has no entry there, other points
    may have one.
    """
    phase, nx = problem.phases[0], problem.nx
    t, x, u = ca.SX.sym("t"), ca.SX.sym("x", nx), ca.SX.sym("u", problem.nu)
    jacobian = ca.Function("J", [t, x, u], [ca.jacobian(phase.rate(t, x, u)[0], ca.vertcat(x, u))])
    full, begin = sizes.copy(), np.where(np.isfinite(problem.start.low), problem.start.low, 0.0)
    for share in SHARES:
        for _ in range(len(sizes)):
            offset = share * np.where(full > 0, full, 1.0)
            point = np.where(begin != 0, begin, offset) if share == SHARES[0] else begin + offset
            J = np.abs(np.array(jacobian(0.0, point[:nx], point[nx:])))
            J = np.where(np.isfinite(J), J, 0.0)
            sizes_by_place = _implied_sizes(np.where(NOTHING * J.max() < J, J, 0.0), full, T)
            if not sizes_by_place:
                break
            for place, values in sizes_by_place.items():
                full[place] = float(np.exp(np.mean(np.log(values))))
    return np.where(full > 0, full, 1.0)


def _implied_sizes(J: Array, full: Array, T: float) -> dict[int, list[float]]:
    """By the place of a size that is zero, the sizes that the others imply by the entries of J (nx, nx + nu)."""
    implied = dict[int, list[float]]()
    for i, j in zip(*np.nonzero(J), strict=True):
        if i != j and full[i] > 0 and full[j] == 0:
            implied.setdefault(int(j), []).append(full[i] / (T * J[i, j]))
        elif i != j and full[j] > 0 and full[i] == 0:
            implied.setdefault(int(i), []).append(T * J[i, j] * full[j])
    return implied


def _time_guess(low: float, high: float) -> float:
    """A duration between two ends, the geometric mean where both are of use."""
    if high == INF:
        return max(4 * low, 1.0)
    return float(np.sqrt(max(low, 1e-2 * high) * high))


Expression = Callable[..., object]
