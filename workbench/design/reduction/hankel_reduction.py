"""The optimal approximation in the Hankel norm, by all-pass errors.

With the balanced realisation split into the states of one Hankel value sigma and all others, Glover's formulas give a
system whose error is sigma times an all-pass system. Its stable part is the optimal model; its unstable part is
approximated by a constant in the same way, so that the H-infinity error is at most the sum of the values left out.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import DesignError
from workbench.design.reduction.balanced_realization import BalancedRealization
from workbench.design.reduction.balanced_reduction import twice_sum
from workbench.design.reduction.reduced_model import EQUAL, Matrices, ReducedModel, reduced_model


@check_arguments
def hankel_norm_reduction(system: System, order: int | None = None, tolerance: float | None = None) -> ReducedModel:
    """The model of an order with the least Hankel norm of the error, which is the first Hankel value that is left out.

    D is chosen so that the H-infinity error is at most the sum of the Hankel values that are left out, half the bound
    of `balanced_truncation`. A discrete system is taken to continuous time and back by the bilinear map, which
    keeps all norms. Arguments and refusals are those of `balanced_truncation`.

    References
    ----------
    Glover (1984), All optimal Hankel-norm approximations of linear multivariable systems and their L-infinity error
    bounds, International Journal of Control 39, theorems 6.3, 7.2 and 9.7.

    Examples
    --------
    >>> import control
    >>> lags = control.ss(control.tf([1.0], [1.0, 4.0, 6.0, 4.0, 1.0]))
    >>> answer = wb.reduction.hankel_norm_reduction(lags, 2)
    >>> round(answer.error.gain.value, 4), round(answer.bound, 4)
    (0.0386, 0.0402)
    """
    return reduced_model("hankel_norm_reduction", "optimal Hankel norm", system, order, tolerance, _approximate)


def _approximate(realization: BalancedRealization, order: int) -> tuple[Matrices, float]:
    matrices, values = (realization.A, realization.B, realization.C, realization.D), realization.values
    if order == len(values):
        return matrices, 0.0
    if realization.discrete:
        matrices = _to_continuous(*matrices)
    ny, nu = realization.D.shape
    reduced = _optimal_model(_square(*matrices), values, order)
    A, B, C, D = reduced
    reduced = A, B[:, :nu], C[:ny], D[:ny, :nu]
    return _to_discrete(*reduced) if realization.discrete else reduced, twice_sum(realization, order) / 2


def _square(A: Array, B: Array, C: Array, D: Array) -> Matrices:
    """The system with inputs or outputs of zeros added until it has as many of both."""
    ny, nu = D.shape
    m = max(ny, nu)
    B, C = np.pad(B, ((0, 0), (0, m - nu))), np.pad(C, ((0, m - ny), (0, 0)))
    return A, B, C, np.pad(D, ((0, m - ny), (0, m - nu)))


def _optimal_model(matrices: Matrices, values: Array, order: int) -> Matrices:
    (A, B, C, D), _ = _all_pass_step(matrices, values, order)
    stable, unstable = _split(A, B, C, order)
    return *stable, D + _constant(*unstable)


def _all_pass_step(matrices: Matrices, values: Array, place: int) -> tuple[Matrices, Array]:
    """The system whose error is values[place] times an all-pass one, and the values of its other states."""
    A, B, C, D = matrices
    sigma = float(values[place])
    equal = np.abs(values - sigma) <= EQUAL * sigma
    keep, s = ~equal, values[~equal]
    # U is orthogonal with B2 = -C2' U
    left, _, right = np.linalg.svd(C[:, equal] @ B[equal])
    U = -left @ right
    gamma = s**2 - sigma**2
    A1, B1, C1 = A[np.ix_(keep, keep)], B[keep], C[:, keep]
    inside = sigma**2 * A1.T + s[:, None] * A1 * s - sigma * C1.T @ U @ B1.T
    step = inside / gamma[:, None], (s[:, None] * B1 + sigma * C1.T @ U) / gamma[:, None], C1 * s + sigma * U @ B1.T
    return (*step, D - sigma * U), s


def _split(A: Array, B: Array, C: Array, order: int) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array]]:
    """The stable part, of an order, and the rest, by an ordered Schur form and Sylvester's equation."""
    if not len(A):
        return (A, B, C), (A, B, C)
    T, Z, count = linalg.schur(A, sort="lhp")
    if count != order:
        raise DesignError(
            f"`hankel_norm_reduction(system, order={order})`: rounding hides which modes of the all-pass extension are "
            "stable; take another order, or `balanced_truncation`."
        )
    k = order
    X = linalg.solve_sylvester(T[:k, :k], -T[k:, k:], -T[:k, k:])
    inputs, outputs = Z.T @ B, C @ Z
    stable = T[:k, :k], inputs[:k] - X @ inputs[k:], outputs[:, :k]
    return stable, (T[k:, k:], inputs[k:], outputs[:, :k] @ X + outputs[:, k:])


def _constant(A: Array, B: Array, C: Array) -> Array:
    """The constant whose distance from an antistable system is at most the sum of its Hankel values.

    The system, mirrored, is stable; one value after the other is taken off by an all-pass error.
    """
    m = B.shape[1]
    D = np.zeros((m, m))
    if not len(A):
        return D
    matrices, values = _balance(-A, B, -C)
    current: Matrices = (*matrices, D)
    while len(values):
        (A, B, C, D), values = _all_pass_step(current, values, len(values) - 1)
        if len(values):  # the Gramians are s / gamma and s gamma, which one more scaling makes equal
            matrices, values = _balance(A, B, C)
        current = (*matrices, D)
    return current[3]


def _balance(A: Array, B: Array, C: Array) -> tuple[tuple[Array, Array, Array], Array]:
    """A balanced realisation in doubles; modes below rounding are left out."""
    P = linalg.solve_continuous_lyapunov(A, -B @ B.T)
    Q = linalg.solve_continuous_lyapunov(A.T, -C.T @ C)
    X, Y = _root(np.asarray(P, dtype=float)), _root(np.asarray(Q, dtype=float))
    left, s, right = np.linalg.svd(Y.T @ X)
    k = int((s > 1e-12 * s[0]).sum()) if s[0] > 0 else 0
    to, out = X @ right[:k].T / np.sqrt(s[:k]), (Y @ left[:, :k] / np.sqrt(s[:k])).T
    return (out @ A @ to, out @ B, C @ to), s[:k]


def _root(P: Array) -> Array:
    values, vectors = np.linalg.eigh((P + P.T) / 2)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _to_continuous(A: Array, B: Array, C: Array, D: Array) -> Matrices:
    """The system with z = (1 + s) / (1 - s), which has the same Gramians."""
    shift, root = A + np.eye(len(A)), math.sqrt(2.0)
    inside, inputs = _solve(shift, A - np.eye(len(A))), _solve(shift, B)
    return inside, root * inputs, root * _solve(shift.T, C.T).T, D - C @ inputs


def _to_discrete(A: Array, B: Array, C: Array, D: Array) -> Matrices:
    shift, root = np.eye(len(A)) - A, math.sqrt(2.0)
    inside, inputs = _solve(shift, A + np.eye(len(A))), _solve(shift, B)
    return inside, root * inputs, root * _solve(shift.T, C.T).T, D + C @ inputs


def _solve(matrix: Array, right: Array) -> Array:
    return np.asarray(np.linalg.solve(matrix, right), dtype=float)
