"""Comparison of laws in the same draws: all pairs at once by one estimand, and the ranks of the laws draw by draw."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Literal

import numpy as np

from workbench.core.validation.refusals import Array, whole
from workbench.core.validation.refusals import seed as as_seed
from workbench.core.validation.signatures import check_arguments
from workbench.study.evidence.bootstrap import Intervals
from workbench.study.evidence.estimands import Estimand, Median, Success, blur, flaw, intervals
from workbench.study.evidence.paired_samples import PairedSamples
from workbench.study.uncertainty.outputs import LARGEST, Flags, t_quantile
from workbench.study.uncertainty.quantiles import share

RESAMPLES = 4000
MEDIAN = Median()


@dataclass(frozen=True, eq=False)
@check_arguments
class Comparison:
    """An estimand of a metric over draws, and its differences between laws, with simultaneous intervals.

    `level` (L,) is the estimand of each law, infinite if too many runs failed. `difference` (L, L) is that of the law
    of the row minus that of the column, NaN if both are infinite. All intervals of either hold at once with the
    `confidence`. A difference counts beyond the `margin`, a share of the smaller level, or of the draws for
    `Success`.
    """

    samples: PairedSamples
    estimand: Estimand
    confidence: float
    level: Intervals  # (L,), the estimand of each law; infinite where too many runs failed for it
    difference: Intervals  # (L, L), of the law of the row minus that of the column; NaN where both are infinite
    margin: float = 0.0  # of the smaller level, or for `Success` of the draws, beyond which a difference counts

    def __post_init__(self) -> None:
        laws = len(self.samples.laws)
        for name, part, shape in (("level", self.level, (laws,)), ("difference", self.difference, (laws, laws))):
            if part.value.shape != shape:
                raise ValueError(f"`Comparison({name}=...)` must have shape {shape}; got {part.value.shape}.")

    @check_arguments
    def order(self, a: str, b: str) -> Literal["below", "above", "undecided"]:
        """The place of law a beside law b: the whole interval must lie beyond the margin and the steps' errors."""
        i, j = self.samples.place(a), self.samples.place(b)
        return "below" if self.below[i, j] else "above" if self.below[j, i] else "undecided"

    @cached_property
    def below(self) -> Flags:
        """(L, L), true where the law of the row is significantly below that of the column."""
        steps, margin = self._off
        high = self.difference.high
        return (high < -(steps + margin)) | np.isneginf(high)  # NaN where an error of the step is not known

    @check_arguments
    def alike(self, a: str, b: str) -> bool:
        """True if the interval of the difference between two laws, plus the errors of the steps, is within the margin.

        Two laws that both fail too often for a level are not alike.
        """
        i, j = self.samples.place(a), self.samples.place(b)
        (steps, margin), d = self._off, self.difference
        known = np.isfinite(self.level.value[[i, j]]).all()
        return bool(known and max(-d.low[i, j], d.high[i, j]) + steps[i, j] <= margin[i, j])

    @cached_property
    def _off(self) -> tuple[Array, Array]:
        """(L, L), the errors of two laws by the step together, and the margin in their unit."""
        levels = np.abs(self.level.value)
        units = np.ones_like(levels) if isinstance(self.estimand, Success) else np.minimum(levels, LARGEST)
        errors = blur(self.estimand, self.samples.values, self.samples.errors)
        return np.add.outer(errors, errors), self.margin * np.minimum.outer(units, units)

    @property
    def best(self) -> str | None:
        """The law that is significantly below every other by this estimand alone; None if there is none."""
        others = self.below.sum(axis=1)
        return next((law for law, n in zip(self.samples.laws, others, strict=True) if n == len(others) - 1), None)

    @property
    def leaders(self) -> tuple[str, ...]:
        """The laws that no other is significantly below."""
        return tuple(law for law, above in zip(self.samples.laws, self.below.T, strict=True) if not above.any())

    @property
    def answer(self) -> str:
        """The best law; where there is none, the laws between which the runs do not decide."""
        *others, last = self.leaders or ("no law",)
        return self.best or (f"open between {', '.join(others)} and {last}" if others else f"open: {last}")

    @property
    def footnote(self) -> str:
        """The note below a table: the estimand, its intervals, and when a difference counts."""
        words = self.estimand.words
        return f"{words[0].upper()}{words[1:]} over the draws; {self.holds}."

    @property
    def holds(self) -> str:
        """The confidence of the intervals, and when a difference counts."""
        of = " of the draws" if isinstance(self.estimand, Success) else ""
        beyond = f", and a difference counts beyond {100 * self.margin:g} %{of}" if self.margin else ""
        return f"all intervals hold at once with a confidence of {100 * self.confidence:g} %{beyond}"


@check_arguments
def compare(
    samples: PairedSamples,
    estimand: Estimand = MEDIAN,
    *,
    confidence: float = 0.95,
    margin: float = 0.0,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> Comparison:
    """The comparison of all laws and pairs of laws by a bootstrap over draws, which keeps the runs of a draw together.

    The intervals of all levels hold at once with the confidence, and so do those of all differences. A law with a
    failed run has an infinite mean and tail, and is above every law that has none; two such laws are undecided.

    Parameters
    ----------
    margin
        A share of the smaller level, or of the draws for `Success`. A difference within it is not significant.

    Raises
    ------
    ValueError
        If there are fewer than 100 resamples or too few draws for the estimand, or the confidence or the margin does
        not lie between 0 and 1.

    Examples
    --------
    >>> from workbench.study.evidence import Tail, compare, pair_samples
    >>> draws = np.random.default_rng(1).random(40)
    >>> errors = pair_samples({"PID": draws, "SMC": draws + 0.1}, metric="error", unit="rad")
    >>> compare(errors, Tail(0.6), confidence=0.9, margin=0.02, resamples=100, seed=1).order("PID", "SMC")
    'below'
    """
    t_quantile("compare", confidence, 1)  # refuses what is no confidence
    if not 0 <= margin < 1:
        raise ValueError(f"`compare(margin=...)` must be a share from 0 to 1 of the smaller level; got {margin}.")
    whole("compare(resamples=...)", resamples, 100, 10**6)
    as_seed("compare(seed=...)", seed)
    if why := flaw(estimand, len(samples)):
        raise ValueError(f"`compare(estimand={estimand})` {why}: take more draws, or a share nearer to one half.")
    pairs = list(combinations(range(len(samples.laws)), 2))
    level, apart = intervals(estimand, samples.values, pairs, confidence, resamples, seed)
    return Comparison(samples, estimand, confidence, level, _square(apart, len(samples.laws)), margin=margin)


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


@dataclass(frozen=True, eq=False)
@check_arguments
class Ranks:
    """Shares of the draws, each with the interval of Clopper and Pearson for one share.

    In `ranks` (L, L) the law of the row has the rank of the column, from the least value on; equal values get the worse
    rank. In `below` (L, L) the law of the row is below that of the column.
    """

    samples: PairedSamples
    confidence: float
    ranks: Intervals  # (L, L), the law of the row has the rank of the column, from the least value; equals the worse
    below: Intervals  # (L, L), the law of the row is below that of the column

    def __post_init__(self) -> None:
        laws = len(self.samples.laws)
        for name in ("ranks", "below"):
            if (shape := getattr(self, name).value.shape) != (laws, laws):
                raise ValueError(f"`Ranks({name}=...)` must have shape {(laws, laws)}; got {shape}.")


@check_arguments
def ranks(samples: PairedSamples, confidence: float = 0.95) -> Ranks:
    """Count the ranks of each law over the draws, as shares. Each interval holds for one share by itself.

    Examples
    --------
    >>> from workbench.study.evidence import pair_samples, ranks
    >>> draws = np.random.default_rng(1).random(40)
    >>> ranks(pair_samples({"PID": draws, "SMC": draws + 0.1}, metric="error", unit="rad"), 0.9)
    Ranks(samples=PairedSamples(...), confidence=0.9, ranks=Intervals(...), below=Intervals(...))
    """
    t_quantile("ranks", confidence, 1)  # refuses what is no confidence
    y = samples.values
    places = (y[:, :, None] >= y[:, None, :]).sum(axis=2)  # how many are not above, the law itself among them
    laws = len(samples.laws)
    at = places[:, :, None] == np.arange(1, laws + 1)
    below = y[:, :, None] < y[:, None, :]
    return Ranks(samples, confidence, _shares_of(at, confidence), _shares_of(below, confidence))


def _shares_of(holds: Flags, confidence: float) -> Intervals:
    found = [[share(column, confidence) for column in row.T] for row in np.moveaxis(holds, 1, 0)]
    value, low, high = (np.array([[getattr(s, end) for s in row] for row in found]) for end in ("value", "low", "high"))
    return Intervals(value, low, high)
