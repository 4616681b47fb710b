"""A gain over time as the coefficients of a series, with the error that they leave."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from workbench.design.certificates import Refused
from workbench.design.matrices import EPS, answer
from workbench.design.riccati.one_thread import one_thread
from workbench.validation.refusals import Array, as_array, described
from workbench.validation.signatures import door
from workbench.validation.views import show

MOST_TERMS = 1025
OTHERS, GOLDEN = 13, (np.sqrt(5) - 1) / 2  # times that lie on no grid, for a series to be held against
Gains = Callable[[Array], Any]
Places = np.ndarray[Any, np.dtype[np.intp]]


@dataclass(frozen=True, eq=False)
@show
class Series:
    """K(t) on [0, horizon] as a sum of coefficients times T_k(2 t / horizon - 1), or times 1, cos wt, sin wt, ...

    Parameters
    ----------
    coefficients
        (terms, m, n).
    horizon
        Where a Chebyshev series ends, or the period of a Fourier series with w = 2 pi / horizon, in s.
    kind
        "chebyshev" or "fourier".
    error
        The largest difference of an entry found between series and gains, over the largest entry of the gains,
        at twice as many times as the series was made from.
    """

    coefficients: Array
    horizon: float
    kind: str
    error: float

    @door
    def at(self, times: Array) -> Array:
        """K (N, m, n) at the times (N,) in s, or at one.

        Raises
        ------
        ValueError
            If the times are no vector of finite numbers.
        """
        t = np.atleast_1d(times)
        if t.ndim != 1 or not t.size or not (np.abs(t) <= self.horizon / EPS).all():
            must = "a vector of finite times in s that a float can tell from their neighbours"
            raise ValueError(f"`at(times=...)` must be {must}; got {described(times)}.")
        basis = _chebyshev(t, self.horizon, len(self.coefficients)) if self.kind == "chebyshev" else None
        basis = _fourier(t, self.horizon, len(self.coefficients)) if basis is None else basis
        return np.tensordot(basis, self.coefficients, axes=1)


@door
def chebyshev(gains: Gains, horizon: float, tolerance: float = 1e-8) -> Series:
    """The shortest Chebyshev series found that is within a tolerance of gains on [0, horizon].

    The gains are asked for at 2^k + 1 Chebyshev points, k = 3, 4, ..., and the series through them is held against
    the gains at the points between, and at times that no such points have.

    Parameters
    ----------
    gains
        From rising times (N,) in s to K (N, m, n), such as `lambda t: rde(A, B, Q, R, P1, t).K`.
    horizon
        In s.
    tolerance
        Of the largest entry of the gains.

    Raises
    ------
    ValueError
        If the horizon is not positive, the tolerance not between 1e-14 and 1, or the gains no such array.
    Refused
        If 1025 terms do not reach the tolerance: the gain has a corner, or is too quick for its horizon.

    References
    ----------
    Trefethen (2013), Approximation Theory and Approximation Practice, chapters 3 and 7.
    """
    call = "chebyshev(gains, horizon)"
    _check(call, horizon, tolerance)
    terms = 9
    while terms <= MOST_TERMS:
        angle = np.pi * np.arange(2 * terms - 2, -1, -1) / (2 * terms - 2)
        t = horizon * ((1 + np.cos(angle)) / 2)
        t[0] = 0.0
        t, own = _mixed(t, horizon)
        K = _asked(call, gains, t)
        at = own[::2]
        found = np.linalg.solve(_chebyshev(t[at], horizon, terms), K[at].reshape(terms, -1))
        series = _trimmed(
            np.array(found.reshape(terms, *K.shape[1:]), dtype=float), t, K, horizon, "chebyshev", tolerance
        )
        if series is not None:
            return series
        terms = 2 * terms - 1
    raise _refusal(call, tolerance)


@door
@one_thread()
def fourier(gains: Gains, period: float, tolerance: float = 1e-8) -> Series:
    """The shortest Fourier series found that is within a tolerance of gains that repeat after a period.

    Parameters
    ----------
    gains
        From rising times (N,) in s to K (N, m, n).
    period
        In s.
    tolerance
        Of the largest entry of the gains.

    Raises
    ------
    ValueError
        If the period is not positive, the tolerance not between 1e-14 and 1, or the gains no such array.
    Refused
        If 1025 terms do not reach the tolerance: the gain does not repeat after a period, or has a corner.

    References
    ----------
    Trefethen (2000), Spectral Methods in MATLAB, chapter 3.
    """
    call = "fourier(gains, period)"
    _check(call, period, tolerance)
    terms = 9
    while terms <= MOST_TERMS:
        t, own = _mixed(period * np.arange(2 * terms + 1) / (2 * terms), period)
        K = _asked(call, gains, t)
        # the last sample closes the period: it is held against the series, and does not make it
        at = own[:-1:2]
        found = np.linalg.lstsq(_fourier(t[at], period, terms), K[at].reshape(terms, -1), rcond=None)[0]
        series = _trimmed(np.array(found.reshape(terms, *K.shape[1:]), dtype=float), t, K, period, "fourier", tolerance)
        if series is not None:
            return series
        terms = 2 * terms - 1
    raise _refusal(call, tolerance)


def _trimmed(found: Array, t: Array, K: Array, horizon: float, kind: str, tolerance: float) -> Series | None:
    """The series without the last terms that its tolerance does not need; None where even all are not enough."""
    size = float(np.abs(K).max())
    error = float(np.abs(Series(found, horizon, kind, 0.0).at(t) - K).max())
    if error > tolerance * size:
        return None
    # no term is larger than its coefficient, so what is left out moves no entry by more than their sum
    tails = np.abs(found)[::-1].cumsum(axis=0)[::-1].reshape(len(found), -1).max(axis=1)
    kept = max(1, int((error + tails > tolerance * size).sum()))
    kept += 1 if kind == "fourier" and kept % 2 == 0 else 0
    series = Series(found[:kept], horizon, kind, 0.0)
    error = float(np.abs(series.at(t) - K).max())
    return replace(series, error=error / size if size else 0.0)


def _mixed(t: Array, length: float) -> tuple[Array, Places]:
    """The times with others between them, and where the times are: on equal steps one frequency poses as another."""
    others = length * (GOLDEN * np.arange(1, OTHERS + 1) % 1)
    every = np.unique(np.concatenate([t, others]))
    return every, np.searchsorted(every, t)


def _asked(call: str, gains: Gains, t: Array) -> Array:
    K = as_array(answer(call, "gains", gains, t))
    if K is None:
        raise ValueError(f"`{call}`: gains must give real matrices (N, m, n) at N = {len(t)} times.")
    if K.ndim != 3 or len(K) != len(t) or not np.isfinite(K).all():
        raise ValueError(
            f"`{call}`: gains must give finite matrices (N, m, n) at N = {len(t)} times; got shape {K.shape}."
        )
    return K


def _check(call: str, horizon: float, tolerance: float) -> None:
    if not np.finfo(float).tiny <= horizon < np.inf:
        raise ValueError(f"`{call}`: the time must be a positive number of seconds; got {horizon!r}.")
    if not 1e-14 <= tolerance <= 1:
        raise ValueError(f"`{call}`: tolerance must lie between 1e-14, near rounding, and 1; got {tolerance!r}.")


def _refusal(call: str, tolerance: float) -> Refused:
    return Refused(
        f"`{call}`: {MOST_TERMS} terms do not come within {tolerance:g} of the gains. They have a corner, change too "
        "quickly or do not repeat as asked; cut the time in pieces, or take a larger tolerance."
    )


def _chebyshev(t: Array, horizon: float, terms: int) -> Array:
    """T_k(2 t / horizon - 1), (N, terms)."""
    x = np.clip(2 * t / horizon - 1, -1, 1)
    return np.cos(np.arccos(x)[:, None] * np.arange(terms))


def _fourier(t: Array, period: float, terms: int) -> Array:
    """1, cos wt, sin wt, cos 2wt, ..., (N, terms)."""
    k = np.arange(1, terms // 2 + 1)
    angle = 2 * np.pi / period * t[:, None] * k
    waves = np.stack([np.cos(angle), np.sin(angle)], axis=2).reshape(len(t), -1)
    return np.hstack([np.ones((len(t), 1)), waves])
