"""The delay between two signals, with an interval: y(t) = c + K g(u(t - d)), g a lag of first order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.datasets.experiment import Experiment
from workbench.identification.datasets.sample_changes import refuse_uneven

Profile = Callable[[float, float], tuple[float, float]]
CALL = "Dataset.estimate_delay(...)"
LAGS = 8  # time constants of the first search, beside none
SHORTEST = 1e-4  # periods: a shorter lag is none
DELAYS = 200  # of the first search


@dataclass(frozen=True)
class DelayEstimate:
    """A delay d in s with its 95 % interval, and the lag of first order that was estimated with it.

    Parameters
    ----------
    delay, low, high
        The estimate and the ends of the interval in s.
    lag
        The time constant in s of the lag between the two signals; 0 if there is none.
    gain
        The gain from the input to the output.
    explained_share
        The share of the output's variance that the delay and the lag explain, at most 1. Where it is small, so is what
        the interval says.
    """

    delay: float
    low: float
    high: float
    lag: float
    gain: float
    explained_share: float


@dataclass(frozen=True)
class _Pair:
    """Even samples of an input and an output, of which the first `skip` have no input at the longest delay."""

    u: Array
    y: Array
    period: float
    skip: int
    is_held: bool

    def fit(self, delay: float, lag: float) -> tuple[float, float, Array]:
        """The sum of squares, the gain and the residuals at a delay and a lag, by linear least squares."""
        response = self._response(delay, lag)[self.skip :]
        start = np.exp(-np.arange(response.size) * self.period / lag) if lag else np.zeros(response.size)
        base = np.column_stack([np.ones(response.size), start] if lag else [np.ones(response.size)])
        table = np.column_stack([response, base])
        y = self.y[self.skip :]
        gains = np.linalg.lstsq(table, y, rcond=None)[0]
        residuals = y - table @ gains
        return float(residuals @ residuals), float(gains[0]), residuals

    def _response(self, delay: float, lag: float) -> Array:
        """The lagged input at the samples: exact for a held input, and for straight lines between samples."""
        from scipy.signal import lfilter

        whole, part = divmod(delay / self.period, 1.0)
        shift = int(whole)
        near = np.concatenate([np.full(shift, self.u[0]), self.u[: self.u.size - shift]])
        far = np.concatenate([near[:1], near[:-1]])
        if self.is_held:  # the sample of before holds for the first `part` of each period
            now, before = far, np.concatenate([far[:1], far[:-1]])
            if not lag:
                return np.asarray(far if part else near)
            late = np.exp(-(1 - part) * self.period / lag)
            driven = (late - np.exp(-self.period / lag)) * before + (1 - late) * now
        else:  # the line bends at the sample `far`, after the first `part` of each period
            now = near + part * (far - near)
            if not lag:
                return np.asarray(now)
            before = np.concatenate([now[:1], now[:-1]])
            a, share = _line_weights(part * self.period / lag)
            b, other = _line_weights((1 - part) * self.period / lag)
            driven = b * ((share - a) * before + (1 - share) * far) + (other - b) * far + (1 - other) * now
        return np.asarray(lfilter([1.0], [1.0, -np.exp(-self.period / lag)], driven))


def _line_weights(x: float) -> tuple[float, float]:
    """exp(-x), and (1 - exp(-x))/x: what a lag keeps of its state, and of a line's first value beyond that."""
    return float(np.exp(-x)), float(-np.expm1(-x) / x) if x else 1.0


def estimate_delay(
    experiments: Sequence[Experiment], signals: tuple[int, int], longest: float | None, is_held: bool
) -> DelayEstimate:
    """The delay of one column behind another by least squares, with an interval by the profile of the likelihood."""
    from scipy.optimize import minimize
    from scipy.stats import chi2

    pairs = _pairs(experiments, signals, longest, is_held)
    period, end = pairs[0].period, pairs[0].skip * pairs[0].period
    total = sum(float(np.sum((pair.y[pair.skip :] - pair.y[pair.skip :].mean()) ** 2)) for pair in pairs)
    if not total > 0 or not any(np.ptp(pair.u) for pair in pairs):
        raise ValueError(
            f"`{CALL}` must have signals that change; the {'input' if total > 0 else 'output'} is constant."
        )

    def squares(delay: float, lag: float) -> float:
        return sum(pair.fit(min(max(delay, 0.0), end), lag if lag > SHORTEST * period else 0.0)[0] for pair in pairs)

    delays = np.arange(0, end + period / 2, max(period, end / DELAYS))
    lags = [0.0, *np.geomspace(period / 2, max(end, 4 * period), LAGS)]
    start = min(((d, lag) for d in delays for lag in lags), key=lambda pair: squares(*pair))

    def best_lag(delay: float, lag: float) -> tuple[float, float]:
        """The least sum of squares at a delay over the lag, and this lag."""

        def of_lag(z: Array) -> float:
            return squares(delay, abs(float(z[0])))

        search = minimize(of_lag, np.array([max(lag, period / 2)]), method="Nelder-Mead")
        return min((squares(delay, 0.0), 0.0), (float(search.fun), abs(float(search.x[0]))))

    def of_both(z: Array) -> float:
        return squares(float(z[0]), abs(float(z[1])))

    corners = np.array(start) + np.array([[0.0, 0.0], [period / 2, 0.0], [0.0, period]])
    search = minimize(of_both, corners[0], method="Nelder-Mead", options={"initial_simplex": corners})
    delay, lag = min(max(float(search.x[0]), 0.0), end), abs(float(search.x[1]))
    lag = lag if lag > SHORTEST * period else 0.0
    least = squares(delay, lag)
    count = sum(_independent(pair.fit(delay, lag)[2]) for pair in pairs)
    limit = least * float(np.exp(chi2.ppf(0.95, 1) / count)) if least > 1e-20 * total else 1e-18 * total
    ends = [_end(best_lag, delay, lag, limit, side * period, end) for side in (-1, 1)]
    shifts = np.linspace(ends[0], ends[1], 129)
    sums = np.array([squares(one, 0.0) for one in shifts.tolist()])
    if (
        sums.min() <= limit
    ):  # no lag explains the samples as well; a held input may tell no delay of a period from another
        delay, lag = float(shifts[sums <= sums.min() * (1 + 1e-12)].mean()), 0.0
    return DelayEstimate(delay, ends[0], ends[1], lag, pairs[0].fit(delay, lag)[1], 1 - squares(delay, lag) / total)


def _pairs(
    experiments: Sequence[Experiment], signals: tuple[int, int], longest: float | None, is_held: bool
) -> list[_Pair]:
    for experiment in experiments:
        refuse_uneven(CALL, experiment, signals)
    span = min(float(np.ptp(experiment.t)) for experiment in experiments)
    end = span / 4 if longest is None else longest
    if not max(experiment.period for experiment in experiments) < end <= span / 2:
        raise ValueError(
            f"`{CALL}` must have a `longest` delay between a period and half of an experiment; the shortest has "
            f"{span:.6g} s, and got {end:g} s."
        )
    pairs = []
    for experiment in experiments:
        u, y = (experiment.values[:, column] for column in signals)
        pairs.append(_Pair(u, y, experiment.period, int(np.ceil(end / experiment.period)), is_held))
    return pairs


def _independent(residuals: Array) -> float:
    """The number of independent samples in residuals of first order: n (1 - r)/(1 + r)."""
    power = float(residuals @ residuals)
    r = float(residuals[1:] @ residuals[:-1]) / power if power else 0.0
    r = min(max(r, 0.0), 1 - 1 / residuals.size)
    return residuals.size * (1 - r) / (1 + r)


def _end(best_lag: Profile, delay: float, lag: float, limit: float, step: float, last: float) -> float:
    """The delay at which the profile of the sum of squares crosses a limit, found by steps and bisection."""
    inner, outer = delay, delay
    while 0 < outer + step < last:
        outer = outer + step
        value, lag = best_lag(outer, lag)
        if value > limit:
            break
        inner, step = outer, 2 * step
    else:
        outer = min(max(outer + step, 0.0), last)
        if best_lag(outer, lag)[0] <= limit:
            return outer
    for _ in range(30):
        middle = (inner + outer) / 2
        inner, outer = (middle, outer) if best_lag(middle, lag)[0] <= limit else (inner, middle)
    return (inner + outer) / 2
