"""Tests of residuals: whiteness, and correlation with past inputs, each with its band and its probability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter
from scipy.stats import chi2, norm

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, Integers

LONGEST_AR = 20  # the highest order of a model of the residuals
DOUBT = 0.01  # a probability below it fails a test


@dataclass(frozen=True, eq=False)
@show
class CorrelationTest:
    """A test of residuals: correlations (m,) at `lags` (m,) in periods, their 95 % bands (m,), and chi-square.

    `statistic` is chi-square distributed with `freedom` degrees of freedom if the model is right, and `probability` is
    that of a larger value. The test fails below 0.01.
    """

    name: str
    lags: Array
    correlations: Array
    bands: Array
    statistic: float
    freedom: int
    probability: float

    @property
    def is_passed(self) -> bool:
        """True if the probability is not below 0.01."""
        return not self.probability < DOUBT

    @property
    def outside(self) -> float:
        """The fraction of the correlations outside their band, about 0.05 for a model that is right."""
        return float(np.mean(np.abs(self.correlations) > self.bands))


def whiteness(residuals: Sequence[Array], lags: int, parameters: int) -> CorrelationTest:
    """The test of Ljung and Box on residuals of each record, less the number of `parameters` of the noise model.

    References
    ----------
    Ljung and Box (1978), On a measure of lack of fit in time series models, Biometrika 65, equation 1.3.
    """
    residuals = [one[np.isfinite(one)] for one in residuals]  # what is white stays so without some of its numbers
    N = sum(map(len, residuals))
    r = np.array([_lagged(residuals, residuals, k) for k in range(lags + 1)])
    r = r / r[0] if r[0] > 0 else np.concatenate([[1.0], np.zeros(lags)])
    at = np.arange(1, lags + 1)
    statistic = float(N * (N + 2) * np.sum(r[1:] ** 2 / (N - at)))
    freedom = max(lags - parameters, 1)
    band = np.full(lags, norm.ppf(0.975) / np.sqrt(N))
    tail = float(chi2.sf(statistic, freedom))
    return CorrelationTest("whiteness", at.astype(float), r[1:], band, statistic, freedom, tail)


def input_correlation(
    residuals: Sequence[Array],
    inputs: Sequence[Array],
    J: Array,
    first: int,
    lags: int,
    name: str,
    basis: Array | None = None,
) -> CorrelationTest:
    """The correlation of residuals with an input at lags from `first` on, with the score test for a further response.

    The test allows for the estimated parameters by the gradients J (N, size), and for residuals that are not white. A
    residual may be NaN, where J is 0; or all are there, less the directions of a `basis` (N, m), and white beside it.

    References
    ----------
    Ljung (1999), section 16.6; Godfrey (1978), Econometrica 46, pages 1293 to 1310.
    """
    at = np.arange(first, first + lags)
    N = sum(map(len, residuals))
    seen_rows = np.isfinite(np.concatenate(residuals))
    whole = [np.where(np.isfinite(e), e, 0.0) for e in residuals]
    sizes = np.sqrt(sum(float(e @ e) for e in whole)) * np.sqrt(sum(float(u @ u) for u in inputs))
    r = np.array([_lagged(residuals, inputs, int(k)) for k in at]) * N / (sizes or 1.0)
    AR, variance = noise_filter(residuals)
    shaped = [lfilter([1.0], AR, u[::-1])[::-1] * np.sqrt(variance) for u in inputs]
    power = sum(float(u @ u) for u in inputs)
    errors = sum(float(e @ e) for e in whole)
    spread = np.sqrt(sum(float(u @ u) for u in shaped) / max(power * errors, 1e-300))
    Z = np.where(seen_rows[:, np.newaxis], np.vstack([_shifted(u, at) for u in inputs]), 0.0)
    if basis is not None:
        Z = Z - basis @ (basis.T @ Z)
    if J.shape[1]:
        Q = np.linalg.qr(J / np.maximum(np.linalg.norm(J, axis=0), 1e-300))[0]
        Z = Z - Q @ (Q.T @ Z)
    W = shaped_product(Z, residuals) if basis is None else Z.T @ Z * errors / (N - basis.shape[1])
    score = Z.T @ np.concatenate(whole)
    values, vectors = np.linalg.eigh(W)
    seen = values > 1e-8 * max(values.max(initial=0.0), 1e-300)
    statistic = float(np.sum((vectors[:, seen].T @ score) ** 2 / values[seen]))
    freedom = int(max(seen.sum(), 1))
    band = np.full(lags, norm.ppf(0.975) * spread)
    return CorrelationTest(name, at.astype(float), r, band, statistic, freedom, float(chi2.sf(statistic, freedom)))


def noise_filter(residuals: Sequence[Array]) -> tuple[Array, float]:
    """A in A e = w, w white, of an order by BIC, and the variance of w: a model of residuals that may be coloured."""
    N = sum(int(np.isfinite(one).sum()) for one in residuals)
    most = min(LONGEST_AR, N // 20)
    r = np.array([_lagged(residuals, residuals, k) for k in range(most + 1)])
    if r[0] <= 0:
        return np.ones(1), 0.0
    best, A, variance = (np.log(r[0]), np.ones(1), float(r[0])), np.ones(1), float(r[0])
    for order in range(1, most + 1):  # Levinson's recursion
        k = -float(A @ r[order:0:-1]) / variance
        if abs(k) >= 1:  # correlations of a signal with gaps need be those of no process
            break
        A = np.concatenate([A, [0.0]]) + k * np.concatenate([[0.0], A[::-1]])
        variance *= 1 - k**2
        score = np.log(max(variance, 1e-300)) + order * np.log(N) / N
        if score < best[0]:
            best = (score, A, variance)
    return best[1], float(best[2])


def shaped_product(Z: Array, residuals: Sequence[Array]) -> Array:
    """The covariance (n, n) of Z' e for Z (N, n), which does not depend on e, and e coloured as the residuals are.

    References
    ----------
    Ljung (1999), equation 9.42, for a model whose noise has no parameters.
    """
    AR, variance = noise_filter(residuals)
    at, parts = 0, []
    for e in residuals:
        part = Z[at : at + len(e)]
        parts.append(lfilter([1.0], AR, part[::-1], axis=0)[::-1])
        at += len(e)
    whole = np.vstack(parts)
    return np.asarray(variance * whole.T @ whole)


def _lagged(first: Sequence[Array], second: Sequence[Array], lag: int) -> float:
    """The mean product of a signal and another one `lag` periods before; of a first one with NaN, over its numbers."""
    pairs = [(a[lag:], b[: len(b) - lag]) for a, b in zip(first, second, strict=True) if len(b) > lag]
    N = sum(map(len, first))
    if all(np.isfinite(a).all() and np.isfinite(b).all() for a, b in pairs):
        return sum(float(a @ b) for a, b in pairs) / N
    products = np.concatenate([a * b for a, b in pairs])
    there = np.isfinite(products)
    return float(products[there].sum()) / max(int(there.sum()), 1) * len(products) / N


def _shifted(signal: Array, delays: Integers) -> Array:
    columns = np.zeros((len(signal), len(delays)))
    for column, delay in zip(columns.T, delays, strict=True):
        column[delay:] = signal[: max(len(signal) - delay, 0)]
    return columns
