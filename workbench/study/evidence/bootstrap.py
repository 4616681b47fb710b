"""Simultaneous intervals of columns: one bootstrap of whole draws, which keeps the runs of a draw together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import ndtri

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.study.uncertainty.designs import uniforms
from workbench.study.uncertainty.outputs import check_size

BLOCK = 2**22  # counts in memory at once
BEYOND = 2  # resamples above a quantile, below which they cannot tell it
MIN_TAIL_RESAMPLES = 20  # resamples above the one from which the normal law goes on


@dataclass(frozen=True, eq=False)
@check_arguments
class Intervals:
    """Values, each with an interval from `low` to `high`; an end is infinite if there are too few draws to bound it."""

    value: Array
    low: Array
    high: Array

    def __post_init__(self) -> None:
        parts = (self.value, self.low, self.high)
        for part in parts:
            check_size("Intervals(value, low, high)", part, infinite=True)
        if len({part.shape for part in parts}) > 1:
            shapes = ", ".join(str(part.shape) for part in parts)
            raise ValueError(f"`Intervals(value, low, high)` must have two ends for each value; got shapes {shapes}.")


def means(columns: Array, rounding: Array, confidence: float, resamples: int, seed: int) -> Intervals:
    """The means of finite columns (N, k), between ends that hold all of them at once with the confidence.

        mean_k - a_k s_k / sqrt(N),  mean_k + b_k s_k / sqrt(N)

    with a_k and b_k quantiles of t*_k = (mean*_k - mean_k) sqrt(N) / s*_k and of -t*_k over resampled draws *, all of
    one share: the studentised bootstrap, balanced. A column that varies by no more than its rounding, (k,), is
    constant; one of which a resample may miss all that varies is not bounded on that side.

    References
    ----------
    Beran, "Balanced simultaneous confidence sets", Journal of the American Statistical Association 83 (1988).
    """
    runs = len(columns)
    middle = columns.mean(axis=0)
    left = columns - middle
    size = np.abs(left).max(axis=0)
    size[size <= rounding] = 0
    left[:, size == 0] = 0
    left /= np.where(size > 0, size, 1)  # no square overflows, and none loses its digits
    parts = []
    for counts in _counts(runs, resamples, seed):
        mean = counts @ left / runs
        spread = np.sqrt(np.maximum(counts @ left**2 / runs - mean**2, 0))
        with np.errstate(divide="ignore", invalid="ignore"):
            parts.append(np.where(mean == 0, 0.0, mean / spread))  # what does not vary is known exactly
    t = np.concatenate(parts)
    ends = np.maximum(_balanced(np.concatenate([t, -t], axis=1), confidence), 0).reshape(2, -1)
    varies = size > 0
    low, high = middle.copy(), middle.copy()
    scale = (left.std(axis=0) * size)[varies]
    low[varies] -= ends[0, varies] * scale
    high[varies] += ends[1, varies] * scale
    return Intervals(middle, low, high)


def order_statistics(columns: Array, share: float, confidence: float, resamples: int, seed: int) -> Intervals:
    """The quantiles of columns (N, k), infinite entries allowed, between order statistics that hold all at once.

        y_(N p - c) <= Q_p <= y_(N p + c + 1),    c the quantile of max_k |B*_k - N p|

    with B*_k how many of the resampled draws fall into the lower share p of column k. Of the median of one column it is
    the interval of the sign test.
    """
    runs = len(columns)
    below, expected, lower, ordered = _halves(columns, share)
    largest = [np.abs(counts @ lower - expected).max(axis=1) for counts in _counts(runs, resamples, seed)]
    c = _high(np.concatenate(largest), confidence)
    first, last = int(np.ceil(below - c)) - 1, int(np.ceil(below + c))
    nothing = np.full(columns.shape[1], np.inf)
    low = ordered[first] if first >= 0 else -nothing
    high = ordered[last] if last < runs else nothing
    return Intervals(ordered[expected - 1], low, high)


def percentiles(value: Array, resamples: Array, confidence: float) -> Intervals:
    """Values (k,) with intervals that hold all at once, from their values in resamples (R, k).

    The ends are quantiles of the resamples, of one share for both sides of all columns. A side that resamples make
    infinite, or not a number, is not bounded; nor is a value that is not finite.
    """
    with np.errstate(invalid="ignore"):
        off = resamples - value
    off = np.where(np.isnan(off), np.inf, off)
    down = np.where(np.isnan(resamples), np.inf, -off)
    ends = np.maximum(_balanced(np.concatenate([down, off], axis=1), confidence), 0).reshape(2, -1)
    with np.errstate(invalid="ignore"):
        low, high = value - ends[0], value + ends[1]
    known = np.isfinite(value)
    nothing = np.isnan(value)
    low = np.where(known, low, np.where(nothing, -np.inf, value))
    return Intervals(value, low, np.where(known, high, np.where(nothing, np.inf, value)))


def likely_quantiles(columns: Array, share: float, resamples: int, seed: int) -> Array:
    """The places where quantiles of columns (N, k) may lie, (R, k): the middle of y_(B*) and y_(B*+1), resampled."""
    below, expected, lower, ordered = _halves(columns, share)
    beyond = np.full((1, columns.shape[1]), np.inf)
    padded = np.concatenate([-beyond, ordered, beyond])
    parts = []
    for counts in _counts(len(columns), resamples, seed):
        place, rest = np.divmod(counts @ lower - expected + below + 0.5, 1)
        one, two = (np.take_along_axis(padded, place.astype(np.intp) + i, axis=0) for i in (0, 1))
        with np.errstate(invalid="ignore"):
            parts.append(np.where(np.isinf(one) | (rest == 0), one, one + rest * (two - one)))
    return np.concatenate(parts)


def resampled_tails(columns: Array, share: float, resamples: int, seed: int) -> Array:
    """The means of the largest 1 - share of finite columns (N, k) in each resample, (R, k)."""
    runs, below = len(columns), len(columns) * share
    found = []
    for column in columns.T:
        order, parts = np.argsort(column, kind="stable"), []
        for counts in _counts(runs, resamples, seed):
            held = np.cumsum(np.ascontiguousarray(counts.T[order]), axis=0)  # up to each draw, in this order
            first = int((held < below).all(axis=1).sum())
            within = np.diff(np.maximum(held[first:], below), axis=0, prepend=below)  # of each draw, how much is tail
            parts.append(column[order][first:] @ within / (runs - below))
        found.append(np.concatenate(parts))
    return np.stack(found, axis=1)


def place_of(runs: int, share: float) -> int:
    """The place, from 0, of a quantile among so many ordered values: the least that so large a share do not exceed."""
    return int(np.ceil(round(runs * share, 9))) - 1


def _halves(columns: Array, share: float) -> tuple[float, int, Array, Array]:
    """N p, the draws in the lower share, a table of them by column with ties split, and the columns in order."""
    runs, expected = len(columns), place_of(len(columns), share) + 1
    order = np.argsort(columns, axis=0, kind="stable")
    lower = np.empty(columns.shape)
    np.put_along_axis(lower, order, (np.arange(runs) < expected)[:, None] * np.ones(columns.shape), axis=0)
    return round(runs * share, 9), expected, lower, np.take_along_axis(columns, order, axis=0)


def _high(values: Array, share: float) -> Array:
    """The quantile along the first axis, an entry not below it; infinite entries allowed."""
    place = int(np.ceil(share * (len(values) - 1)))
    return np.asarray(np.partition(values, place, axis=0)[place])


def _balanced(t: Array, confidence: float) -> Array:
    """A quantile of each column, all of one share, below which whole rows lie in a share that is the confidence.

    Beyond what so many rows can tell, a column goes on from its own quantile as the normal law does, to the share by
    Bonferroni. It is infinite where the column is so in more rows than its part of what may be missed.
    """
    rows, columns = t.shape
    missed = (1 - confidence) / max(columns, 1)
    bounded = np.flatnonzero(np.isposinf(t).mean(axis=0) <= missed)
    found = np.full(columns, np.inf)
    worst = np.zeros(rows)
    ordered = {k: np.sort(t[:, k]) for k in bounded}
    for k, column in ordered.items():
        np.maximum(worst, np.searchsorted(column, t[:, k]).astype(float), out=worst)  # of equal ones the first
    place = int(_high(worst, confidence))
    found[bounded] = [column[place] for column in ordered.values()]
    if place >= rows - BEYOND:
        told = [column[rows - MIN_TAIL_RESAMPLES] for column in ordered.values()]
        found[bounded] = np.maximum(
            found[bounded], np.array(told) * ndtri(1 - missed) / ndtri(1 - MIN_TAIL_RESAMPLES / rows)
        )
    return found


def _counts(runs: int, resamples: int, seed: int) -> Iterator[Array]:
    """The times that each of N draws comes in a resample, (some, N) at a time: each resample from its own numbers."""
    some = max(1, BLOCK // runs)
    for first in range(0, resamples, some):
        yield _drawn(runs, first, min(first + some, resamples), seed)


@lru_cache(maxsize=2)  # of a study's many comparisons each asks for the same resamples
def _drawn(runs: int, first: int, last: int, seed: int) -> Array:
    drawn = (uniforms(seed, first, last, runs) * runs).astype(np.intp)
    drawn += runs * np.arange(last - first)[:, None]
    found = np.bincount(drawn.ravel(), minlength=runs * (last - first)).reshape(last - first, runs).astype(float)
    found.flags.writeable = False
    return found
