"""Comparison: how far laws are apart in the same draws, all pairs at once, and who is best."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Literal

import numpy as np

from workbench.core.layout import Array
from workbench.core.sockets import require
from workbench.study.evidence.bootstrap import Intervals, means, medians
from workbench.study.evidence.paired import Paired
from workbench.study.sampling.contract import seeded, whole
from workbench.study.sensitivity.outputs import t_quantile

RESAMPLES = 4000


@dataclass(frozen=True, eq=False)
class Comparison:
    """Means or medians of a metric over draws, and of its paired differences, with simultaneous intervals.

    Attributes
    ----------
    level
        (L,), the mean or the median of each law.
    difference
        (L, L), that of the law of the row minus the law of the column, draw by draw.
    refused
        The reason for each law that has no mean; its numbers are NaN.
    """

    paired: Paired
    statistic: Literal["mean", "median"]
    confidence: float
    level: Intervals
    difference: Intervals
    refused: Mapping[str, str] = field(default_factory=dict)

    def order(self, a: str, b: str) -> Literal["below", "above", "undecided"]:
        """Whether law a is significantly below law b, or above: by more than the interval and the steps' errors."""
        i, j = self.paired.place(a), self.paired.place(b)
        off = self.paired.errors[i] + self.paired.errors[j]
        if self.difference.high[i, j] < -off:
            return "below"
        return "above" if self.difference.low[i, j] > off else "undecided"

    @property
    def best(self) -> str | None:
        """The law that is significantly below every other; None if there is none."""
        for law in self.paired.laws:
            if all(law == other or self.order(law, other) == "below" for other in self.paired.laws):
                return law
        return None

    @property
    def leaders(self) -> tuple[str, ...]:
        """The laws that no other is significantly below."""
        laws = self.paired.laws
        return tuple(law for law in laws if all(self.order(law, other) != "above" for other in laws))

    @property
    def said(self) -> str:
        """What must stand below a table: the statistic, its intervals, and the runs behind them."""
        of = f"{self.statistic}s over the draws; intervals hold all at once with {100 * self.confidence:g} %"
        return f"{self.paired.said[:-1]}; {of}."


def compare(
    paired: Paired,
    statistic: Literal["mean", "median"] = "median",
    *,
    confidence: float = 0.95,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> Comparison:
    """All laws and all pairs of them by a bootstrap over draws, which keeps the runs of a draw together.

    The intervals of all levels hold at once with the confidence, and so do those of all differences; see `means` and
    `medians` of `bootstrap` for how. A failed run is worse than any other: a law that has one has no mean, and is
    refused by name; its median and the order of laws are defined. Where both of a pair failed they are equal.

    Raises
    ------
    ValueError
        If an argument has the wrong kind, there are fewer than 100 resamples, or every law is refused.
    """
    require("compare(paired)", paired, Paired)
    if statistic not in ("mean", "median"):
        raise ValueError(f"`compare(statistic=...)` is 'mean' or 'median'; got {statistic!r}.")
    t_quantile("compare", confidence, 1)  # refuses what is no confidence
    whole("compare(resamples=...)", resamples, 100, "resamples")
    seeded("compare(seed=...)", seed)
    refused = _without_mean(paired) if statistic == "mean" else {}
    kept = [i for i, law in enumerate(paired.laws) if law not in refused]
    if not kept:
        raise ValueError(f"`compare(statistic='mean')` has no law left: {'; '.join(refused.values())}.")
    summary = means if statistic == "mean" else medians
    level = summary(paired.values[:, kept], confidence, resamples, seed)
    pairs = list(combinations(kept, 2))
    if pairs:
        apart = summary(_differences(paired.values, pairs), confidence, resamples, seed)
    else:
        apart = Intervals(*(np.empty(0),) * 3)
    return Comparison(
        paired,
        statistic,
        confidence,
        Intervals(*(_spread(part, kept, len(paired.laws)) for part in (level.value, level.low, level.high))),
        _square(apart, pairs, len(paired.laws), kept),
        refused,
    )


def _without_mean(paired: Paired) -> dict[str, str]:
    """Why a law has no mean."""
    found = {}
    for law, column, failed in zip(paired.laws, paired.values.T, paired.failed, strict=True):
        if not np.isfinite(column).all():
            what = f"{failed} of its {len(column)} runs failed" if failed else "some of its runs are infinite"
            found[law] = f"{law} has no mean, as {what}: take the median"
    return found


def _differences(values: Array, pairs: list[tuple[int, int]]) -> Array:
    first, second = values[:, [i for i, _ in pairs]], values[:, [j for _, j in pairs]]
    both = np.isinf(first) & np.isinf(second)
    with np.errstate(invalid="ignore"):
        return np.where(both, 0.0, first - second)


def _spread(part: Array, kept: list[int], laws: int) -> Array:
    whole_part = np.full(laws, np.nan)
    whole_part[kept] = part
    return whole_part


def _square(apart: Intervals, pairs: list[tuple[int, int]], laws: int, kept: list[int]) -> Intervals:
    """The intervals of all pairs, and with their sign turned those of the pairs turned round."""
    value, low, high = (np.full((laws, laws), np.nan) for _ in range(3))
    for part in (value, low, high):
        part[kept, kept] = 0.0
    for (i, j), v, a, b in zip(pairs, apart.value, apart.low, apart.high, strict=True):
        value[i, j], low[i, j], high[i, j] = v, a, b
        value[j, i], low[j, i], high[j, i] = -v, -b, -a
    return Intervals(value, low, high)
