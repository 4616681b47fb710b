"""Judgement: the law that is best by the estimand that was asked, and the estimands that reverse it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from workbench.core.validation.signatures import check_arguments
from workbench.study.document.words import join_names
from workbench.study.evidence.estimands import Estimand, Success, unit_of_estimand, words_of
from workbench.study.evidence.paired_samples import PairedSamples
from workbench.study.evidence.pairwise_comparison import RESAMPLES, Comparison, compare


@dataclass(frozen=True, eq=False)
@check_arguments
class LawJudgement:
    """Comparisons of the same runs `by` several estimands, the first of which was declared before the runs."""

    by: Mapping[str, Comparison]  # by the words of each estimand

    def __post_init__(self) -> None:
        if not self.by or len({id(one.samples) for one in self.by.values()}) > 1:
            raise ValueError("`LawJudgement(by=...)` must hold comparisons of the same paired values, at least one.")
        if any(words != one.estimand.words for words, one in self.by.items()):
            raise ValueError(f"`LawJudgement(by=...)` must name each comparison by its estimand; got {list(self.by)}.")

    @property
    def samples(self) -> PairedSamples:
        """The runs."""
        return self._first.samples

    @property
    def primary(self) -> Estimand:
        """The estimand that decides, declared before the runs."""
        return self._first.estimand

    @property
    def reversals(self) -> tuple[tuple[str, str, str, str], ...]:
        """(law, other law, primary estimand, other estimand): the law is below the other law, and by the other above.

        Both differences are significant: the whole interval lies beyond the margin and the errors of the steps.
        """
        first, *others = self.by.values()
        laws = self.samples.laws
        return tuple(
            (laws[i], laws[j], first.estimand.words, other.estimand.words)
            for other in others
            for i, j in np.argwhere(first.below & other.below.T)
        )

    @property
    def kind(self) -> Literal["best", "open", "depends"]:
        """The verdict: 'depends' if another estimand reverses a leading law, or if two have different best laws."""
        leaders = self._first.leaders
        bests = {one.best for one in self.by.values()} - {None}
        if len(bests) > 1 or any(a in leaders for a, *_ in self.reversals):
            return "depends"
        return "best" if self._first.best else "open"

    @property
    def best(self) -> str | None:
        """The law that is best by the primary estimand; None if another estimand reverses this, or no law is best."""
        return self._first.best if self.kind == "best" else None

    @property
    def sentence(self) -> str:
        """The verdict in plain words, with its numbers."""
        end = "highest" if isinstance(self.primary, Success) else "least"
        least = f"{end} {words_of(self.primary, self.samples.metric)}"
        if self.kind == "depends":
            return f"depends on the statistic: {_grouped({words: _place(one) for words, one in self.by.items()})}"
        if self.kind == "open":
            return f"{least}: {_place(self._first)}"
        best = self._first.best or ""
        same = [words for words, one in list(self.by.items())[1:] if one.best == best]
        others = {words: _place(one) for words, one in list(self.by.items())[1:] if one.best != best}
        by_all = (
            "best by every other statistic too" if not others else f"best by {join_names(same)} too" if same else ""
        )
        return "; ".join(filter(None, (f"{least}: {best}, {figures(self._first, best)}", by_all, _grouped(others))))

    @property
    def _first(self) -> Comparison:
        return next(iter(self.by.values()))


@check_arguments
def judge(
    samples: PairedSamples,
    primary: Estimand,
    others: Sequence[Estimand] = (),
    *,
    confidence: float = 0.95,
    margin: float = 0.0,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> LawJudgement:
    """Judge laws by the `primary` estimand, declared before the runs, and by `others` that may reverse the verdict.

    `confidence` is for all intervals of one estimand at once; `margin`, `resamples` and `seed` are as of `compare`.

    Raises
    ------
    ValueError
        If two estimands are the same, or `compare` refuses one.

    Examples
    --------
    >>> from workbench.study.evidence import Mean, Median, judge, pair_samples
    >>> draws = np.random.default_rng(1).random(40)
    >>> errors = pair_samples({"PID": draws, "SMC": draws + 0.1}, metric="error", unit="rad")
    >>> judge(errors, Mean(), (Median(),), confidence=0.9, margin=0.02, resamples=100, seed=1).best
    'PID'
    """
    estimands = (primary, *others)
    words = [one.words for one in estimands]
    if len(set(words)) < len(words):
        raise ValueError(f"`judge(primary, others)` must be different estimands; got {', '.join(words)}.")
    found = {
        one.words: compare(samples, one, confidence=confidence, margin=margin, resamples=resamples, seed=seed)
        for one in estimands
    }
    return LawJudgement(found)


def figures(one: Comparison, law: str) -> str:
    """The level of a law with its interval, successes in percent."""
    place = one.samples.place(law)
    value, low, high = (float(part[place]) for part in (one.level.value, one.level.low, one.level.high))
    if isinstance(one.estimand, Success):
        value, low, high = (100 * (1 - end) for end in (value, high, low))
    unit = unit_of_estimand(one.estimand, one.samples.unit)
    shown = f"{value:.3g} {unit}".strip()
    return f"{shown} ({low:.3g} to {high:.3g})"


def _place(one: Comparison) -> str:
    return one.answer


def _grouped(places: Mapping[str, str]) -> str:
    laws: dict[str, list[str]] = {}
    for words, law in places.items():
        laws.setdefault(law, []).append(words)
    return "; ".join(f"{law} by {join_names(words)}" for law, words in laws.items())


@dataclass(frozen=True, eq=False)
@check_arguments
class Standings:
    """Judgements of the same laws by the same estimands in several scenarios.

    Examples
    --------
    >>> from workbench.study.evidence import Mean, Standings, judge, pair_samples
    >>> draws = np.random.default_rng(1).random(40)
    >>> errors = pair_samples({"PID": draws, "SMC": draws + 0.1}, metric="error", unit="rad")
    >>> ruling = judge(errors, Mean(), resamples=100)
    >>> Standings({"paper": ruling})
    Standings(judgements={'paper'})
    """

    judgements: Mapping[str, LawJudgement]

    def __post_init__(self) -> None:
        kinds = {(one.samples.laws, tuple(one.by)) for one in self.judgements.values()}
        if len(kinds) != 1:
            raise ValueError(
                "`Standings(judgements=...)` must have the same laws and the same estimands in each scenario; got "
                f"{len(kinds)} kinds of them."
            )

    @property
    def wins(self) -> Mapping[str, Mapping[str, tuple[str, ...]]]:
        """For each estimand in words, each law with the scenarios in which it is best by this estimand; most first."""
        ((laws, estimands),) = {(one.samples.laws, tuple(one.by)) for one in self.judgements.values()}
        found = {}
        for words in estimands:
            best = {scenario: one.by[words].best for scenario, one in self.judgements.items()}
            of = {law: tuple(scenario for scenario, first in best.items() if first == law) for law in laws}
            found[words] = dict(sorted(of.items(), key=lambda pair: -len(pair[1])))
        return found
