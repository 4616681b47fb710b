"""Estimands: the number of a law's runs that a comparison asks for, with intervals of it and of its differences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
from scipy.special import ndtri

from workbench.core.validation.refusals import Array, finite
from workbench.core.validation.signatures import check_arguments
from workbench.study.evidence import bootstrap
from workbench.study.evidence.bootstrap import Intervals
from workbench.study.evidence.paired_samples import LEAST
from workbench.study.uncertainty.outputs import LEAST_SPREAD, Flags
from workbench.study.uncertainty.quantiles import share as share_of

BEYOND = 10  # draws on each side of a quantile, below which no interval of it or of a tail holds what it says

Pairs = list[tuple[int, int]]


@dataclass(frozen=True)
@check_arguments
class Mean:
    """The mean over the draws; infinite for a law that has a failed run.

    Intervals are those of the studentised bootstrap.
    """

    words: ClassVar = "mean"


@dataclass(frozen=True)
@check_arguments
class Quantile:
    """The least value that a `share` of the draws do not exceed; finite while failures are fewer than the other draws.

    The interval of a level lies between order statistics. A difference is that between the quantiles of two laws; its
    interval is a percentile interval.

    Examples
    --------
    >>> from workbench.study.evidence import Quantile
    >>> Quantile(0.6).words
    '60 % quantile'
    """

    share: float

    def __post_init__(self) -> None:
        _check_share("Quantile", self.share)

    @property
    def words(self) -> str:
        """The name of the estimand."""
        return f"{100 * self.share:g} % quantile"


@dataclass(frozen=True)
@check_arguments
class Median:
    """The quantile of one half; a difference is that of two medians, which is not the median of the differences."""

    words: ClassVar = "median"


@dataclass(frozen=True)
@check_arguments
class Tail:
    """The mean of the worst 1 - share of the draws, known as CVaR or expected shortfall; infinite with a failed run.

        CVaR = min_q q + mean(max(y - q, 0)) / (1 - share),   least at the quantile q

    An interval contains the studentised interval of that mean at the sample's q, and the percentile interval of the
    resampled minima. With 160 draws and a confidence of 95 % it covers 94 % for a lognormal tail, and 92 % if the third
    moment is infinite.

    Examples
    --------
    >>> from workbench.study.evidence import Tail
    >>> Tail(0.5).words
    'mean of the worst 50 %'
    """

    share: float

    def __post_init__(self) -> None:
        _check_share("Tail", self.share)

    @property
    def words(self) -> str:
        """The name of the estimand."""
        return f"mean of the worst {100 * (1 - self.share):g} %"


@dataclass(frozen=True)
@check_arguments
class Success:
    """The share of draws with a value of at most `limit`, kept as the share of the other draws: less is better.

    A failed run counts as above the limit. Levels have the interval of Clopper and Pearson. Differences have that of
    Bonett and Price for paired shares, with one draw more of each kind in which two laws differ. All intervals hold at
    once, by Bonferroni.

    References
    ----------
    Bonett, Price, "Adjusted Wald confidence interval for a difference of binomial proportions based on paired data",
    Journal of Educational and Behavioral Statistics 37 (2012).

    Examples
    --------
    >>> from workbench.study.evidence import Success
    >>> Success(2.5).words
    'success (<= 2.5)'
    """

    limit: float

    def __post_init__(self) -> None:
        finite("Success(limit=...)", self.limit)

    @property
    def words(self) -> str:
        """The name of the estimand."""
        return f"success (<= {self.limit:g})"


Estimand = Mean | Median | Quantile | Tail | Success


def words_of(estimand: Estimand, metric: str) -> str:
    """The name of an estimand with that of its metric."""
    match estimand:
        case Success(limit):
            return f"success ({metric} <= {limit:g})"
        case Mean() | Median():
            return f"{estimand.words} {metric}"
    return f"{estimand.words} of {metric}"


def unit_of_estimand(estimand: Estimand, unit: str) -> str:
    """The unit in which an estimand of a metric is shown."""
    return "%" if isinstance(estimand, Success) else unit


def flaw(estimand: Estimand, runs: int) -> str:
    """The reason why so many runs are too few for an estimand; empty if they are enough."""
    beyond, where = _beyond(estimand)
    if (there := int(round(runs * beyond, 9))) >= BEYOND or not where:
        return ""
    return f"needs at least {BEYOND} draws {where} for an interval that holds; {runs} draws have {there}"


def _beyond(estimand: Estimand) -> tuple[float, str]:
    """The share of the draws that lies beyond an estimand, and where that is; 1 and no place if none is set apart."""
    match estimand:
        case Quantile(share):
            return min(share, 1 - share), "beyond it"
        case Tail(share):
            return 1 - share, "in the tail"
    return 1.0, ""


@check_arguments
def least_draws(estimands: tuple[Estimand, ...]) -> int:
    """The least number of draws with which `compare` takes some estimands.

    Examples
    --------
    >>> from workbench.study.evidence import Mean, Tail, least_draws
    >>> least_draws((Mean(), Tail(0.9)))
    100
    """
    runs = max([LEAST, *(round(BEYOND / _beyond(one)[0]) - 1 for one in estimands)])
    while any(flaw(one, runs) for one in estimands):
        runs += 1
    return runs


def blur(estimand: Estimand, values: Array, errors: Array) -> Array:
    """The error of an estimand, (L,), as values (N, L) may be off by errors (L,); NaN where these are not known."""
    if not isinstance(estimand, Success):
        return errors
    stays = np.isinf(values) | (np.abs(values - estimand.limit) > errors)
    return np.asarray(1 - stays.mean(axis=0))


def intervals(
    estimand: Estimand, values: Array, pairs: Pairs, confidence: float, resamples: int, seed: int
) -> tuple[Intervals, Intervals]:
    """An estimand of each column of values (N, L), all at once, and its differences between pairs of columns, too."""
    match estimand:
        case Mean():
            one = partial(_means, values, confidence, resamples, seed)
        case Median():
            one = partial(_quantiles, values, 0.5, confidence, resamples, seed)
        case Quantile(share):
            one = partial(_quantiles, values, share, confidence, resamples, seed)
        case Tail(share):
            y = np.where(np.isinf(values).any(axis=0), 0, values)
            resampled = bootstrap.resampled_tails(y, share, resamples, seed)
            one = partial(_tails, values, y, share, resampled, confidence, seed)
        case Success(limit):
            one = partial(_shares, (values > limit).astype(float), confidence)
    return one(None), one(pairs)


def _means(values: Array, confidence: float, resamples: int, seed: int, pairs: Pairs | None) -> Intervals:
    def summary(finite: Flags) -> Intervals:
        rounding = _rounding(values, pairs)[finite]
        return bootstrap.means(_between(values, pairs)[:, finite], rounding, confidence, resamples, seed)

    return _of_finite(values, pairs, summary)


def _quantiles(
    values: Array, share: float, confidence: float, resamples: int, seed: int, pairs: Pairs | None
) -> Intervals:
    if pairs is None:
        return bootstrap.order_statistics(values, share, confidence, resamples, seed)
    level = np.sort(values, axis=0)[bootstrap.place_of(len(values), share)]
    resampled = bootstrap.likely_quantiles(values, share, resamples, seed)
    return bootstrap.percentiles(_between(level[None], pairs)[0], _between(resampled, pairs), confidence)


def _tails(
    values: Array, y: Array, share: float, resampled: Array, confidence: float, seed: int, pairs: Pairs | None
) -> Intervals:
    """The mean of the worst part of values, and of the same values with zeros in columns that have failed runs."""
    q = np.sort(y, axis=0)[bootstrap.place_of(len(y), share)]
    parts = q + np.maximum(y - q, 0) / (1 - share)

    def summary(finite: Flags) -> Intervals:
        rounding = _rounding(parts, pairs)[finite]
        one = bootstrap.means(_between(parts, pairs)[:, finite], rounding, confidence, len(resampled), seed)
        two = bootstrap.percentiles(one.value, _between(resampled, pairs)[:, finite], confidence)
        return Intervals(one.value, np.minimum(one.low, two.low), np.maximum(one.high, two.high))

    return _of_finite(values, pairs, summary)


def _shares(lost: Array, confidence: float, pairs: Pairs | None) -> Intervals:
    apart = _between(lost, pairs)
    runs, columns = apart.shape
    alone = 1 - (1 - confidence) / columns
    if pairs is None:
        shares = [share_of(column, alone) for column in lost.T]
        return Intervals(*(np.array([getattr(s, end) for s in shares]) for end in ("value", "low", "high")))
    more, less = ((np.sum(apart == sign, axis=0) + 1) / (runs + 2) for sign in (1, -1))
    half = ndtri(0.5 + alone / 2) * np.sqrt((more + less - (more - less) ** 2) / (runs + 2))
    value = apart.mean(axis=0)
    low, high = np.maximum(more - less - half, -1), np.minimum(more - less + half, 1)
    return Intervals(value, np.minimum(low, value), np.maximum(high, value))


def _between(columns: Array, pairs: Pairs | None) -> Array:
    """The columns, or the differences of pairs of them; NaN where both are infinite."""
    if pairs is None:
        return columns
    with np.errstate(invalid="ignore"):
        return columns[:, [i for i, _ in pairs]] - columns[:, [j for _, j in pairs]]


def _rounding(values: Array, pairs: Pairs | None) -> Array:
    """The variation of columns, or of differences of pairs of them, by rounding alone."""
    size = LEAST_SPREAD * np.abs(values).max(axis=0)
    return size if pairs is None else np.array([max(size[i], size[j]) for i, j in pairs])


def _of_finite(values: Array, pairs: Pairs | None, summary: Callable[[Flags], Intervals]) -> Intervals:
    """The summary of finite columns; a law with a failed run is infinitely above, two such are unknown."""
    value = _between(np.where(np.isinf(values).any(axis=0), np.inf, 0.0)[None], pairs)[0]
    known = value == 0
    low, high = np.where(np.isnan(value), -np.inf, value), np.where(np.isnan(value), np.inf, value)
    if known.any():
        found = summary(known)
        value[known], low[known], high[known] = found.value, found.low, found.high
    return Intervals(value, low, high)


def _check_share(call: str, share: float) -> None:
    if not 0 < share < 1:
        raise ValueError(f"`{call}(share=...)` must be a share of the draws between 0 and 1; got {share}.")
