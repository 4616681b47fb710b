r"""The exact solution of a problem outside the graph: sweeps, then a polish of the active set, and a certificate.

In the coordinates of `prediction_maps` the problem is the least distance problem min |z|^2, low <= Y x + T z <= high.
After a fixed number of sweeps the rows with multipliers are taken as active and solved as equalities, by orthogonal
factors of their rows. Rows that are violated enter, rows whose multiplier pulls leave, until none does. Where this
cycles, Lawson and Hanson's method decides: it ends, with a solution or with a Farkas vector. Either answer is returned
only with its certificate. `conic_solution` takes the place of both methods where limits are cones.

References: Lawson and Hanson (1974), Solving Least Squares Problems, chapter 23; Hintermueller, Ito and Kunisch (2002),
The primal-dual active set strategy as a semismooth Newton method, SIAM J. Optim. 13.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import qr, solve_triangular
from scipy.optimize import nnls

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError
from workbench.planning.linear_mpc.array_doors import finite_vector
from workbench.planning.linear_mpc.conic_solution import ConicSolver, conic_solver
from workbench.planning.linear_mpc.infeasibility import InfeasibilityProof, MpcConflictError, farkas_margin
from workbench.planning.linear_mpc.linear_problem import LinearMpc
from workbench.planning.linear_mpc.prediction_maps import PredictionMaps, prediction_maps
from workbench.planning.linear_mpc.splitting import SplittingNumbers, no_memory, sweep
from workbench.planning.linear_mpc.splitting_metric import splitting_numbers

SWEEPS = 25
NEAR = 1e-2  # spans, of the residual: the polish does the rest
MOST_CHANGES = 40  # of the active set
TOLERANCE = 1e-8  # of a certificate, relative: half the digits, as an active row is found by them
ROUNDING = 1e-13  # of the largest row or value: what is smaller is none
DEPENDENT = 1e-11  # a row within this share of the others' span is no row of its own


@dataclass(frozen=True)
@show
class KktCertificate:
    """The errors of a solution in its conditions, each relative to the terms of its row or sum.

    `violation` is the largest excess of a row over its bound, `sign` the largest multiplier of a wrong sign, `gap` the
    difference of primal and dual cost. Of a cone, `violation` is the distance from it, and `sign` that of the
    multipliers from its polar cone, as a share of the largest.
    """

    violation: float
    sign: float
    gap: float

    @property
    def is_passed(self) -> bool:
        """True if all figures are below 1e-8."""
        return max(self.violation, self.sign, self.gap) <= TOLERANCE


@dataclass(frozen=True, eq=False)
@show
class MpcSolution:
    """The optimum from a state: inputs u (N, nu), the objective, and the multipliers (N, nc) of half the objective.

    `active_limits` are names and stages of the rows with multipliers, and `polish_steps` the changes of the active set
    that followed the sweeps.
    """

    u: Array
    objective: float
    multipliers: Array
    active_limits: tuple[tuple[str, int], ...]
    certificate: KktCertificate
    polish_steps: int


@dataclass(frozen=True, eq=False)
@show
class ExactMpc:
    """The exact law of a problem; `solve` finds the optimum from a state."""

    problem: LinearMpc
    maps: PredictionMaps
    numbers: SplittingNumbers

    @cached_property
    def T(self) -> Array:
        """(M, N nu + soft rows), the map of z to the rows, with a column for each soft row's violation."""
        soft = np.tile(self.problem.rows.softness, self.problem.horizon)
        return np.hstack([self.maps.unit_rows, np.diag(np.sqrt(soft))[:, soft > 0]])

    @cached_property
    def conic(self) -> ConicSolver:
        """The solver of a problem with cones."""
        return conic_solver(self.problem, self.numbers.matrix, self.T)

    @check_arguments
    def solve(self, x: Numbers) -> MpcSolution:
        """The optimum from x (nx,).

        Raises
        ------
        MpcConflictError
            If no input keeps the limits from x, with the limits at fault and the proof.
        DesignError
            If neither a solution nor a conflict can be certified: at the very edge between them, or where an unstable
            plant runs away whatever its inputs do.
        """
        state = finite_vector("ExactMpc.solve(x=...)", x, len(self.problem.A), "states")
        y = self.maps.Y @ state
        if self.problem.rows.cones:
            answer = self.conic.multipliers(y)
            if answer is None:  # the limits without cones may conflict already
                raise self._refusal(state, _lawson_hanson(self.T, y, self.problem.low, self.problem.high)[1])
            return self._solution(state, y, *answer)
        zeta = no_memory(self.numbers) + y
        acts = ((y < self.problem.low) | (y > self.problem.high)).any()
        for _ in range(SWEEPS if acts else 0):  # without them the LQR answer is the optimum
            zeta, residual = sweep(self.numbers, y, zeta)
            if residual <= NEAR:
                break
        sides = np.where(zeta > self.problem.high, 1, 0) - np.where(zeta < self.problem.low, 1, 0)
        polished = _polish(self, y, sides)
        if polished is None:
            signs, weights = _lawson_hanson(self.T, y, self.problem.low, self.problem.high)
            polished = None if signs is None else _polish(self, y, signs)
            if polished is None:
                raise self._refusal(state, weights)
        return self._solution(state, y, *polished)

    @check_arguments
    def first_move(self, x: Numbers) -> Array:
        """The first input (nu,) of the optimum from x (nx,)."""
        return np.asarray(self.solve(x).u[0])

    def _solution(self, x: Array, y: Array, lam: Array, steps: int) -> MpcSolution:
        problem, maps = self.problem, self.maps
        z = -self.T.T @ lam
        inputs = maps.V @ x + maps.G @ solve_triangular(maps.roots, z[: maps.G.shape[1]])
        start = float(x @ maps.P0 @ x)
        names = problem.rows.names
        active = dict.fromkeys((names[i % len(names)], int(i) // len(names)) for i in np.flatnonzero(lam))
        if problem.rows.cones:
            certificate = KktCertificate(*self.conic.errors(y, lam, start))
        else:
            certificate = certify(self, y, lam, start)
        return MpcSolution(
            inputs.reshape(problem.horizon, -1),
            start + float(z @ z),
            lam.reshape(problem.horizon, -1),
            tuple(active),
            certificate,
            steps,
        )

    def _refusal(self, x: Array, weights: Array) -> ValueError:
        margin, is_proved = farkas_margin(self.problem, x, weights.reshape(self.problem.horizon, -1))
        if not margin > 0:
            return DesignError(
                "`ExactMpc.solve(x)`: neither an optimum nor a conflict of the limits can be certified from this state;"
                " it lies within rounding of the edge between them, or no input stops the plant from running away. Move"
                " it, or make limits on states soft."
            )
        proof = InfeasibilityProof((), weights.reshape(self.problem.horizon, -1), margin, is_proved)
        proof = replace(proof, limits=_conflict(self, x))
        return MpcConflictError(
            f"`ExactMpc.solve(x)`: no input keeps the limits on {', '.join(dict.fromkeys(proof.limits))} from this "
            "state. Widen one of them, or make limits on states soft by soft_weight.",
            proof,
        )


@check_arguments
def exact_mpc(problem: LinearMpc) -> ExactMpc:
    """The exact solver of a problem, prepared once for many states.

    Examples
    --------
    >>> from workbench.planning.linear_mpc import MpcLimits, exact_mpc, mpc_problem
    >>> limits = MpcLimits(inputs=(-1.0, 1.0))
    >>> problem = mpc_problem([[1.0, 0.1], [0.0, 1.0]], [[0.0], [0.1]], np.eye(2), [[0.1]], 20, limits)
    >>> answer = exact_mpc(problem).solve([3.0, 0.0])
    >>> answer.u[0].round(9), answer.certificate.is_passed
    (array([-1.]), True)
    """
    return ExactMpc(problem, prediction_maps(problem), splitting_numbers(problem))


def certify(exact: ExactMpc, y0: Array, lam: Array, start: float = 0.0) -> KktCertificate:
    """The certificate of multipliers (M,) for the rows y0 (M,) of the LQR law with the cost `start`."""
    problem = exact.problem
    z = -exact.T.T @ lam
    y, scale = y0 + exact.T @ z, 1 + np.abs(y0) + np.abs(exact.T) @ np.abs(z)
    violation = np.maximum(y - problem.high, problem.low - y) / scale
    bound = np.where(lam > 0, problem.high, problem.low)
    used = lam != 0
    gaps = lam[used] * (bound[used] - y[used])  # complementarity: a multiplier only where y meets its bound
    size = start + float(z @ z) + float(np.abs(lam) @ np.abs(y0)) + np.finfo(float).tiny
    wrong = np.where(used & ~np.isfinite(bound), np.abs(lam), 0.0).max(initial=0.0)
    return KktCertificate(float(max(violation.max(), 0.0)), float(wrong), float(np.abs(gaps).sum() / size))


def _polish(exact: ExactMpc, y0: Array, sides: Array) -> tuple[Array, int] | None:
    """Multipliers (M,) of the optimum and the changes of the active set, or None where these do not end."""
    problem = exact.problem
    sides = np.where(np.isfinite(np.where(sides > 0, problem.high, problem.low)), sides, 0)
    for step in range(MOST_CHANGES):
        lam = _equalities(exact, y0, sides)
        if lam is None:
            return None
        if certify(exact, y0, lam).is_passed and not (lam * sides < 0).any():
            return lam, step
        y = y0 - exact.T @ (exact.T.T @ lam)
        slack = TOLERANCE / 100 * (1 + np.abs(y0))
        stays = np.where(lam * sides > 0, sides, 0)
        sides = np.where(y > problem.high + slack, 1, np.where(y < problem.low - slack, -1, stays))
    return None


def _equalities(exact: ExactMpc, y0: Array, sides: Array) -> Array | None:
    """The multipliers that hold the rows of `sides` at their bounds, or None if these rows depend on each other."""
    active = np.flatnonzero(sides)
    lam = np.zeros_like(y0)
    if len(active) == 0:
        return lam
    rows = exact.T[active]
    if len(active) > rows.shape[1]:
        return None
    sizes = np.linalg.norm(rows, axis=1)
    if sizes.min() <= ROUNDING * np.linalg.norm(exact.T, axis=1).max():  # a row that no input moves
        return None
    R = qr((rows / sizes[:, None]).T, mode="r")[0][: len(active)]
    if np.abs(np.diag(R)).min() < DEPENDENT:
        return None
    bound = np.where(sides > 0, exact.problem.high, exact.problem.low)[active]
    for _ in range(2):  # the second time on what is left: iterative refinement
        gap = y0[active] + rows @ -(exact.T.T @ lam) - bound
        lam[active] += solve_triangular(R, solve_triangular(R, gap / sizes, trans="T")) / sizes
    return lam


def _lawson_hanson(T: Array, y0: Array, low: Array, high: Array) -> tuple[Array | None, Array]:
    """The sides (M,) of the optimum, or None, and multipliers (M,): of the optimum or a Farkas vector."""
    upper, lower = np.flatnonzero(np.isfinite(high)), np.flatnonzero(np.isfinite(low))
    G = np.vstack([-T[upper], T[lower]])
    h = np.r_[y0[upper] - high[upper], low[lower] - y0[lower]]
    if len(h) == 0:
        return np.zeros(len(y0), dtype=int), np.zeros(len(y0))
    sizes = np.linalg.norm(G, axis=1)
    fixed = sizes <= ROUNDING * sizes.max(initial=0.0)  # rows that no input moves
    worst = int(np.argmax(np.where(fixed, h, -np.inf)))
    if fixed[worst] and h[worst] > ROUNDING * np.abs(y0).max():
        lam = np.zeros(len(y0))
        lam[np.r_[upper, lower][worst]] = 1.0 if worst < len(upper) else -1.0
        return None, lam
    h, sizes = np.where(fixed, -1.0, h), np.where(fixed, 1.0, sizes)
    reach = max(float(np.abs(h / sizes).max()), np.finfo(float).tiny)
    system = np.vstack([(G / sizes[:, None]).T, h / sizes / reach])
    weights, distance = nnls(system, np.r_[np.zeros(T.shape[1]), 1.0], maxiter=50 * len(h))
    lam = np.zeros(len(y0))
    np.add.at(lam, upper, weights[: len(upper)] / sizes[: len(upper)])
    np.add.at(lam, lower, -weights[len(upper) :] / sizes[len(upper) :])
    return (None if distance < TOLERANCE else np.sign(lam).astype(int)), lam


def _conflict(exact: ExactMpc, x: Array) -> tuple[str, ...]:
    """Limits that conflict, none of which can be left out; those of inputs stay rather than others."""
    names, nu = exact.problem.rows.names, exact.problem.B.shape[1]
    low, high, y0 = exact.problem.low.copy(), exact.problem.high.copy(), exact.maps.Y @ x
    needed = []
    for i in (*range(nu, len(names)), *range(nu)):
        rows = slice(i, None, len(names))
        kept = low[rows].copy(), high[rows].copy()
        if not (np.isfinite(kept[0]).any() or np.isfinite(kept[1]).any()):
            continue
        low[rows], high[rows] = -np.inf, np.inf
        if _lawson_hanson(exact.T, y0, low, high)[0] is not None:
            low[rows], high[rows] = kept
            needed.append(i)
    return tuple(names[i] for i in sorted(needed))
