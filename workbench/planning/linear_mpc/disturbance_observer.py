r"""Offset-free control: a constant disturbance estimated with the state, and the rest at which it is cancelled.

    x+ = A x + B u + Bd d,   d+ = d,   y = C x + Cd d,
    (x, d)  <-  (x, d) + L (y - C x - Cd d),

with L of the steady Kalman filter, and the target (x_s, u_s) of least u_s'R u_s with

    (A - I) x_s + B u_s = -Bd d,   C x_s = r - Cd d.

With as many disturbances as outputs, an observable augmented model and a law that is stable at the target, y = r in
every steady state, whatever constant disturbance acts on the plant (Pannocchia and Rawlings 2003, theorem 1; Maeder,
Borrelli and Morari 2009). The augmented model is observable exactly if (A, C) is and [A - I, Bd; C, Cd] has full rank.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.optimize import lsq_linear

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, positive
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError, matrix, semidefinite
from workbench.design.riccati import lqe
from workbench.planning.linear_mpc.array_doors import finite_vector
from workbench.planning.linear_mpc.linear_problem import LinearMpc

RANK = 1e-9  # of the largest singular value: below it a disturbance cannot be told from a state


@dataclass(frozen=True, eq=False)
@show
class OffsetFree:
    """The numbers of a disturbance observer and of a target selector.

    Parameters
    ----------
    A, B, C
        (nx, nx), (nx, nu) and (ny, nx).
    Bd, Cd
        (nx, nd) and (ny, nd).
    L
        (nx + nd, ny), the gain of the estimate after a reading.
    target
        (nx + nu, nd + nr), the map from (d, r) to (x_s, u_s).
    poles
        (nx + nd,), those of the observer's error.
    """

    A: Array
    B: Array
    C: Array
    Bd: Array
    Cd: Array
    L: Array
    target: Array
    poles: Array

    def correct(self, estimate: Numbers, y: Numbers) -> Array:
        """The estimate of (x, d), (nx + nd,), after a reading y (ny,)."""
        estimate = finite_vector("OffsetFree.correct(estimate=...)", estimate, len(self.L), "numbers of (x, d)")
        y = finite_vector("OffsetFree.correct(y=...)", y, len(self.C), "readings")
        return np.asarray(estimate + self.L @ (y - np.hstack([self.C, self.Cd]) @ estimate))

    def predict(self, estimate: Numbers, u: Numbers) -> Array:
        """The estimate a period after the input u (nu,)."""
        n, nu = self.B.shape
        estimate = finite_vector("OffsetFree.predict(estimate=...)", estimate, len(self.L), "numbers of (x, d)")
        u = finite_vector("OffsetFree.predict(u=...)", u, nu, "inputs")
        x, d = estimate[:n], estimate[n:]
        return np.concatenate([self.A @ x + self.B @ u + self.Bd @ d, d])

    def target_of(self, d: Numbers, r: Numbers) -> tuple[Array, Array]:
        """The target x_s (nx,), u_s (nu,) for a disturbance d (nd,) and a reference r (nr,)."""
        d = finite_vector("OffsetFree.target_of(d=...)", d, self.Bd.shape[1], "disturbances")
        references = self.target.shape[1] - self.Bd.shape[1]
        r = finite_vector("OffsetFree.target_of(r=...)", r, references, "references")
        both = self.target @ np.concatenate([d, r])
        return both[: len(self.A)], both[len(self.A) :]


@check_arguments
def offset_free(
    problem: LinearMpc,
    C: Numbers,
    *,
    Bd: Numbers | None = None,
    Cd: Numbers | None = None,
    process_noise: Numbers | None = None,
    disturbance_noise: float = 1e-2,
    reading_noise: float = 1e-4,
    follow: tuple[int, ...] | None = None,
) -> OffsetFree:
    """The observer and the target selector of a problem whose outputs C x follow a reference without offset.

    Parameters
    ----------
    C
        (ny, nx), of the outputs that are read.
    Bd, Cd
        (nx, ny) and (ny, ny), how the disturbances act. By default they act as the first ny inputs, or as all inputs
        and on some outputs; where that cannot be observed, on the outputs, or else on the rows of ny states.
    follow
        The places of the outputs that follow a reference (nr,); all by default. The target is then for these.
    process_noise
        (nx, nx), the covariance of a period's noise on the states; 1e-6 of the identity by default.
    disturbance_noise, reading_noise
        Variances of a period's change of a disturbance, and of a reading; only their ratios matter.

    Raises
    ------
    ValueError
        If a matrix has the wrong shape, or the numbers of disturbances and outputs differ.
    DesignError
        If a disturbance cannot be told from the states, or no input holds the outputs at a reference.

    Examples
    --------
    >>> from workbench.planning.linear_mpc import MpcLimits, mpc_problem, offset_free
    >>> problem = mpc_problem([[0.9]], [[0.1]], [[1.0]], [[0.1]], 10, MpcLimits(inputs=(-5.0, 5.0)))
    >>> x, u = offset_free(problem, [[1.0]]).target_of(np.array([0.5]), np.array([1.0]))
    >>> x, u  # 1 = 0.9 + 0.1 (u + 0.5)
    (array([1.]), array([0.5]))
    """
    nx = len(problem.A)
    c = matrix("offset_free(C=...)", "C", C, columns=nx)
    ny = len(c)
    bd, cd = _disturbances(problem, c, Bd, Cd)
    _refuse_hidden(problem.A, bd, c, cd)
    noise = 1e-6 * np.eye(nx) if process_noise is None else process_noise
    q = semidefinite("offset_free(process_noise=...)", "process_noise", noise, nx)
    variances = (
        positive("offset_free(disturbance_noise=...)", disturbance_noise),
        positive("offset_free(reading_noise=...)", reading_noise),
    )
    L, poles = _filter(problem, bd, np.hstack([c, cd]), q, variances)
    rows = list(range(ny) if follow is None else follow)
    return OffsetFree(problem.A, problem.B, c, bd, cd, L, _target(problem, bd, c[rows], cd[rows]), poles)


@check_arguments
def limited_target(offset: OffsetFree, problem: LinearMpc, d: Numbers, r: Numbers) -> tuple[Array, Array]:
    """The target whose outputs are nearest to r (ny,) among those whose inputs keep their limits.

    It is the target of `offset` where that keeps its limits. Otherwise the reference cannot be held, and the rest of
    least distance is returned, from a bounded least squares problem.
    """
    x, u = offset.target_of(d, r)
    d, r = np.asarray(d, dtype=float), np.asarray(r, dtype=float)
    nu = problem.B.shape[1]
    low, high = problem.rows.low[:nu], problem.rows.high[:nu]
    if (u >= low).all() and (u <= high).all():
        return x, u
    n = len(x)
    solve = np.linalg.lstsq(np.eye(n) - problem.A, np.hstack([problem.B, (offset.Bd @ d)[:, None]]), rcond=None)[0]
    gain, base = offset.C @ solve[:, :nu], offset.C @ solve[:, nu] + offset.Cd @ d
    u = np.asarray(lsq_linear(gain, r - base, (low, high)).x)
    return solve[:, :nu] @ u + solve[:, nu], u


def _filter(
    problem: LinearMpc, Bd: Array, seen: Array, q: Array, variances: tuple[float, float]
) -> tuple[Array, Array]:
    """The gain of the steady Kalman filter after a reading, and the poles of its error."""
    nx, nd = Bd.shape
    wide = np.zeros((nx + nd, nx + nd))
    wide[:nx, :nx] = q
    wide[nx:, nx:] = variances[0] * np.eye(nd)
    grown, v = np.block([[problem.A, Bd], [np.zeros((nd, nx)), np.eye(nd)]]), variances[1] * np.eye(len(seen))
    X = lqe(grown, np.eye(nx + nd), seen, wide, v, discrete=True).X
    # of the filter: K of the predictor is A L
    L = np.asarray(np.linalg.solve(seen @ X @ seen.T + v, seen @ X).T, dtype=float)
    return L, np.linalg.eigvals(grown - grown @ L @ seen)


def _target(problem: LinearMpc, Bd: Array, C: Array, Cd: Array) -> Array:
    """The map from (d, r) to the target of least u'R u."""
    nx, nu = problem.B.shape
    ny, nd = len(C), Bd.shape[1]
    system = np.block([[problem.A - np.eye(nx), problem.B], [C, np.zeros((ny, nu))]])
    right = np.block([[-Bd, np.zeros((nx, ny))], [-Cd.reshape(ny, nd), np.eye(ny)]])
    any_answer, _, rank, sizes = np.linalg.lstsq(system, right, rcond=RANK)
    if np.abs(system @ any_answer - right).max() > 1e-9 * max(1.0, float(np.abs(right).max()), float(sizes[0])):
        raise DesignError(
            f"`offset_free(C)`: {nu} inputs cannot hold {ny} outputs at any reference, as the matrix [A - I, B; C, 0] "
            "has no solution for it. Leave out an output, or add an input."
        )
    free = np.linalg.svd(system)[2][rank:].T  # directions that change neither rest nor outputs
    if free.shape[1] == 0:
        return np.asarray(any_answer)
    weight = np.linalg.cholesky(problem.R).T @ free[nx:]
    along = np.linalg.lstsq(weight, -np.linalg.cholesky(problem.R).T @ any_answer[nx:], rcond=None)[0]
    return np.asarray(any_answer + free @ along)


def _disturbances(problem: LinearMpc, C: Array, Bd: Numbers | None, Cd: Numbers | None) -> tuple[Array, Array]:
    """Bd and Cd as they came, or the first of the usual ones that can be observed."""
    (nx, nu), ny = problem.B.shape, len(C)
    if Bd is None and Cd is None:
        usual = [(problem.B[:, :ny], np.zeros((ny, ny)))] if nu >= ny else []
        for rows in combinations(range(ny), ny - nu) if nu < ny else ():  # all inputs, and some outputs
            both = np.hstack([problem.B, np.zeros((nx, ny - nu))]), np.hstack([np.zeros((ny, nu)), np.eye(ny)[:, rows]])
            usual.append(both)
        usual.append((np.zeros((nx, ny)), np.eye(ny)))
        usual += [(np.eye(nx)[:, i : i + ny], np.zeros((ny, ny))) for i in range(nx - ny + 1)]
        visible = [pair for pair in usual if _least_share(problem.A, C, *pair) > RANK]
        return visible[0] if visible else usual[0]
    bd = np.zeros((nx, ny)) if Bd is None else matrix("offset_free(Bd=...)", "Bd", Bd, nx)
    cd = np.zeros((ny, bd.shape[1])) if Cd is None else matrix("offset_free(Cd=...)", "Cd", Cd, ny, bd.shape[1])
    if bd.shape[1] != ny:
        raise ValueError(
            f"`offset_free(Bd=...)` must have as many disturbances as there are outputs, {ny}, as fewer leave an offset"
            f" and more cannot be observed; got {bd.shape[1]}."
        )
    return bd, cd


def _least_share(A: Array, C: Array, Bd: Array, Cd: Array) -> float:
    """The least singular value of [A - I, Bd; C, Cd] over the largest."""
    sizes = np.linalg.svd(np.block([[A - np.eye(len(A)), Bd], [C, Cd]]), compute_uv=False)
    return float(sizes[-1] / sizes[0])


def _refuse_hidden(A: Array, Bd: Array, C: Array, Cd: Array) -> None:
    if _least_share(A, C, Bd, Cd) < RANK:
        raise DesignError(
            "`offset_free(Bd=..., Cd=...)`: a constant disturbance cannot be told from the states, as [A - I, Bd; C, "
            "Cd] is singular. Let it act elsewhere: an integrator hides a disturbance of its output."
        )
