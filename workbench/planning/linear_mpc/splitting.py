r"""The law's solver: a fixed number of sweeps of a splitting of the dual problem, in a metric of diagonal and low rank.

The multipliers lambda of half the cost minimise half lambda'D lambda - lambda'y0 + (support function of the box), where
y0 = Y x are the rows of the LQR law and y = y0 - D lambda (`prediction_maps`). One vector zeta holds both splits,

    v = clip(zeta, low, high),    lambda = (zeta - v) / sigma,    residual = y0 - D lambda - v,

and residual = 0 is the optimum: then v = y lies in the box, and lambda pushes where y touches it. Where no limit acts
lambda is 0 and v is the LQR answer itself. A sweep is a Newton step in which D is replaced by the metric
M = diag(sigma) + W L W', so that only a matrix of r rows is factorised:

    a      = 1 where zeta is outside the box, else 0
    t      = (L^-1 + W' diag(a / sigma) W)^-1  W' diag(a / sigma) residual
    change = residual - W t
    beyond = how far zeta + change lies beyond a bound that zeta had not passed, in spans high - low
    zeta  <- zeta + change min(1, cap / max beyond)

Without W it is the dual proximal gradient method (forward-backward splitting). The kept modes are those of D far from
sigma: D is R^-1 but for the few modes in which the plant answers slowly, and these decide how fast ADMM converges.
L^-1 + W' diag(a / sigma) W is quasidefinite for every a, so that its L D L' factors exist without pivoting (Vanderbei
1995). A row inside its box has lambda = 0 and a = 0: a machine may leave out its column of D and its terms of the small
matrix, and changes no bit. Between two periods the memory is zeta of the next stages less the LQR answer at the
predicted state, (N nc,).

ADMM is another preconditioner of the same residual on the same vector zeta, with penalties 1 / sigma and the
over-relaxation alpha,

    zeta  <- zeta + alpha (y - v),   y = y0 + G (2 v - zeta - y0),   G = (I + D / sigma)^-1 D / sigma,
    y - v  = (I + D / sigma)^-1 residual,

which treats all rows as active. It needs more sweeps where few limits act, and fewer where nearly all of them do.

References
----------
Robinson (1992), Normal maps induced by linear transformations, Math. Oper. Res. 17: zeta and its residual.
Becker and Fadili (2012), A quasi-Newton proximal splitting method, NIPS: metrics of diagonal and low rank.
Vanderbei (1995), Symmetric quasidefinite matrices, SIAM J. Optim. 5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, whole
from workbench.core.validation.signatures import check_arguments
from workbench.planning.linear_mpc.array_doors import finite_batch
from workbench.planning.linear_mpc.cone_limits import StageCone, is_beyond, keep_inputs, nearest

METRIC, ADMM = METHODS = ("metric", "admm")


@dataclass(frozen=True, eq=False)
@show
class SplittingNumbers:
    """All constants of the solver; rows are stage by stage, the nu inputs of a stage first.

    Parameters
    ----------
    A, B
        (nx, nx) and (nx, nu), the model that predicts the next state.
    F, E
        (nc, nx) and (nc, nu), the rows of a stage.
    Y
        (M, nx) with M = N nc, the rows of the LQR law.
    method, matrix
        "metric", with D (M, M), which has 1 / w of soft rows on its diagonal; or "admm", with G (M, M).
    low, high
        (M,), the bounds.
    sigma
        (M,), the diagonal of the metric: reciprocal penalties.
    W, L
        (M, r) and (r,), the kept modes; none for ADMM.
    sweeps
        The number of sweeps of a period.
    cap
        How far a sweep may pass a bound, in spans high - low; one-sided and free rows do not count. For ADMM, alpha.
    contraction
        The largest |1 - eigenvalue of M^-1 D| over the modes of D that are not zero: the factor by which a sweep
        reduces the error once its active rows are right; NaN for ADMM.
    is_proved
        True if D is regular, so that this factor holds for every active set (`splitting_metric`).
    rates
        True if the last nu rows limit the changes of the inputs, and the last nu states are the inputs before.
    cones
        The cones among the rows of a stage, for ADMM alone: v is then the nearest point within box and cones.
    """

    A: Array
    B: Array
    F: Array
    E: Array
    Y: Array
    method: str
    matrix: Array
    low: Array
    high: Array
    sigma: Array
    W: Array
    L: Array
    sweeps: int
    cap: float
    contraction: float
    is_proved: bool
    rates: bool = False
    cones: tuple[StageCone, ...] = ()

    @property
    def rows_of_stage(self) -> int:
        """The number nc of rows of a stage."""
        return len(self.F)

    @property
    def inverse_span(self) -> Array:
        """(M,), 1 / (high - low); 0 where a bound is infinite."""
        return np.asarray(1 / (self.high - self.low))


class SplittingAnswer(NamedTuple):
    """The first input (..., nu), the memory (..., M), and the residual (...,) before the last sweep, in spans."""

    u: Array
    memory: Array
    residual: Array

    def __repr__(self) -> str:
        worst = float(np.max(self.residual, initial=0.0))
        return f"<SplittingAnswer: an input of shape {np.shape(self.u)}, residual up to {worst:.2g}>"


@check_arguments
def no_memory(numbers: SplittingNumbers, batch: int | None = None) -> Array:
    """The memory of a cold start, which is the LQR answer: zeros (M,), or (batch, M)."""
    M = len(numbers.low)
    return np.zeros(M if batch is None else (whole("no_memory(batch=...)", batch, most=10**6), M))


@check_arguments
def solve_period(
    numbers: SplittingNumbers,
    memory: Numbers,
    x: Numbers,
    target: tuple[Array, Array] | None = None,
    sweeps: int | None = None,
) -> SplittingAnswer:
    """The law's answer at a state x (..., nx), from the memory of the period before, about a target or zero.

    The target is a state (..., nx) and an input (..., nu) at which the model rests; x and the bounds stay absolute.

    Raises
    ------
    ValueError
        If an argument is no finite number of its shape, or the numbers are those of a metric for a problem with cones.
    """
    if numbers.cones and numbers.method != ADMM:
        raise ValueError(
            "`solve_period(numbers, ...)` needs the numbers of ADMM for limits that are cones, as a metric knows boxes "
            "alone. Take those of `predictive_design(cones=...)` or `tune_splitting`."
        )
    x = finite_batch("solve_period(x=...)", x, len(numbers.A), "states")
    memory = finite_batch("solve_period(memory=...)", memory, len(numbers.low), "numbers")
    count = numbers.sweeps if sweeps is None else whole("solve_period(sweeps=...)", sweeps, 0)
    rest, at, push = np.zeros(len(numbers.low)), np.zeros(x.shape[-1]), np.zeros(numbers.B.shape[1])
    if target is not None:
        at = finite_batch("solve_period(target=...)", target[0], len(numbers.A), "states")
        push = finite_batch("solve_period(target=...)", target[1], numbers.B.shape[1], "inputs")
        stage = at @ numbers.F.T + push @ numbers.E.T
        rest = np.concatenate([stage] * (len(numbers.low) // numbers.rows_of_stage), axis=-1)
    lqr = (x - at) @ numbers.Y.T + rest
    zeta, residual = memory + lqr, np.zeros(lqr.shape[:-1])
    is_outside = is_beyond(numbers.cones, numbers.rows_of_stage, lqr, numbers.low, numbers.high)
    zeta = np.where(is_outside[..., None], zeta, lqr)  # within all limits the LQR answer is the optimum
    for _ in range(count):
        zeta, residual = sweep(numbers, lqr, zeta)
    nu = numbers.B.shape[1]
    u = np.clip(zeta[..., :nu], numbers.low[:nu], numbers.high[:nu])
    u = keep_inputs(numbers.cones, u, numbers.low[:nu], numbers.high[:nu])
    if numbers.rates:
        u = np.clip(u, x[..., -nu:] + numbers.low[-nu:], x[..., -nu:] + numbers.high[-nu:])
    after = (x - at) @ numbers.A.T + (u - push) @ numbers.B.T
    following = shift(zeta, numbers.rows_of_stage) - after @ numbers.Y.T - rest
    return SplittingAnswer(u, np.where(is_outside[..., None], following, 0.0), residual)


def sweep(numbers: SplittingNumbers, lqr: Array, zeta: Array) -> tuple[Array, Array]:
    """One sweep: the next zeta (..., M), and the residual (...,) of the zeta that came, in spans."""
    v = nearest(numbers.cones, numbers.rows_of_stage, zeta, numbers.low, numbers.high)
    if numbers.method == ADMM:
        gap = lqr - v - (lqr - v + zeta - v) @ numbers.matrix.T
        return zeta + numbers.cap * gap, _in_spans(numbers, gap)
    weight = np.where(zeta == v, 0.0, 1 / numbers.sigma)
    change = gap = lqr - ((zeta - v) / numbers.sigma) @ numbers.matrix - v
    if len(numbers.L):
        weighted = weight[..., None] * numbers.W
        small = np.einsum("...mr,ms->...rs", weighted, numbers.W) + np.diag(1 / numbers.L)
        right = np.einsum("...mr,...m->...r", weighted, gap)
        change = gap - solve_quasidefinite(small, right) @ numbers.W.T
    after = zeta + change
    above = np.where(zeta <= numbers.high, after - numbers.high, 0.0)  # beyond a bound that zeta had not passed
    below = np.where(zeta >= numbers.low, numbers.low - after, 0.0)
    beyond = _in_spans(numbers, np.maximum(np.maximum(above, below), 0.0))
    scale = np.minimum(1.0, numbers.cap / np.maximum(beyond, numbers.cap))
    return zeta + change * scale[..., None], _in_spans(numbers, gap)


def _in_spans(numbers: SplittingNumbers, rows: Array) -> Array:
    """The largest entry (...,) of rows (..., M), in spans of their limits; rows without two bounds do not count."""
    counted = numbers.inverse_span > 0
    return np.asarray((np.abs(rows[..., counted]) * numbers.inverse_span[counted]).max(axis=-1, initial=0.0))


def solve_quasidefinite(G: Array, right: Array) -> Array:
    """x of G x = right by L D L' without pivoting, (..., r, r) and (..., r)."""
    r = G.shape[-1]
    factor, x = G.copy(), right.copy()
    for j in range(r):  # column by column; the diagonal holds D, the strict lower part L
        column = factor[..., j + 1 :, j] / factor[..., j, j, None]
        factor[..., j + 1 :, j + 1 :] -= column[..., :, None] * factor[..., j, None, j + 1 :]
        factor[..., j + 1 :, j] = column
        x[..., j + 1 :] -= column * x[..., j, None]
    for j in reversed(range(r)):
        x[..., j] /= factor[..., j, j]
        x[..., j] -= (factor[..., j + 1 :, j] * x[..., j + 1 :]).sum(axis=-1)
    return x


def shift(zeta: Array, rows_of_stage: int) -> Array:
    """The rows (..., M) of the next stages, the last stage twice."""
    return np.concatenate([zeta[..., rows_of_stage:], zeta[..., -rows_of_stage:]], axis=-1)
