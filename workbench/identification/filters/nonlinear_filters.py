"""The extended and the unscented Kalman filter of a log, in square-root form."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import sqrt

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.step import StepMap
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, finite, whole
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset
from workbench.identification.filters.discrete_model import DiscreteModel
from workbench.identification.filters.filter_estimate import FilterEstimate, estimate_by
from workbench.identification.filters.filter_problem import FilterProblem, problem_of
from workbench.identification.filters.forward_pass import AbstractPass, Moves
from workbench.identification.filters.log_columns import Names
from workbench.identification.filters.motions import AbstractMotion
from workbench.identification.filters.parameter_walk import ParameterWalk

Model = Ode | SampledSystem | StepMap | DiscreteModel
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


@check_arguments
def extended_kalman_filter(
    log: Dataset,
    model: Model,
    Q: Numbers,
    R: Numbers,
    *,
    x0: Numbers | None = None,
    P0: Numbers | None = None,
    p: Numbers | None = None,
    inputs: Names | None = None,
    outputs: Names | None = None,
    walks: Mapping[str, ParameterWalk] | None = None,
    hold: str = "zero",
    parts: int | None = None,
) -> FilterEstimate:
    """The extended Kalman filter of a log, over the exact Jacobians of a model; of a linear model, the Kalman filter.

    An `Ode` moves from each time of the log to the next, however these jitter: x' = f(t, x, u) + w with white noise w.
    A model in discrete time moves from sample to sample: x+ = f(k, x, u) + w. The Jacobian of f is taken at the
    estimate, and the one of the readings y = h(t, x, u) + v at the prediction.

    Parameters
    ----------
    log
        The log, of one experiment. Samples that are NaN or marked are lost ones.
    model
        An `Ode`, such as of `wb.open_loop`; a loop with its computer; a step of either; or a `DiscreteModel`. The
        random numbers of a step are noise of its states, besides Q.
    Q
        (nx, nx), of an `Ode` the intensity of w, E w(t) w(s)' = Q delta(t - s), else its covariance. Semidefinite.
    R
        (q, q), the covariance of v, positive definite, in the order of the outputs.
    x0, P0
        (nx,) and (nx, nx), mean and covariance of the state before the first sample. They must be given.
    p
        (np,), the parameters of the model; by default its own.
    inputs
        Names of the parameters that the log gives, or a mapping from them to signals of the log. The default are the
        declared inputs of the model.
    outputs
        Names of the outputs that are read, or such a mapping; by default all outputs that the log has.
    walks
        Parameters of an `Ode` that are estimated with the state, by name. They are states behind those of the model.
    hold
        "zero" for inputs that stay constant between two samples, "linear" for straight lines.
    parts
        The number of Runge-Kutta steps between two samples of an `Ode`. By default they are doubled until the
        estimates change by less than 1e-4 standard deviations; `discretisation_error` of the answer is this change.

    Raises
    ------
    LookupError
        If a name is not one of the model or of the log.
    ValueError
        If a shape or a unit does not fit, Q or P0 is not positive semidefinite, R is not positive definite, x0 or P0
        is not given, an input has no sample, or the times of the log do not increase.

    References
    ----------
    Sarkka (2013), Bayesian Filtering and Smoothing, algorithm 5.4.
    Kailath, Sayed and Hassibi (2000), Linear Estimation, section 12.3: array algorithms.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> t = np.linspace(0.0, 2.0, 201)
    >>> log = wb.Dataset.of(t, {"v": np.ones(201), "omega": 0.1 * (1 - np.exp(-2 * t))}, {"v": "V", "omega": "rad/s"})
    >>> answer = wb.filters.extended_kalman_filter(log, motor, 1e-4 * np.eye(2), [[1e-4]], x0=[0, 0], P0=np.eye(2))
    >>> answer.states.labels, answer.x.shape
    (('omega', 'i'), (201, 2))
    """
    call = "extended_kalman_filter"
    problem = problem_of(call, log, model, (Q, R, P0), (x0, p), (inputs, outputs), (walks or {}, hold))
    return _solved(call, problem, _ExtendedPass, parts)


@check_arguments
def unscented_kalman_filter(
    log: Dataset,
    model: Model,
    Q: Numbers,
    R: Numbers,
    *,
    x0: Numbers | None = None,
    P0: Numbers | None = None,
    p: Numbers | None = None,
    inputs: Names | None = None,
    outputs: Names | None = None,
    walks: Mapping[str, ParameterWalk] | None = None,
    hold: str = "zero",
    parts: int | None = None,
    alpha: float = 1.0,
    beta: float = 0.0,
    kappa: float = 0.0,
) -> FilterEstimate:
    """The unscented Kalman filter of a log: the moments of 2 n + 1 sigma points that move through the model itself.

    The points lie sqrt(c) columns of S from the mean, c = alpha^2 (n + kappa). The weight of the central one is
    1 - n / c for means, and 2 - n / c - alpha^2 + beta for covariances. This one must not be negative, so that P stays
    positive definite. The default is the cubature rule, in which it is 0. The noise of an `Ode` between two samples is
    the one of the extended filter.

    Parameters
    ----------
    log, model, Q, R, x0, P0, p, inputs, outputs, walks, hold, parts
        As of `extended_kalman_filter`.
    alpha, beta, kappa
        Constants of the sigma points.

    Raises
    ------
    LookupError, ValueError
        As `extended_kalman_filter`, and if the central weight of covariances is negative.

    References
    ----------
    Sarkka (2013), Bayesian Filtering and Smoothing, algorithms 5.14 and 6.6.
    Van der Merwe and Wan (2001), The square-root unscented Kalman filter, ICASSP.

    Examples
    --------
    >>> level, gauge = wb.layout(level="m"), wb.layout(gauge="m")
    >>> tank = wb.filters.DiscreteModel.of(level, wb.layout(), gauge, lambda x, u: 0.9 * x, lambda x, u: x**2)
    >>> log = wb.Dataset.of(np.arange(3.0), {"gauge": np.array([0.9, 0.7, 0.6])}, {"gauge": "m"})
    >>> wb.filters.unscented_kalman_filter(log, tank, [[1e-4]], [[1e-2]], x0=[1.0], P0=[[0.1]]).x[:, 0].round(2)
    array([0.94, 0.84, 0.76])
    """
    call = "unscented_kalman_filter"
    problem = problem_of(call, log, model, (Q, R, P0), (x0, p), (inputs, outputs), (walks or {}, hold))
    n = problem.x0.size
    constants = {"alpha": alpha, "beta": beta, "kappa": kappa}
    alpha, beta, kappa = (finite(f"{call}({name}=...)", value) for name, value in constants.items())
    c = alpha**2 * (n + kappa)
    if not c > 0 or not 2 - n / c - alpha**2 + beta >= -1e-12:
        raise ValueError(
            f"`{call}(alpha=..., beta=..., kappa=...)` must give c = alpha^2 (n + kappa) > 0 and a central weight "
            f"2 - n / c - alpha^2 + beta >= 0, without which P may lose its definiteness; got c = {c:g} for {n} "
            "states: take the default alpha = 1, beta = 0, kappa = 0."
        )
    central = max(0.0, 2 - n / c - alpha**2 + beta)
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
