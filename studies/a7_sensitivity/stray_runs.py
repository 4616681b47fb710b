"""The runs that stray from their reference: how many of each law, and whether they come back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.a7_sensitivity.late_errors import EXACT
from studies.a7_sensitivity.results import LawResults, percent
from studies.a7_sensitivity.second_looks import (
    ASTRAY,
    BOUNDS,
    FROM,
    TO,
    Later,
    beyond,
    late_errors_of,
    redrawn_words,
    suspects,
)
from studies.a7_sensitivity.sweeps import LATE, LAWS, PROPOSED_LAW, UNTIL

FEW = 0.01  # of the runs


@dataclass(frozen=True, eq=False)
class Strays:
    """The runs of a law beyond a bound from `LATE` to `UNTIL`, and those of them that still are from `FROM` to `TO`."""

    runs: int
    first: int
    lasting_strays: int
    random: int  # of the lasting ones, those among the random draws
    draws: int

    @property
    def answer(self) -> str:
        """The share of the runs that stray for good, in words."""
        if not self.lasting_strays:
            return "none"
        few = self.lasting_strays < FEW * self.runs
        return f"fewer than {percent(FEW)}" if few else f"{percent(FEW)} or more"

    @property
    def words(self) -> str:
        """The counts."""
        part = wb.uncertainty.share(np.arange(self.draws) < self.random)
        again = f", {self.lasting_strays:,} of these also from {FROM:g} to {TO:g} s" if self.first else ""
        return (
            f"{self.first:,} of {self.runs:,} from {LATE:g} to {UNTIL:g} s{again}; of random draws "
            f"{percent(part.low)} to {percent(part.high)}"
        )


def strays_of(one: LawResults, later: Sequence[Later], bound: float = ASTRAY) -> Strays:
    """The counts of a law; `later` has the second look at the suspects of each of its samples that has any."""
    looks = iter(later)
    first = lasting = random = 0
    for sample in one.samples:
        errors = late_errors_of(sample)
        if not (flags := beyond(errors, min(BOUNDS))).any():
            continue
        astray = beyond(errors[flags], bound)
        stay = astray & beyond(next(looks).errors, bound)
        first, lasting = first + int(astray.sum()), lasting + int(stay.sum())
        random += int(stay.sum()) if sample is one.random else 0
    return Strays(sum(map(len, one.samples)), first, lasting, random, len(one.random))


def later_by_law(laws: Mapping[str, LawResults], answers: Sequence[Later]) -> dict[str, tuple[Later, ...]]:
    """The answers of the second look, law by law."""
    looks = iter(answers)
    return {law: tuple(next(looks) for _ in suspects(laws[law])) for law in LAWS if law in laws}


def strays(
    laws: Mapping[str, LawResults], later: Mapping[str, Sequence[Later]], redraws: Later, own: Mapping[str, float]
) -> wb.Finding:
    """The number of runs that leave their reference for good; `own` are the late errors with the card's numbers."""
    counts = {law: strays_of(one, later[law]) for law, one in laws.items()}
    ours, others = counts[PROPOSED_LAW], [law for law in laws if law != PROPOSED_LAW]
    worst = max(np.nanmax(late_errors_of(sample)) for sample in laws[PROPOSED_LAW].samples)
    part = wb.uncertainty.share(np.arange(ours.draws) < ours.random)
    bounds = {bound: strays_of(laws[PROPOSED_LAW], later[PROPOSED_LAW], bound) for bound in BOUNDS}
    return wb.Finding(
        "strays",
        f"The error of a joint exceeds {ASTRAY:g} rad between {LATE:g} and {UNTIL:g} s in {ours.first:,} of "
        f"{ours.runs:,} runs of {PROPOSED_LAW}, and in {ours.lasting_strays:,} of these also between {FROM:g} and "
        f"{TO:g} s.",
        f"The largest error between {LATE:g} and {UNTIL:g} s is {worst:.2g} rad. Of the random draws of "
        f"{PROPOSED_LAW}, {percent(part.low)} to {percent(part.high)} are beyond {ASTRAY:g} rad at both times. "
        f"{redrawn_words(laws[PROPOSED_LAW], redraws)} {slow_words(counts, own)}",
        statistic="Counts over all runs of a law. They are not probabilities, as the runs include the corners of the "
        "screening. Shares of the random draws have the 95 % interval of Clopper and Pearson. A run that diverges "
        "counts.",
        sample=f"All runs of each law: screening, indices and random draws; for {PROPOSED_LAW} also the tornado and "
        "the indices with equal ranges.",
        information=f"{EXACT}. SMC has the gain of 5 N m that report a1 assumes.",
        assumptions="The ranges, and the gains of the rivals.",
        answer=ours.answer,
        variations=(
            *(wb.Variation(f"a bound of {bound:g} rad", one.answer, one.words) for bound, one in bounds.items()),
            *(wb.Variation(law, counts[law].answer, counts[law].words) for law in others),
        ),
        limitations=f"Runs that leave their reference after {UNTIL:g} s; ranges without the corners of the screening; "
        "a larger gain of SMC.",
    )


def slow_words(counts: Mapping[str, Strays], own: Mapping[str, float]) -> str:
    """The rivals that exceed the bound at first: whether they stray or arrive late."""
    slow = [law for law, one in counts.items() if law != PROPOSED_LAW and one.first]
    if not slow:
        return f"No run of the other {len(counts) - 1} laws exceeds {ASTRAY:g} rad after {LATE:g} s."
    parts = [
        f"{law} exceeds {ASTRAY:g} rad in {counts[law].first:,} of {counts[law].runs:,} runs from {LATE:g} to "
        f"{UNTIL:g} s, and in {counts[law].lasting_strays:,} of these also from {FROM:g} to {TO:g} s: the other runs "
        f"only arrive late. With the numbers of the card and an exact model, the error of {law} from {LATE:g} s on is "
        f"{own[law]:.2f} rad."
        for law in slow
    ]
    return " ".join(parts)
