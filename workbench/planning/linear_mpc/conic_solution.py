r"""The multipliers of a problem with cones outside the graph: sweeps of ADMM, then Newton's method on their residual.

With P the derivative of the nearest point v(zeta), Newton's step on g = y0 - D (zeta - v) / sigma - v changes lambda by
w = U c, where the columns of U span the range of I - P, with eigenvalues mu:

    (U'D U + diag(sigma (1 - mu) / mu)) c = U'g,      zeta <- zeta + g - D w + sigma w.

A row beyond its limit has one direction with mu = 1. A cone has its normal (n, -slope), n = (l - c) / r, with mu = 1,
and the directions across n with mu = (r - slope a - offset) / ((1 + slope^2) r); behind its apex all have mu = 1. The
step is semismooth (Qi and Sun 1993): from near the solution it converges quadratically. Where the residual does not
fall, more sweeps of ADMM follow, which converge from anywhere if there is a solution.

References: Qi and Sun (1993), A nonsmooth version of Newton's method, Math. Programming 58. Fukushima, Luo and Tseng
(2002), Smoothing functions for second-order-cone complementarity problems, SIAM J. Optim. 12, for the derivative.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from workbench.core.validation.refusals import Array
from workbench.planning.linear_mpc.cone_limits import StageCone, is_beyond, nearest
from workbench.planning.linear_mpc.linear_problem import LinearMpc

SWEEPS, ROUNDS = 30, 20  # of ADMM before each trial of Newton's method, and of such trials
STEPS, PATIENCE = 20, 3  # of Newton's method, and of those in a row that do not lessen the residual
RELAXATION = 1.6
DONE = 1e-13  # of the rows: a residual below it is rounding
GOOD = 1e-8


class ConicErrors(NamedTuple):
    """The errors of multipliers in the conditions of the optimum, as `KktCertificate` has them."""

    violation: float
    sign: float
    gap: float


@dataclass(frozen=True, eq=False)
class ConicSolver:
    """The solver of a problem with cones: D (M, M), T (M, n) with D = T T', penalties 1 / sigma (M,), and G of ADMM."""

    problem: LinearMpc
    D: Array
    T: Array
    sigma: Array
    G: Array

    @property
    def cones(self) -> tuple[StageCone, ...]:
        """The cones of a stage."""
        return self.problem.rows.cones

    def nearest(self, y: Array) -> Array:
        """The nearest rows (M,) within all limits and cones."""
        return nearest(self.cones, self.problem.rows.count, y, *self.ends)

    @cached_property
    def ends(self) -> tuple[Array, Array]:
        """The limits (M,), with none on the rows of cones, whose limits are implied by others."""
        low, high = self.problem.low, self.problem.high
        places = np.zeros(self.problem.rows.count, dtype=bool)
        for cone in self.cones:
            places[list(cone.rows)] = True
        free = np.tile(places, self.problem.horizon)
        return np.where(free, -np.inf, low), np.where(free, np.inf, high)

    def multipliers(self, y0: Array) -> tuple[Array, int] | None:
        """The multipliers (M,) of the optimum for rows y0 (M,) of LQR, and the steps of Newton; None without any."""
        if not is_beyond(self.cones, self.problem.rows.count, y0, *self.ends):
            return np.zeros_like(y0), 0
        zeta, steps = y0, 0
        for _ in range(ROUNDS):
            for _ in range(SWEEPS):
                v = self.nearest(zeta)
                gap = y0 - v - self.G @ (y0 + zeta - 2 * v)
                zeta = zeta + RELAXATION * gap
            trial, count = self._newton(y0, zeta)
            steps += count
            lam = (trial - self.nearest(trial)) / self.sigma
            if max(self.errors(y0, lam)) <= GOOD:
                return lam, steps
        return None

    def errors(self, y0: Array, lam: Array, start: float = 0.0) -> ConicErrors:
        """The errors of multipliers (M,) for rows y0 (M,) of LQR, with the cost `start` of LQR."""
        z = -self.T.T @ lam
        y, scale = y0 + self.T @ z, 1 + np.abs(y0) + np.abs(self.T) @ np.abs(z)
        violation = np.abs(y - self.nearest(y)) / scale
        low, high = self.ends
        bound = np.where(lam > 0, high, np.where(lam < 0, low, 0.0))
        support, sign = lam * np.where(np.isfinite(bound), bound, 0.0), np.where(np.isfinite(bound), 0.0, np.abs(lam))
        stages, supports, signs = (part.reshape(self.problem.horizon, -1) for part in (lam, support, sign))
        for cone in self.cones:
            across = stages[:, list(cone.lateral)]
            size = np.linalg.norm(across, axis=1)
            signs[:, list(cone.rows)] = 0.0
            supports[:, list(cone.lateral)] = across * cone.centre
            if cone.axial is None:
                supports[:, cone.lateral[0]] += cone.offset * size
            else:
                along = stages[:, cone.axial]
                signs[:, cone.axial] = np.maximum(cone.slope * size + along, 0.0)
                supports[:, cone.axial] = -along * cone.offset / cone.slope
        size = start + float(z @ z) + float(np.abs(lam) @ np.abs(y0)) + np.finfo(float).tiny
        gap = abs(float(supports.sum()) - float(lam @ y)) / size
        largest = float(np.abs(lam).max(initial=0.0)) + np.finfo(float).tiny
        return ConicErrors(float(violation.max(initial=0.0)), float(signs.max(initial=0.0)) / largest, gap)

    def _newton(self, y0: Array, zeta: Array) -> tuple[Array, int]:
        """Steps of Newton's method: the zeta (M,) of the least residual, and the number of steps."""
        gap, worse = self._gap(y0, zeta), 0
        best = float(np.abs(gap).max()), zeta
        for step in range(STEPS):
            if best[0] <= DONE * (1 + np.abs(y0).max()) or worse > PATIENCE:
                return best[1], step
            U, extra = self._directions(zeta)
            w = U @ _solved(U.T @ (self.D @ U) + np.diag(extra), U.T @ gap)
            zeta = zeta + gap - self.D @ w + self.sigma * w
            gap = self._gap(y0, zeta)
            size = float(np.abs(gap).max())
            worse = 0 if size < best[0] else worse + 1
            best = (size, zeta) if size < best[0] else best
        return best[1], STEPS

    def _gap(self, y0: Array, zeta: Array) -> Array:
        v = self.nearest(zeta)
        return np.asarray(y0 - self.D @ ((zeta - v) / self.sigma) - v)

    def _directions(self, zeta: Array) -> tuple[Array, Array]:
        """U (M, k), and sigma (1 - mu) / mu (k,)."""
        low, high = self.ends
        columns, extra, nc = [], [], self.problem.rows.count
        for i in np.flatnonzero((zeta < low) | (zeta > high)):
            columns.append(([i], [1.0]))
            extra.append(0.0)
        for cone in self.cones:
            stages = zeta.reshape(-1, nc)
            for k in np.flatnonzero(cone.excess(stages) > 0):
                places = [k * nc + row for row in cone.rows]
                for direction, mu in cone_directions(cone, stages[k]):
                    columns.append((places, list(direction)))
                    extra.append(self.sigma[places[0]] * (1 - mu) / mu)
        U = np.zeros((len(zeta), len(columns)))
        for j, (places, values) in enumerate(columns):
            U[places, j] = values
        return U, np.array(extra)


def _solved(matrix: Array, right: Array) -> Array:
    """The solution of a positive definite system, or the least one where rows depend on each other."""
    try:
        return np.asarray(cho_solve(cho_factor(matrix), right))
    except LinAlgError:
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0])


def cone_directions(cone: StageCone, stage: Array) -> list[tuple[Array, float]]:
    """Eigenvectors of I - P over the rows of a cone with their eigenvalues mu above zero, at rows (nc,) of a stage."""
    across, size, radius = (np.asarray(part) for part in cone.split(stage))
    if not size > radius:
        return []
    m, slope = len(across), cone.slope
    share = float((size - radius) / ((1 + slope**2) * max(float(size), np.finfo(float).tiny)))
    if share >= 1:  # behind the apex, or so near to it that all rows act
        return [(unit, 1.0) for unit in np.eye(len(cone.rows))]
    n = across / size
    normal = n if cone.axial is None else np.r_[n, -slope] / np.sqrt(1 + slope**2)
    mirror = n + np.copysign(1.0, n[0]) * np.eye(m)[0]
    others = (np.eye(m) - np.outer(mirror, mirror) * (2 / float(mirror @ mirror)))[1:]  # an orthonormal basis across n
    tail = [] if cone.axial is None else [0.0]
    return [(normal, 1.0), *((np.r_[other, tail], share) for other in others)]


def conic_solver(problem: LinearMpc, D: Array, T: Array) -> ConicSolver:
    """The solver of a problem with D (M, M) and T (M, n) of its rows."""
    stage = np.diag(D).reshape(problem.horizon, -1).max(axis=0)
    stage = np.maximum(stage, np.finfo(float).tiny)
    for cone in problem.rows.cones:
        stage[list(cone.rows)] = stage[list(cone.rows)].max()
    sigma = np.tile(stage, problem.horizon)
    G = np.linalg.solve(np.eye(len(D)) + D / sigma, D / sigma)
    return ConicSolver(problem, D, T, sigma, G)
