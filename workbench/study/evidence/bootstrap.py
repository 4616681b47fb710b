"""Simultaneous intervals of means and medians: one bootstrap of whole draws for all columns together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from workbench.study.sampling.contract import uniforms
from workbench.study.sensitivity.outputs import check_size
from workbench.validation.doors import door
from workbench.validation.words import Array

BLOCK = 2**22  # counts in memory at once


@dataclass(frozen=True, eq=False)
@door
class Intervals:
    """Values, each with an interval; ends are infinite where there are too few draws to bound them."""

    value: Array
    low: Array
    high: Array

    def __post_init__(self) -> None:
        for part in (self.value, self.low, self.high):
            check_size("Intervals(value, low, high)", part, infinite=True)
        if not self.value.shape == self.low.shape == self.high.shape:
            shapes = ", ".join(str(part.shape) for part in (self.value, self.low, self.high))
            raise ValueError(f"`Intervals(value, low, high)` must have two ends for each value; got shapes {shapes}.")


def means(columns: Array, confidence: float, resamples: int, seed: int) -> Intervals:
    """The means of finite columns (N, k), between ends that hold all of them at once with the confidence.

        mean +- c s / sqrt(N),    c the quantile of max_k |mean*_k - mean_k| sqrt(N) / s*_k

    over resampled draws *: the studentised bootstrap with its largest statistic.
    """
    runs = len(columns)
    middle = columns.mean(axis=0)
    left = columns - middle
    size = np.abs(left).max(axis=0)
    left /= np.where(size > 0, size, 1)  # no square overflows, and none loses its digits
    largest = []
    for counts in _counts(runs, resamples, seed):
        mean = counts @ left / runs
        spread = np.sqrt(np.maximum(counts @ left**2 / runs - mean**2, 0))
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.where(mean == 0, 0.0, np.abs(mean) / spread)  # a column that does not vary is known exactly
        largest.append(t.max(axis=1))
    c = np.quantile(np.concatenate(largest), confidence, method="higher")
    varies = size > 0
    half = np.zeros(len(middle))
    half[varies] = c * left.std(axis=0)[varies] * size[varies]
    return Intervals(middle, middle - half, middle + half)


def medians(columns: Array, confidence: float, resamples: int, seed: int) -> Intervals:
    """The medians of columns (N, k), infinite entries allowed, between order statistics that hold all at once.

        y_(N/2 - c) <= median <= y_(N/2 + c + 1),    c the quantile of max_k |B*_k - N/2|

    with B*_k how many of the resampled draws fall into the lower half of column k. For one column B is binomial
    and the interval that of the sign test; for several the bootstrap knows how they move together.
    """
    runs = len(columns)
    order = np.argsort(columns, axis=0, kind="stable")
    lower = np.empty(columns.shape)  # ties are split, so that exactly half of the draws are below
    np.put_along_axis(lower, order, np.broadcast_to((np.arange(runs) < runs / 2)[:, None], order.shape) * 1.0, axis=0)
    expected = lower.sum(axis=0)
    largest = [np.abs(counts @ lower - expected).max(axis=1) for counts in _counts(runs, resamples, seed)]
    c = np.quantile(np.concatenate(largest), confidence, method="higher")
    ordered = np.take_along_axis(columns, order, axis=0)
    first, last = int(np.ceil(runs / 2 - c)) - 1, int(np.floor(runs / 2 + c))
    nothing = np.full(columns.shape[1], np.inf)
    low = ordered[first] if first >= 0 else -nothing
    high = ordered[last] if last < runs else nothing
    return Intervals(ordered[(runs - 1) // 2], low, high)


def _counts(runs: int, resamples: int, seed: int) -> Iterator[Array]:
    """How often each of N draws comes in a resample, (some, N) at a time: each resample from its own numbers."""
    some = max(1, BLOCK // runs)
    for first in range(0, resamples, some):
        yield _drawn(runs, first, min(first + some, resamples), seed)


@lru_cache(maxsize=1)  # of a study's many comparisons each asks for the same resamples
def _drawn(runs: int, first: int, last: int, seed: int) -> Array:
    drawn = (uniforms(seed, first, last, runs) * runs).astype(np.intp)
    drawn += runs * np.arange(last - first)[:, None]
    found = np.bincount(drawn.ravel(), minlength=runs * (last - first)).reshape(last - first, runs).astype(float)
    found.flags.writeable = False
    return found
