"""The extended and the unscented Kalman filter of a log, in square-root form."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from workbench.core.validation.refusals import Array, finite, whole
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset
from workbench.identification.filters.filter_columns import LogReading
from workbench.identification.filters.filter_estimate import FilterEstimate, estimate_by
from workbench.identification.filters.filter_problem import FilterProblem, problem_of
from workbench.identification.filters.forward_pass import AbstractPass, Moves
from workbench.identification.filters.motions import AbstractMotion
from workbench.identification.filters.stochastic_model import StochasticModel

TOLERANCE = 1e-4  # standard deviations, of a change by steps of half the length
MOST_PARTS = 256


class _ExtendedPass(AbstractPass):
    """The exact Jacobians at the estimate, and at the prediction for readings."""

    def __init__(self, motion: AbstractMotion) -> None:
        log = motion.log
        self.states, self.outputs, self.t, self.y = motion.states, log.outputs, log.t, log.y
        self._motion = motion
        self._transitions: list[Array] = []
        self._noises: list[Array] = []

    def read(self, k: int, x: Array, S: Array) -> tuple[Array, Array, Array]:
        y, H = self._motion.read(k, x)
        return y, H.dot(S), S

    def move(self, k: int, x: Array, S: Array) -> tuple[Array, Array, Array]:
        state, F, noise = self._motion.advance(k, x)
        self._transitions.append(F.copy())
        self._noises.append(noise)
        return state, F.dot(S), noise

    def moves(self) -> Moves:
        return Moves(*_stacked(self.states.size, self._transitions, self._noises))


class _UnscentedPass(AbstractPass):
    """2 n + 1 sigma points, whose weights are not negative, and the noise of the exact Jacobians."""

    def __init__(self, motion: AbstractMotion, c: float, central: float) -> None:
        log, n = motion.log, motion.states.size
        self.states, self.outputs, self.t, self.y = motion.states, log.outputs, log.t, log.y
        self._motion, self._c = motion, c
        self._points = np.hstack([np.zeros((n, 1)), np.eye(n), -np.eye(n)])
        self._weights = np.sqrt(np.array([central] + 2 * n * [1 / (2 * c)]))
        self._spread = self._points / sqrt(2)
        self._spreads: list[Array] = []
        self._noises: list[Array] = []
        self._transitions: list[Array] = []

    def _moments(self, images: Array) -> tuple[Array, Array]:
        """The mean of images (rows, 2 n + 1), and their spread over it, each by the root of its weight."""
        # with sum W_i = 1: without a difference of large numbers where c is small
        mean = images[:, 0] + (images[:, 1:] - images[:, :1]).sum(axis=1) / (2 * self._c)
        return mean, (images - mean[:, None]) * self._weights

    def _at(self, x: Array, S: Array) -> Array:
        return np.asarray(x[:, None] + sqrt(self._c) * S.dot(self._points))

    def read(self, k: int, x: Array, S: Array) -> tuple[Array, Array, Array]:
        mean, spread = self._moments(self._motion.read_all(k, self._at(x, S)))
        return mean, spread, S.dot(self._spread)

    def move(self, k: int, x: Array, S: Array) -> tuple[Array, Array, Array]:
        _, F, noise = self._motion.advance(k, x)
        mean, spread = self._moments(self._motion.advance_all(k, self._at(x, S)))
        self._transitions.append(F.copy())
        self._spreads.append(spread)
        self._noises.append(noise)
        return mean, spread, noise

    def moves(self) -> Moves:
        n = self.states.size
        transitions, noises = _stacked(n, self._transitions, self._noises)
        spreads = np.array(self._spreads) if self._spreads else np.zeros((0, n, 2 * n + 1))
        return Moves(transitions, noises, spreads, self._spread)


def _stacked(n: int, transitions: list[Array], noises: list[Array]) -> tuple[Array, Array]:
    """The matrices as arrays, the noise of each with the same number of columns."""
    most = max((noise.shape[1] for noise in noises), default=0)
    stacked = np.zeros((len(noises), n, most))
    for k, noise in enumerate(noises):
        stacked[k, :, : noise.shape[1]] = noise
    return np.array(transitions).reshape(-1, n, n), stacked


@dataclass(frozen=True)
@check_arguments
class SigmaPoints:
    """The constants of sigma points x +- sqrt(c) s_i, with the columns s_i of S and c = alpha^2 (n + kappa).

    The weight of the central one is 1 - n / c for means, and 2 - n / c - alpha^2 + beta for covariances. This one must
    not be negative, so that P stays positive definite. The default is the cubature rule, in which it is 0.

    References
    ----------
    Sarkka (2013), Bayesian Filtering and Smoothing, sections 5.5 and 6.6.
    Van der Merwe and Wan (2001), The square-root unscented Kalman filter, ICASSP.
    """

    alpha: float = 1.0
    beta: float = 0.0
    kappa: float = 0.0

    @check_arguments
    def of_size(self, n: int) -> tuple[float, float]:
        """c and the central weight of covariances, for n states; refused where P may lose its definiteness."""
        n = whole("SigmaPoints.of_size(n=...)", n)
        for name, value in vars(self).items():
            finite(f"SigmaPoints({name}=...)", value)
        c = self.alpha**2 * (n + self.kappa)
        central = 2 - n / c - self.alpha**2 + self.beta if c > 0 else -1.0
        if central < -1e-12:
            raise ValueError(
                f"`SigmaPoints(alpha=..., beta=..., kappa=...)` must give c = alpha^2 (n + kappa) > 0 and a central "
                f"weight 2 - n / c - alpha^2 + beta >= 0, without which P may lose its definiteness; got c = {c:g} for "
                f"{n} states: take the default alpha = 1, beta = 0, kappa = 0."
            )
        return c, max(0.0, central)


@check_arguments
def extended_kalman_filter(
    log: Dataset,
    model: StochasticModel,
    *,
    signals: Mapping[str, str] | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    hold: str = "hold",
    parts: int | None = None,
) -> FilterEstimate:
    """The extended Kalman filter of a log, over the exact Jacobians of a model; of a linear model, the Kalman filter.

    An `Ode` moves from each time of the log to the next, however these jitter. The Jacobian of the motion is taken at
    the estimate, and the one of the readings at the prediction. Samples that are NaN or marked are lost ones.

    Parameters
    ----------
    log, model
        A log of one experiment, and the equations with their noises.
    signals
        Names in the model by those in the log, where they differ: {"speed": "omega"}.
    inputs, outputs
        The parameters that the log gives, and the outputs that are read, by their names in the model. By default, they
        are the declared inputs, and all outputs that the log has.
    hold
        "hold" for inputs that stay constant between two samples, "linear" for straight lines.
    parts
        The number of Runge-Kutta steps between two samples of an `Ode`. By default they are doubled until the
        estimates change by less than 1e-4 standard deviations; `discretisation_error` of the answer is this change.

    Raises
    ------
    LookupError, ValueError
        If a name, a shape or a unit does not fit, an input has no sample, or the times do not increase.

    Examples
    --------
    >>> model = wb.filters.StochasticModel(wb.open_loop(wb.DCMotor()), np.eye(2), [[1e-2]], [0, 0], np.eye(2))
    >>> log = wb.Dataset.of([0.0, 0.1, 0.3], {"v": [1.0, 1.0, 0.0], "omega": [0.0, 0.01, 0.02]})
    >>> wb.filters.extended_kalman_filter(log, model).x.shape
    (3, 2)
    """
    call = "extended_kalman_filter"
    return _solved(
        call, problem_of(call, log, model, LogReading(inputs, outputs, signals or {}, hold)), _ExtendedPass, parts
    )


@check_arguments
def unscented_kalman_filter(
    log: Dataset,
    model: StochasticModel,
    weights: SigmaPoints | None = None,
    *,
    signals: Mapping[str, str] | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    hold: str = "hold",
    parts: int | None = None,
) -> FilterEstimate:
    """The unscented Kalman filter of a log: the moments of 2 n + 1 sigma points that move through the model itself.

    The noise of an `Ode` between two samples is the one of the extended filter.

    Parameters
    ----------
    log, model, signals, inputs, outputs, hold, parts
        As of `extended_kalman_filter`.
    weights
        The constants of the sigma points; by default those of the cubature rule.

    Raises
    ------
    LookupError, ValueError
        As `extended_kalman_filter`, and if the central weight of covariances is negative.

    Examples
    --------
    >>> ports = wb.layout(level="m"), wb.layout(), wb.layout(gauge="m")
    >>> tank = wb.filters.DiscreteModel.of(*ports, lambda x, u: 0.9 * x, lambda x, u: x**2)
    >>> log = wb.Dataset.of([0.0, 1.0, 2.0], {"gauge": [0.9, 0.7, 0.6]}, {"gauge": "m"})
    >>> model = wb.filters.StochasticModel(tank, [[1e-4]], [[1e-2]], x0=[1.0], P0=[[0.1]])
    >>> wb.filters.unscented_kalman_filter(log, model, wb.filters.SigmaPoints(kappa=2.0)).x[:, 0].round(2)
    array([0.91, 0.83, 0.75])
    """
    call = "unscented_kalman_filter"
    problem = problem_of(call, log, model, LogReading(inputs, outputs, signals or {}, hold))
    c, central = (weights or SigmaPoints()).of_size(problem.x0.size)
    return _solved(call, problem, lambda motion: _UnscentedPass(motion, c, central), parts)


def _solved(
    call: str, problem: FilterProblem, pass_of: Callable[[AbstractMotion], AbstractPass], parts: int | None
) -> FilterEstimate:
    """The estimate with the number of steps between samples, or with one that is enough."""

    def run(count: int) -> FilterEstimate:
        estimate = estimate_by(pass_of(problem.motion(count)), problem.x0, problem.P0, problem.R)
        return replace(estimate, remarks=estimate.remarks + problem.remarks_on(estimate.x))

    if parts is not None:
        return run(whole(f"{call}(parts=...)", parts, most=10_000))
    coarse = run(1)
    if not problem.has_parts:
        return coarse
    count, error = 1, np.inf
    while count < MOST_PARTS and not error <= TOLERANCE:
        count *= 2
        finer = run(count)
        error, coarse = _change(coarse, finer), finer
    remark = (
        f"Even {count} steps between two samples change the estimates by {error:.1g} standard deviations against half "
        "as many: the model is too fast for this log, or jumps between its samples."
    )
    return replace(
        coarse, remarks=coarse.remarks + (() if error <= TOLERANCE else (remark,)), discretisation_error=error
    )


def _change(coarse: FilterEstimate, fine: FilterEstimate) -> float:
    """The largest change of a state in standard deviations, or of a standard deviation as a share of itself."""
    if not np.isfinite(fine.S[-1]).all() or not np.isfinite(coarse.S[-1]).all():
        return float("inf")
    size = np.where(fine.deviations > 0, fine.deviations, 1.0)
    rounding = 64 * np.finfo(float).eps * np.abs(fine.x)
    states = np.maximum(np.abs(coarse.x - fine.x) - rounding, 0) / size
    return float(max(states.max(), np.abs(coarse.deviations / size - fine.deviations / size).max()))
