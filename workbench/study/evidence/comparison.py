"""Comparison: how far laws are apart in the same draws, all pairs at once, and who is best."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Literal

import numpy as np

from workbench.study.evidence.bootstrap import Intervals, means, medians
from workbench.study.evidence.paired import Paired
from workbench.study.sensitivity.outputs import t_quantile
from workbench.validation.doors import door
from workbench.validation.words import Array, whole
from workbench.validation.words import seed as as_seed

RESAMPLES = 4000


@dataclass(frozen=True, eq=False)
@door
class Comparison:
    """Means or medians of a metric over draws, and of its paired differences, with simultaneous intervals.

    Attributes
    ----------
    level
        (L,), the mean or the median of each law.
    difference
        (L, L), that of the law of the row minus the law of the column, draw by draw.
    margin
        The share of the smaller level that a difference must be beyond to count.
    refused
        The reason for each law that has no mean; its numbers are NaN.
    """

    paired: Paired
    statistic: Literal["mean", "median"]
    confidence: float
    level: Intervals
    difference: Intervals
    margin: float = 0.0
    refused: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        laws = len(self.paired.laws)
        for name, part, shape in (("level", self.level, (laws,)), ("difference", self.difference, (laws, laws))):
            if part.value.shape != shape:
                raise ValueError(f"`Comparison({name}=...)` must have shape {shape}; got {part.value.shape}.")

    @door
    def order(self, a: str, b: str) -> Literal["below", "above", "undecided"]:
        """Whether law a is significantly below law b, or above: by an interval beyond the margin and the steps' errors.

        Both together, as the errors of the steps may be what carries an interval over the margin.

        Where all of the interval is infinite, as one of them fails too often, no error of the step counts.
        """
        low, high, steps, share = self._apart(a, b)
        off = steps + share  # NaN where an error of the step is not known
        if high < -off or high == -np.inf:
            return "below"
        return "above" if low > off or low == np.inf else "undecided"

    @door
    def alike(self, a: str, b: str) -> bool:
        """Whether the interval of the difference of two laws, with the steps' errors, lies within the margin.

        Two laws that both fail too often for a level are not alike: nobody knows how far apart they would be.
        """
        low, high, steps, share = self._apart(a, b)
        known = np.isfinite([self.level.value[self.paired.place(law)] for law in (a, b)]).all()
        return bool(known and max(-low, high) + steps <= share)

    def _apart(self, a: str, b: str) -> tuple[float, float, float, float]:
        """The interval of a's difference from b, the errors of both by the step, and the margin in their unit."""
        i, j = self.paired.place(a), self.paired.place(b)
        least = min(abs(self.level.value[i]), abs(self.level.value[j]))
        share = self.margin * least if self.margin and np.isfinite(least) else 0.0
        steps = float(self.paired.errors[i] + self.paired.errors[j])
        return float(self.difference.low[i, j]), float(self.difference.high[i, j]), steps, float(share)

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
        """What must stand below a table beside the runs: the statistic, its intervals, and when a difference counts."""
        beyond = f", and a difference counts beyond {100 * self.margin:g} %" if self.margin else ""
        level = f"{100 * self.confidence:g} %"
        return f"{self.statistic.capitalize()}s over the draws; intervals hold all at once with {level}{beyond}."


@door
def compare(
    paired: Paired,
    statistic: Literal["mean", "median"] = "median",
    *,
    confidence: float = 0.95,
    margin: float = 0.0,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> Comparison:
    """All laws and all pairs of them by a bootstrap over draws, which keeps the runs of a draw together.

    The intervals of all levels hold at once with the confidence, and so do those of all differences; see `means` and
    `medians` of `bootstrap` for how. A failed run is worse than any other: a law that has one has no mean, and is
    refused by name; its median and the order of laws are defined. Where both of a pair failed they are equal.

    Parameters
    ----------
    margin
        Of the smaller level: a difference within that share of it is significant for nobody, however sure.

    Raises
    ------
    ValueError
        If an argument has the wrong kind, there are fewer than 100 resamples, the margin does not lie between 0 and
        1, or every law is refused.
    """
    t_quantile("compare", confidence, 1)  # refuses what is no confidence
    if not 0 <= margin < 1:
        raise ValueError(f"`compare(margin=...)` must be a share from 0 to 1 of the smaller level; got {margin}.")
    whole("compare(resamples=...)", resamples, 100)
    as_seed("compare(seed=...)", seed)
    laws = len(paired.laws)
    refused = _without_mean(paired) if statistic == "mean" else {}
    kept = [i for i, law in enumerate(paired.laws) if law not in refused]
    if not kept:
        raise ValueError(f"`compare(statistic='mean')` has no law left: {'; '.join(refused.values())}.")
    summary = means if statistic == "mean" else medians
    found = summary(paired.values[:, kept], confidence, resamples, seed)
    level = Intervals(*(_spread(part, kept, laws) for part in (found.value, found.low, found.high)))
    pairs = list(combinations(kept, 2))
    none = Intervals(*(np.empty(0),) * 3)
    apart = summary(_differences(paired.values, pairs), confidence, resamples, seed) if pairs else none
    return Comparison(
        paired, statistic, confidence, level, _square(apart, pairs, laws, kept), margin=margin, refused=refused
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
