"""The nonlinear program of a plan: variables, constraints and bounds, and the way from its numbers to a trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import Array
from workbench.planning.trajectories.collocation import STAGES, interval_function
from workbench.planning.trajectories.plan_problem import Ends, PhaseProblem, PlanProblem, Scales
from workbench.planning.trajectories.plan_values import ArcValues, Values, linear_inner

Parts = tuple[Array, Array, Array, Array]  # T, states at nodes and inside, inputs


@dataclass(frozen=True, eq=False)
class ArcSymbols:
    """The scaled variables of a phase: T, states at nodes (nx, N + 1) and inside (nx (d - 1), N), inputs (nu, M)."""

    T: ca.MX
    Z: ca.MX
    C: ca.MX
    V: ca.MX

    @staticmethod
    def of(problem: PlanProblem, count: int, place: int) -> ArcSymbols:
        """The variables of a phase of `count` intervals."""
        inner = problem.nx * (STAGES - 1) if problem.method == "collocation" else 0
        sizes = {"T": (1, 1), "Z": (problem.nx, count + 1), "C": (inner, count)}
        sizes["V"] = (problem.nu, count if problem.hold == "zero" else count + 1)
        return ArcSymbols(**{name: ca.MX.sym(f"{name}{place}", *size) for name, size in sizes.items()})

    @property
    def column(self) -> ca.MX:
        """All of them as one column."""
        return ca.vertcat(self.T, ca.vec(self.Z), ca.vec(self.C), ca.vec(self.V))

    def begins(self, hold: str) -> ca.MX:
        """The inputs at the begin of each interval."""
        return self.V if hold == "zero" else self.V[:, :-1]

    def ends(self, hold: str) -> ca.MX:
        """The inputs at the end of each interval."""
        return self.V if hold == "zero" else self.V[:, 1:]


@dataclass(frozen=True, eq=False)
class ArcTerms:
    """The expressions of a phase: defects, the integral of the cost, and limited signals (ng, K) at all points."""

    defects: ca.MX
    cost: ca.MX
    signals: ca.MX
    slopes: ca.MX  # change of the scaled inputs (nu, N) over each interval
    h: ca.MX  # (1, N), s


class Transcription:
    """The nonlinear program on given meshes, in scaled variables; read `nlp`, then `bounds`."""

    def __init__(self, problem: PlanProblem, meshes: tuple[Array, ...], scales: Scales) -> None:
        self.problem, self.meshes, self.scales = problem, meshes, scales
        self.arcs = tuple(ArcSymbols.of(problem, len(mesh), i) for i, mesh in enumerate(meshes))
        self.terms = tuple(self._terms(i) for i in range(len(meshes)))
        self.w = ca.vertcat(*[arc.column for arc in self.arcs])
        last, T = self.arcs[-1], sum((self._duration(i) for i in range(len(meshes))), ca.MX(0))
        self.end_time = T
        end = problem.end_cost(T, ca.DM(scales.x) * last.Z[:, -1])
        self.cost = sum((terms.cost for terms in self.terms), ca.MX(0)) + end
        self.links = ca.vertcat(*self._links())

    def _duration(self, i: int) -> ca.MX:
        return float(self.scales.T[i]) * self.arcs[i].T

    def _terms(self, i: int) -> ArcTerms:
        arc, mesh, hold = self.arcs[i], self.meshes[i], self.problem.hold
        function = interval_function(self.problem.phases[i], self.scales, self.problem.method)
        share = ca.DM(mesh / mesh.sum()).T
        h = self._duration(i) * share
        before = sum((self._duration(k) for k in range(i)), ca.MX(0))
        t0 = before + self._duration(i) * ca.DM(np.cumsum(np.append(0.0, mesh[:-1])) / mesh.sum()).T
        each = function.map(len(mesh))
        begins, ends = arc.begins(hold), arc.ends(hold)
        defects, cost, first, signals = each(t0, h, arc.Z[:, :-1], arc.C, arc.Z[:, 1:], begins, ends)
        return ArcTerms(defects, ca.sum2(cost), ca.vertcat(first, signals), ends - begins, h)

    def _links(self) -> list[ca.MX]:
        """The differences that are zero between phases, and between end and start."""
        links, nx, sx = [ca.MX(0, 1)], self.problem.nx, ca.DM(self.scales.x)
        for phase, before, after in zip(self.problem.phases[:-1], self.arcs[:-1], self.arcs[1:], strict=True):
            end = before.Z[:, -1] if phase.jump is None else phase.jump(sx * before.Z[:, -1]) / sx
            links.append(after.Z[:, 0] - end)
        first, last = self.arcs[0], self.arcs[-1]
        begin, end = (ca.vertcat(arc.Z[:, k], arc.V[:, k]) for arc, k in ((first, 0), (last, -1)))
        links += [end[i] - begin[i] for i in self.problem.periodic if i < nx or self.problem.hold == "linear"]
        return links

    def pack(self, values: Values) -> Array:
        """The scaled variables (nw,) of a trajectory on these meshes."""
        parts: list[Array] = []
        for i, arc in enumerate(values):
            inner = arc.inner / self.scales.x if self.problem.method == "collocation" else np.zeros(0)
            z, v = arc.x / self.scales.x, arc.u / self.scales.u
            parts += [np.array([arc.T / self.scales.T[i]]), z.ravel(), inner.ravel(), v.ravel()]
        return np.concatenate(parts)

    def unpack(self, w: Array) -> Values:
        """The trajectory of scaled variables."""
        values = []
        for i, parts in enumerate(self.split(w)):
            T, z, inner, v = parts
            x = z * self.scales.x
            inside = inner * self.scales.x
            if self.problem.method != "collocation":
                inside = linear_inner(x)
            values.append(
                ArcValues(self.meshes[i], float(T[0]) * float(self.scales.T[i]), x, inside, v * self.scales.u)
            )
        return tuple(values)

    def split(self, w: Array) -> list[Parts]:
        """T (1,), states (N + 1, nx), inner states (N, d - 1, nx) and inputs (M, nu) of each phase of a column."""
        parts, at, nx, nu = [], 0, self.problem.nx, self.problem.nu
        for arc, mesh in zip(self.arcs, self.meshes, strict=True):
            sizes = np.cumsum([at, 1, arc.Z.numel(), arc.C.numel(), arc.V.numel()])
            T, z, c, v = (w[a:b] for a, b in pairwise(sizes))
            parts.append((T, z.reshape(-1, nx), c.reshape(len(mesh), -1, nx), v.reshape(-1, nu)))
            at = int(sizes[-1])
        return parts

    def bounds(self) -> tuple[Array, Array]:
        """The bounds (nw,) of the variables; lower ones may lie above upper ones where limits conflict."""
        low, high = (np.full(self.w.numel(), sign * np.inf) for sign in (-1.0, 1.0))
        lows, highs = self.split(low), self.split(high)  # views
        problem, nx = self.problem, self.problem.nx
        for i, phase in enumerate(problem.phases):
            for parts, sign in ((lows[i], -1.0), (highs[i], 1.0)):
                side = 0 if sign < 0 else 1
                parts[0][:] = phase.duration[side] / self.scales.T[i]
                x, u = ((e.low, e.high)[side] for e in (phase.x, phase.u))
                parts[1][:], parts[2][:] = x / self.scales.x, x / self.scales.x
                parts[3][:] = u / self.scales.u
            _tighten(lows[i], highs[i], phase.end, self.scales, nx, -1)
        _tighten(lows[0], highs[0], problem.start, self.scales, nx, 0)
        return low, high

    def signal_bounds(self, phase: PhaseProblem, count: int) -> tuple[Array, Array]:
        """The bounds of the signals of a phase at all points, column by column; the last are those at the end."""
        points = STAGES + 1 if self.problem.method == "collocation" else 2
        low, high = np.tile(phase.g.low, points * count), np.tile(phase.g.high, points * count)
        size = len(phase.path_names)
        low[-size:] = np.maximum(low[-size:], phase.g_end.low)
        high[-size:] = np.minimum(high[-size:], phase.g_end.high)
        return low, high


def _tighten(low: Parts, high: Parts, ends: Ends, scales: Scales, nx: int, k: int) -> None:
    """Narrow the bounds of one node by boundary values."""
    sizes = np.concatenate([scales.x, scales.u])
    for part, size in ((1, slice(0, nx)), (3, slice(nx, None))):
        low[part][k] = np.maximum(low[part][k], (ends.low / sizes)[size])
        high[part][k] = np.minimum(high[part][k], (ends.high / sizes)[size])
