"""Comparison: how far laws are apart in the same draws, all pairs at once, and who is best by one estimand."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np

from workbench.study.evidence.bootstrap import Intervals
from workbench.study.evidence.estimands import Estimand, Median, Success, blur, flaw, intervals
from workbench.study.evidence.paired import Paired
from workbench.study.sensitivity.outputs import t_quantile
from workbench.validation.doors import door
from workbench.validation.words import seed as as_seed
from workbench.validation.words import whole

RESAMPLES = 4000
MEDIAN = Median()


@dataclass(frozen=True, eq=False)
@door
class Comparison:
    """An estimand of a metric over draws, and its differences between laws, with simultaneous intervals.

    Attributes
    ----------
    level
        (L,), the estimand of each law; infinite where too many runs failed for it.
    difference
        (L, L), that of the law of the row minus that of the column; NaN where both are infinite.
    margin
        The share of the smaller level that a difference must be beyond to count; for `Success` the share of the draws.
    """

    paired: Paired
    estimand: Estimand
    confidence: float
    level: Intervals
    difference: Intervals
    margin: float = 0.0

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
        both = self.level.value[[i, j]]
        least = 1.0 if isinstance(self.estimand, Success) else np.abs(both).min()
        share = self.margin * least if self.margin and np.isfinite(least) else 0.0
        steps = blur(self.estimand, self.paired.values[:, [i, j]], self.paired.errors[[i, j]]).sum()
        return float(self.difference.low[i, j]), float(self.difference.high[i, j]), float(steps), float(share)

    @property
    def best(self) -> str | None:
        """The law that is significantly below every other by this estimand alone; None if there is none.

        No verdict by itself: a `Judgement` says whether other estimands reverse it.
        """
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
        """What must stand below a table beside the runs: the estimand, its intervals, and when a difference counts."""
        words = self.estimand.words
        return f"{words[0].upper()}{words[1:]} over the draws; {self.holds}."

    @property
    def holds(self) -> str:
        """What the intervals hold, and when a difference counts."""
        of = " of the draws" if isinstance(self.estimand, Success) else ""
        beyond = f", and a difference counts beyond {100 * self.margin:g} %{of}" if self.margin else ""
        return f"intervals hold all at once with {100 * self.confidence:g} %{beyond}"


@door
def compare(
    paired: Paired,
    estimand: Estimand = MEDIAN,
    *,
    confidence: float = 0.95,
    margin: float = 0.0,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> Comparison:
    """All laws and all pairs of them by a bootstrap over draws, which keeps the runs of a draw together.

    The intervals of all levels hold at once with the confidence, and so do those of all differences; see the estimands
    for how. A failed run is worse than any other: a law that has one has an infinite mean and tail, and is above every
    law that has none; two such laws are undecided.

    Parameters
    ----------
    margin
        Of the smaller level, or for `Success` of the draws: a difference within it is significant for nobody, however
        sure.

    Raises
    ------
    ValueError
        If an argument has the wrong kind, there are fewer than 100 resamples or too few draws for the estimand, or the
        margin does not lie between 0 and 1.
    """
    t_quantile("compare", confidence, 1)  # refuses what is no confidence
    if not 0 <= margin < 1:
        raise ValueError(f"`compare(margin=...)` must be a share from 0 to 1 of the smaller level; got {margin}.")
    whole("compare(resamples=...)", resamples, 100)
    as_seed("compare(seed=...)", seed)
    if why := flaw(estimand, len(paired)):
        raise ValueError(f"`compare(estimand={estimand})` {why}: take more draws, or a share nearer to one half.")
    level, apart = (
        intervals(estimand, paired.values, pairs, confidence, resamples, seed)
        for pairs in (None, list(combinations(range(len(paired.laws)), 2)))
    )
    return Comparison(paired, estimand, confidence, level, _square(apart, len(paired.laws)), margin=margin)


def _square(apart: Intervals, laws: int) -> Intervals:
    """The intervals of all pairs, and with their sign turned those of the pairs turned round."""
    upper = np.triu_indices(laws, 1)
    value, low, high = np.zeros((3, laws, laws))
    for part, above, below in (
        (value, apart.value, apart.value),
        (low, apart.low, apart.high),
        (high, apart.high, apart.low),
    ):
        part[upper], part.T[upper] = above, -below
    return Intervals(value, low, high)
