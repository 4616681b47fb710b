r"""The penalties, the kept modes and the number of sweeps, chosen by the spectrum of the dual matrix.

Let Dbar = diag(f)^-1/2 D diag(f)^-1/2 with the floors f of its rows, h_1 >= h_2 >= ... its eigenvalues and V its modes.
The metric keeps r modes at the ends of the spectrum and sets sigma = c f with c in the middle of the rest:

    M = c diag(f) + diag(f)^1/2 V_kept (h_kept - c) V_kept' diag(f)^1/2,     gamma = max over the rest of |h / c - 1|.

**The contraction holds for every active set.** -gamma M <= M - D <= gamma M, and this stays true for any rows and the
same columns of both. A sweep whose active set a does not change maps the error e of the active multipliers to
M_aa^-1 (M - D)_aa e. This matrix is symmetric in the inner product of M_aa, with eigenvalues within [-gamma, gamma]. So
each sweep reduces the error by gamma, whichever limits act. With hard limits on states D is singular: then gamma is
taken over its modes that are not zero, it is no bound (`is_proved` is False), and the errors that `sampled_loss` finds
decide.

The floors are (R^-1)_ii of an input, twice that of its rate, and for other rows a share of the largest diagonal of D
that is chosen with r, such that (operations of a sweep) log(accuracy) / log(gamma) is least, with three sweeps or more:
these find the active set, whatever gamma is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, log

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite, whole
from workbench.core.validation.signatures import check_arguments
from workbench.planning.linear_mpc.limit_rows import RATE
from workbench.planning.linear_mpc.linear_problem import LinearMpc
from workbench.planning.linear_mpc.prediction_maps import PredictionMaps, prediction_maps
from workbench.planning.linear_mpc.splitting import METRIC, SplittingNumbers

SHARES = (1.0, 0.3, 0.1, 0.03, 0.01)
MOST_MODES = 16
NULL = 1e-9  # of the largest eigenvalue: below it a mode of D moves no row
CAP = 0.5  # spans: sweeps that passed a bound by more were seen to cycle between opposite bounds
FEWEST_SWEEPS, MOST_SWEEPS = 3, 40  # fewer than 3 lost loops in which the reference jumps


@dataclass(frozen=True, eq=False)
@show
class SplittingMetric:
    """The diagonal sigma (M,), kept modes W (M, r) with L (r,), and the contraction, proved if D is regular."""

    sigma: Array
    W: Array
    L: Array
    contraction: float
    is_proved: bool


@check_arguments
def splitting_numbers(
    problem: LinearMpc, *, sweeps: int | None = None, modes: int | None = None, accuracy: float = 1e-2
) -> SplittingNumbers:
    """The constants of the law for a problem, with metric and number of sweeps chosen by the spectrum.

    Parameters
    ----------
    problem
        The problem.
    sweeps
        The number of sweeps of a period; by default as many as reduce an error of one span to `accuracy` by the
        contraction, at least 3 and at most 40.
    modes
        The number r of kept modes, at most the number of rows; chosen by default, up to 16.
    accuracy
        The error that is wanted of the rows, in spans.

    Raises
    ------
    ValueError
        If a number is out of its range.

    Examples
    --------
    >>> from workbench.planning.linear_mpc import MpcLimits, mpc_problem, splitting_numbers
    >>> limits = MpcLimits(inputs=(-1.0, 1.0))
    >>> problem = mpc_problem([[1.0, 0.1], [0.0, 1.0]], [[0.0], [0.1]], np.eye(2), [[0.1]], 20, limits)
    >>> numbers = splitting_numbers(problem)
    >>> numbers.sweeps, numbers.contraction < 0.3
    (3, True)
    """
    accuracy = finite("splitting_numbers(accuracy=...)", accuracy, low=1e-12, high=0.5)
    D = dual_matrix(problem, maps := prediction_maps(problem))
    if modes is not None:
        modes = whole("splitting_numbers(modes=...)", modes, 0, len(D), " of modes")
    if sweeps is not None:
        sweeps = whole("splitting_numbers(sweeps=...)", sweeps, 1, 10_000, " of sweeps")
    metric = choose_metric(problem, D, accuracy, modes)
    count = sweeps_for(metric.contraction, accuracy) if sweeps is None else sweeps
    return SplittingNumbers(
        problem.A,
        problem.B,
        problem.rows.F,
        problem.rows.E,
        maps.Y,
        METRIC,
        D,
        problem.low,
        problem.high,
        metric.sigma,
        metric.W,
        metric.L,
        count,
        CAP,
        metric.contraction,
        metric.is_proved,
        problem.rows.has_rates,
        problem.rows.cones,
    )


def dual_matrix(problem: LinearMpc, maps: PredictionMaps) -> Array:
    """D with the softness of soft rows on its diagonal."""
    return np.asarray(maps.dual + np.diag(np.tile(problem.rows.softness, problem.horizon)))


def sweeps_for(contraction: float, accuracy: float) -> int:
    """The sweeps after which gamma^n <= accuracy, within the fewest and the most."""
    if contraction >= 1:
        return MOST_SWEEPS
    wanted = ceil(log(accuracy) / log(max(contraction, 1e-12)))
    return min(max(wanted, FEWEST_SWEEPS), MOST_SWEEPS)


def choose_metric(problem: LinearMpc, D: Array, accuracy: float, modes: int | None = None) -> SplittingMetric:
    """The metric of least operations for an accuracy, among shares of the floors and numbers of modes."""
    best: tuple[float, SplittingMetric] | None = None
    for floors in _floors(problem, D):
        scale = np.sqrt(floors)
        h, V = np.linalg.eigh(D / scale[:, None] / scale)
        for r in range(min(MOST_MODES, len(D)) + 1) if modes is None else (modes,):
            c, kept, gamma = _middle(h, r)
            sweeps = max(log(accuracy) / log(min(max(gamma, 1e-9), 1 - 1e-9)), FEWEST_SWEEPS)
            work = sweeps * len(D) * (len(D) + 2 * r + r * (r + 1) / 2)
            if best is None or work < 0.95 * best[0]:  # a mode more must earn its place
                metric = SplittingMetric(
                    c * floors, scale[:, None] * V[:, kept], h[kept] - c, gamma, bool(h[0] > NULL * h[-1])
                )
                best = work, metric
    assert best is not None
    return best[1]


def _floors(problem: LinearMpc, D: Array) -> Iterator[Array]:
    """Floors (M,) of the rows: those of inputs and rates, and shares for the others."""
    rows, nu = problem.rows, problem.B.shape[1]
    inverse = np.diag(np.linalg.inv(problem.R))
    largest = np.diag(D).reshape(problem.horizon, rows.count).max(axis=0)
    is_rate = np.array([name.startswith(RATE) for name in rows.names])
    stage = np.maximum(largest, np.finfo(float).tiny)
    stage[:nu] = inverse
    if is_rate.any():
        stage[is_rate] = 2 * inverse
    others = np.ones(rows.count, dtype=bool)
    others[:nu] = False
    others[is_rate] = False
    for share in SHARES if others.any() else (1.0,):
        floors = np.where(others, np.maximum(share * stage, rows.softness), stage)
        yield np.tile(floors, problem.horizon)


def _middle(h: Array, r: int) -> tuple[float, Array, float]:
    """The centre c, the indices of r kept modes, and gamma, for ascending eigenvalues h (M,)."""
    M = len(h)
    first = int(np.searchsorted(h, NULL * h[-1]))  # modes that move no row
    best: tuple[float, float, Array] | None = None
    for low in range(min(r, M - first) + 1):
        high = min(r - low, M - first - low)
        rest = h[first + low : M - high]
        kept = np.r_[first : first + low, M - high : M].astype(int)
        c = (rest[0] + rest[-1]) / 2 if len(rest) else float(h[-1])
        gamma = float(rest[-1] / c - 1) if len(rest) else 0.0
        if best is None or gamma < best[0] - 1e-12:
            best = gamma, float(c), kept
    assert best is not None
    gamma, c, kept = best
    return c, kept[np.abs(h[kept] - c) > 1e-6 * c], gamma
