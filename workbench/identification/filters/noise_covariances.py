"""Noise covariances from data: the Q and R of largest likelihood, with their standard errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations

import numpy as np
from scipy.optimize import minimize

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, Integers, as_array, describe, one_of
from workbench.core.validation.signatures import answer, check_arguments
from workbench.core.validation.type_hints import KindError
from workbench.identification.filters.autocovariance_start import autocovariance_numbers
from workbench.identification.filters.filter_estimate import FilterEstimate
from workbench.identification.filters.filter_input import covariance

FilterRun = Callable[[Array, Array], FilterEstimate | Sequence[FilterEstimate]]
FORMS = ("diagonal", "scaled")
STEP, WIDE_STEP = 1e-3, 1e-2  # of the logarithm of a variance, for first and for second derivatives
RANGE = float(np.log(1e10))  # of this logarithm about its start, each way
FLAT = 1e-2  # second derivative of the log-likelihood below which the samples say nothing of a variance
LARGER = (1.0, 1e3, 1e6, 1e9)  # factors of Q, tried for a gain that settles within the samples
BARRIER = 1e50  # in the place of an infinite cost
NEAR = 0.01  # standard errors, from the end of the search to the maximum


@dataclass(frozen=True, eq=False, repr=False)
@show
class NoiseCovariances:
    """The covariances Q and R of largest likelihood.

    Parameters
    ----------
    Q, R
        (n, n) and (q, q).
    names
        The estimated numbers: 'Q[omega]' and 'R[omega]' for variances, 'Q' and 'R' for factors.
    values, standard_errors
        (m,), the numbers and their standard errors by the observed information; NaN where the samples do not tell the
        number from 0.
    log_likelihood
        The largest log-likelihood.
    distance
        The distance to the maximum that a Newton step gives, in standard errors: the certificate of the search.
    runs
        The number of filter runs.
    remarks
        Sentences on what a reader must know.
    """

    Q: Array
    R: Array
    names: tuple[str, ...]
    values: Array
    standard_errors: Array
    log_likelihood: float
    distance: float
    runs: int
    remarks: tuple[str, ...] = ()

    def __repr__(self) -> str:
        rows = zip(self.names, self.values, self.standard_errors, strict=True)
        return f"<NoiseCovariances: {', '.join(f'{name} = {v:.4g} +- {s:.2g}' for name, v, s in rows)}>"


@check_arguments
def noise_covariances(run: FilterRun, Q: Array, R: Array, form: str = "diagonal") -> NoiseCovariances:
    """The noise covariances of largest likelihood, over the exact log-likelihood of a filter.

    If `run` gives Kalman filters with constant matrices, the search begins at the Q and R by autocovariances of the
    innovations (Odelson, Rajamani and Rawlings 2006), or at those given, by the larger likelihood.

    Parameters
    ----------
    run
        A function that gives the `FilterEstimate` for Q and R, or several of independent experiments. The filter of an
        `Ode` must have its `parts` given, so that the likelihood is smooth.
    Q, R
        The start of the search, (n, n) and (q, q), or the gain for its autocovariances. A variance that is 0 in Q
        stays 0.
    form
        "diagonal" for each variance of diagonal Q and R, or "scaled" for one factor of Q and one of R.

    Raises
    ------
    ValueError
        If Q or R does not fit, or the filter has no likelihood at the start or at the end of the search.

    References
    ----------
    Sarkka (2013), Bayesian Filtering and Smoothing, section 12.2.
    Odelson, Rajamani and Rawlings (2006), Automatica 42(2), 303-308.
    Harvey (1989), Forecasting, Structural Time Series Models and the Kalman Filter, section 3.4.

    Examples
    --------
    >>> rng = np.random.default_rng(4)
    >>> y = np.cumsum(rng.normal(0.0, 0.1, 500)) + rng.normal(0.0, 0.3, 500)
    >>> def run(Q, R):
    ...     return wb.filters.kalman_filter(y, [[1]], [[1]], Q, R, x0=[0], P0=[[1]])
    >>> wb.filters.noise_covariances(run, [[0.1]], [[0.1]]).values.round(3)
    array([0.012, 0.094])
    """
    call = "noise_covariances"
    one_of(f"{call}(form=...)", form, FORMS)
    shape = _Shape(
        covariance(call, "Q", Q, _size(call, "Q", Q)), covariance(call, "R", R, _size(call, "R", R), True), form
    )
    search = _Search(call, run, shape)
    estimates = search.begin()
    start = search.start(estimates)
    ends = minimize(
        search.cost,
        start,
        jac=search.slope,
        method="L-BFGS-B",
        bounds=[(log - RANGE, log + RANGE) for log in start],
        options={"ftol": 1e-14, "gtol": 1e-6, "maxiter": 200},
    )
    return _answer(search, np.asarray(ends.x), start, shape.names(estimates[0]))


@dataclass(frozen=True, eq=False)
class _Shape:
    """The numbers of Q and R that are free, as logarithms over their start."""

    Q: Array
    R: Array
    form: str

    def __post_init__(self) -> None:
        for name, part in (("Q", self.Q), ("R", self.R)):
            if self.form == "diagonal" and (part != np.diag(np.diag(part))).any():
                raise ValueError(
                    f"`noise_covariances({name}=...)` must be diagonal in the form 'diagonal'; take the form 'scaled' "
                    "for one factor of the whole matrix."
                )
        if not self.Q.any():
            raise ValueError("`noise_covariances(Q=...)` must have a variance that is not 0, where the search begins.")

    @property
    def free(self) -> Integers:
        """The places of the variances of Q that are free."""
        return np.flatnonzero(np.diag(self.Q))

    @property
    def size(self) -> int:
        return 2 if self.form == "scaled" else len(self.free) + len(self.R)

    def matrices(self, logs: Array) -> tuple[Array, Array]:
        """Q and R."""
        factors = np.exp(logs)
        if self.form == "scaled":
            return factors[0] * self.Q, factors[1] * self.R
        scales = np.ones(len(self.Q))
        scales[self.free] = factors[: len(self.free)]
        return self.Q * scales, self.R * factors[len(self.free) :]

    def parts(self) -> list[tuple[Array, Array]]:
        """The parts of (Q, R), one for each logarithm, of which the factors make both."""
        no_q, no_r = np.zeros_like(self.Q), np.zeros_like(self.R)
        if self.form == "scaled":
            return [(self.Q, no_r), (no_q, self.R)]
        own = [(np.diag(np.where(np.arange(len(self.Q)) == i, np.diag(self.Q), 0.0)), no_r) for i in self.free]
        sensors = range(len(self.R))
        return own + [(no_q, np.diag(np.where(np.arange(len(self.R)) == i, np.diag(self.R), 0.0))) for i in sensors]

    def values(self, logs: Array) -> Array:
        """The free numbers."""
        if self.form == "scaled":
            return np.asarray(np.exp(logs))
        Q, R = self.matrices(logs)
        return np.concatenate([np.diag(Q)[self.free], np.diag(R)])

    def names(self, estimate: FilterEstimate) -> tuple[str, ...]:
        """The names of the free numbers."""
        if self.form == "scaled":
            return ("Q", "R")
        states, outputs = estimate.states.labels, estimate.outputs.labels
        return (*(f"Q[{states[i]}]" for i in self.free), *(f"R[{label}]" for label in outputs))


class _Search:
    """The cost -log L, its slope and its curvature by central differences."""

    def __init__(self, call: str, run: FilterRun, shape: _Shape) -> None:
        self._call, self._run, self.shape = call, run, shape
        self.runs = 0

    def estimates(self, logs: Array) -> list[FilterEstimate]:
        """The estimates of all experiments."""
        self.runs += 1
        ask = partial(self._run, *self.shape.matrices(logs))
        return answer(f"{self._call}(run=...)", "give a `FilterEstimate`, or several", ask, _estimates, refuses=True)

    def begin(self) -> list[FilterEstimate]:
        """The estimates at the start that was given, which must have a likelihood."""
        estimates = self.estimates(np.zeros(self.shape.size))
        if not all(np.isfinite(estimate.log_likelihood) for estimate in estimates):
            raise ValueError(
                f"`{self._call}(Q=..., R=...)` must be a start at which the filter does not diverge; here it does: "
                "take larger variances."
            )
        return estimates

    def start(self, estimates: list[FilterEstimate]) -> Array:
        """The logarithms (m,) at which the search begins: by autocovariances, or zeros if these are less likely.

        A gain that has not settled within the samples gives no autocovariances; one for a larger Q settles sooner.
        """
        zeros, given = np.zeros(self.shape.size), -sum(one.log_likelihood for one in estimates)
        for larger in LARGER:
            logs = zeros.copy()
            logs[: self.shape.size - len(self.shape.R) if self.shape.form == "diagonal" else 1] = np.log(larger)
            some = estimates if larger == 1 else self.estimates(logs)
            found = autocovariance_numbers(some, self.shape.matrices(logs)[1], self.shape.parts())
            if found is not None:
                return np.log(found) if self.cost(np.log(found)) < given else zeros
        return zeros

    def cost(self, logs: Array) -> float:
        """-log L; where a filter diverges, a number from which the search turns back."""
        value = -sum(estimate.log_likelihood for estimate in self.estimates(logs))
        return float(value) if np.isfinite(value) else BARRIER

    def slope(self, logs: Array) -> Array:
        """The derivatives (m,) by the logarithms."""
        steps = STEP * np.eye(len(logs))
        return np.array([(self.cost(logs + step) - self.cost(logs - step)) / (2 * STEP) for step in steps])

    def curvature(self, logs: Array) -> Array:
        """The second derivatives (m, m): the observed information."""
        steps, middle = WIDE_STEP * np.eye(len(logs)), self.cost(logs)
        sides = [(self.cost(logs + step), self.cost(logs - step)) for step in steps]
        H = np.diag([above - 2 * middle + below for above, below in sides])
        for i, j in combinations(range(len(logs)), 2):
            corners = self.cost(logs + steps[i] + steps[j]), self.cost(logs - steps[i] - steps[j])
            H[i, j] = H[j, i] = (sum(corners) - sum(sides[i]) - sum(sides[j]) + 2 * middle) / 2
        return np.asarray(H / WIDE_STEP**2)


def _estimates(given: object) -> list[FilterEstimate]:
    things = list(given) if isinstance(given, Sequence) else [given]
    estimates = [thing for thing in things if isinstance(thing, FilterEstimate)]
    if not estimates or len(estimates) < len(things):
        raise KindError("a `FilterEstimate`, or several", describe(given))
    return estimates


def _answer(search: _Search, logs: Array, start: Array, names: tuple[str, ...]) -> NoiseCovariances:
    slope, H = search.slope(logs), search.curvature(logs)
    known = (np.diag(H) > FLAT) & (np.abs(logs - start) < RANGE)
    errors, remarks, distance = np.full(len(logs), np.nan), [], 0.0
    part = H[np.ix_(known, known)]
    for name in np.array(names)[~known]:
        remarks.append(
            f"The samples do not tell '{name}' from 0 or bound it: the log-likelihood is flat there, so it has no "
            "standard error."
        )
    if known.any() and np.linalg.eigvalsh(part)[0] > 0:
        inverse = np.linalg.inv(part)
        errors[known] = np.sqrt(np.diag(inverse))
        distance = float(np.sqrt(slope[known] @ inverse @ slope[known]))
    elif known.any():
        distance = float("inf")
    if distance > NEAR:
        remarks.append(
            f"The search ended {distance:.2g} standard errors from the maximum of the log-likelihood: start nearer to "
            "it."
        )
    Q, R = search.shape.matrices(logs)
    values, top = search.shape.values(logs), -search.cost(logs)
    return NoiseCovariances(Q, R, names, values, values * errors, top, distance, search.runs, tuple(remarks))


def _size(call: str, name: str, value: Array) -> int:
    array = as_array(value)
    if array is None or array.ndim != 2 or array.shape[0] != array.shape[1]:
        raise ValueError(f"`{call}({name}=...)` must be a square matrix; got {describe(value)}.")
    return len(array)
