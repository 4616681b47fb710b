r"""The product D lambda by one pass backward and one forward over the stages, for long horizons and few states.

    p_N = 0,      d_k = S^-1 (B'p_{k+1} + E'lambda_k),     p_k = (A - B K)'p_{k+1} + (F - E K)'lambda_k
    x_0 = 0,      y_k = (F - E K) x_k + E d_k,             x_{k+1} = (A - B K) x_k + B d_k

give y = D lambda. Where P is the cost of the LQR law, K and S are the same at all stages: the cached Riccati recursion
of TinyMPC, but without a penalty in it. References: Nguyen et al. (2024), TinyMPC, ICRA, section III.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.planning.linear_mpc.array_doors import finite_batch, finite_vector
from workbench.planning.linear_mpc.linear_problem import LinearMpc
from workbench.planning.linear_mpc.splitting import ADMM, SplittingNumbers

MOST_ROWS = 64  # of a law with the dense matrix, whose numbers take 32 KB then


@dataclass(frozen=True, eq=False)
@show
class RecursionNumbers:
    """The constants of the passes: A - B K, B, F - E K, E and S^-1, and the softness of the rows of a stage."""

    loop: Array
    B: Array
    rows: Array
    E: Array
    inverse: Array
    softness: Array
    horizon: int


@check_arguments
def recursion_numbers(problem: LinearMpc) -> RecursionNumbers:
    """The constants of the passes for a problem whose P is the cost of its LQR law.

    Raises
    ------
    ValueError
        If P was given, as the gains then change from stage to stage.
    """
    if problem.K is None:
        raise ValueError(
            "`recursion_numbers(problem)` needs one gain for all stages, which the cost of the LQR law as P gives; "
            "this problem has a P of its own. Leave P out of `mpc_problem`, or use the dense matrix D."
        )
    A, B, rows = problem.A, problem.B, problem.rows
    S = problem.R + B.T @ problem.P @ B
    loop, outputs = A - B @ problem.K, rows.F - rows.E @ problem.K
    inverse = np.asarray(np.linalg.inv((S + S.T) / 2), dtype=float)
    return RecursionNumbers(loop, B, outputs, rows.E, inverse, rows.softness, problem.horizon)


@check_arguments
def dual_product(numbers: RecursionNumbers, multipliers: Numbers) -> Array:
    """D lambda (..., M), with the softness of soft rows, by the two passes."""
    M = numbers.horizon * len(numbers.rows)
    multipliers = finite_batch("dual_product(multipliers=...)", multipliers, M, "multipliers")
    lam = multipliers.reshape(*multipliers.shape[:-1], numbers.horizon, -1)
    p = np.zeros((*multipliers.shape[:-1], len(numbers.loop)))
    moves = []
    for k in reversed(range(numbers.horizon)):
        moves.append((p @ numbers.B + lam[..., k, :] @ numbers.E) @ numbers.inverse.T)
        p = p @ numbers.loop + lam[..., k, :] @ numbers.rows
    x, y = np.zeros_like(p), []
    for k in range(numbers.horizon):
        d = moves[numbers.horizon - 1 - k]
        y.append(x @ numbers.rows.T + d @ numbers.E.T + lam[..., k, :] * numbers.softness)
        x = x @ numbers.loop.T + d @ numbers.B.T
    return np.stack(y, axis=-2).reshape(multipliers.shape)


@check_arguments
def tracking_gains(problem: LinearMpc, sigma: Numbers) -> tuple[Array, Array]:
    """The gains (N nu, nx) and inverse weights (N nu, nu) of the two passes of ADMM with penalties 1 / sigma (nc,).

    Its plan about the LQR law is the least sum d'S d + (rows - wanted)^2 / (sigma + softness), with d = -K_k x + ...
    """
    own = recursion_numbers(problem)
    sizes = finite_vector("tracking_gains(sigma=...)", sigma, len(own.rows), "penalties")
    weighted = 1 / (sizes + own.softness)
    S, P, parts = np.linalg.inv(own.inverse), np.zeros_like(own.loop), []
    for _ in range(own.horizon):
        H = S + (own.E.T * weighted) @ own.E + own.B.T @ P @ own.B
        inverse = np.linalg.inv((H + H.T) / 2)
        gain = inverse @ ((own.E.T * weighted) @ own.rows + own.B.T @ P @ own.loop)
        loop, rows = own.loop - own.B @ gain, own.rows - own.E @ gain
        P = loop.T @ P @ loop + gain.T @ S @ gain + (rows.T * weighted) @ rows
        P = (P + P.T) / 2
        parts.append((gain, inverse))
    return np.vstack([part[0] for part in parts[::-1]]), np.vstack([part[1] for part in parts[::-1]])


@dataclass(frozen=True)
@show
class OperationCount:
    """Multiplications with one addition each, divisions, and comparisons or selections of a sweep, and of a period.

    `dense` and `recursion` are the multiply-adds of D lambda in both forms; `sweep` has the smaller of them.
    """

    dense: int
    recursion: int
    metric: int
    sweep: int
    period: int
    divisions: int
    selections: int
    memory: int


@check_arguments
def operation_count(numbers: SplittingNumbers) -> OperationCount:
    """The exact operations of the law: each entry of a matrix that is no unit row counts, zeros of E and F do not."""
    M, nx = numbers.Y.shape
    nu, r, nc = numbers.B.shape[1], len(numbers.L), numbers.rows_of_stage
    N = M // nc
    dense = M * M
    other = nc - nu  # rows beyond the inputs, whose E is the identity
    stage = 2 * nx * nx + 2 * nx * nu + 2 * nx * nc + 2 * other * nu + nu * nu
    small = sum(j * (j + 1) // 2 for j in range(r)) + r * (r - 1)  # factors, then two triangular solutions
    metric = M * (2 * r + r * (r + 1) // 2) + small
    stage += 2 * nx * nu if numbers.method == ADMM else 0  # the gains of its stages, twice
    product = min(dense, N * stage)
    sweep = product + metric + 4 * M
    period = numbers.sweeps * sweep + 2 * M * nx + nx * (nx + nu)
    return OperationCount(
        dense, N * stage, metric, sweep, period, numbers.sweeps * (2 * r + 1), numbers.sweeps * 5 * M, M
    )


def columns_of_sweep(numbers: SplittingNumbers) -> Array | None:
    """D diag(sigma)^-1 - I (M, M), of which a sweep takes the columns of rows that act; None if the passes are cheaper.

    It is None for ADMM, too, and beyond `MOST_ROWS` rows.
    """
    count, M = operation_count(numbers), len(numbers.sigma)
    if numbers.method == ADMM or M > MOST_ROWS or count.dense > count.recursion:
        return None
    return np.asarray(numbers.matrix / numbers.sigma - np.eye(M))
