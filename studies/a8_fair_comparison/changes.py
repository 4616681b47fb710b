"""All that a8 has computed otherwise, in one list: each change with its answer, and none is left out by hand."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import workbench as wb
from studies.a8_fair_comparison.evidence import Evidence
from studies.paper.costs import OTHERS, PRIMARY
from studies.paper.entrants import BOTH
from studies.paper.scenarios import HELD_OUT, TRAINING

SCENARIOS = len(HELD_OUT)
SEEN_SCENARIOS = tuple(one.name for one in HELD_OUT if any(one.reference is other.reference for other in TRAINING))
MEASURE = f"{PRIMARY.words} cost"
NOBODY = "no law"
BASE: wb.evidence.Way = "geometric mean"
SUM: wb.evidence.Way = "arithmetic mean"
FITS = (
    "The parameters of the law and of its observers in the tables of the numbers as tuned, by three searches with the "
    "same budget for each parameter. Not tuned: the nodes of the network of RBF-ASMC, and the rules of Fuzzy-ASMC."
)
ASSUMPTIONS = (
    "The terms of the cost and their acceptable values, the scenarios, the ranges of the draws, the torque limit and "
    "the computer."
)
WHOLE, LESS = "over all scenarios", "that leave a scenario out"  # the questions that pooled variations answer
COUNT_QUESTION, POOL_QUESTION = "that count scenarios", "that pool scenarios"  # the questions that changes answer


@dataclass(frozen=True)
class Change:
    """One thing that is done otherwise: its words, and the scenarios in which each law is then best, or one answer."""

    words: str
    answer: str
    counts: Mapping[str, int] | None = None  # scenarios by law; None where all scenarios are judged together
    scenarios: int = SCENARIOS
    detail: str = ""

    @property
    def variation(self) -> wb.Variation:
        """The change as a variation of the finding which law is best in most scenarios."""
        return wb.Variation(
            self.words, self.answer, self.detail, POOL_QUESTION if self.counts is None else COUNT_QUESTION
        )


def count_wins(
    standings: wb.evidence.Standings, words: str = PRIMARY.words, without: Collection[str] = ()
) -> dict[str, int]:
    """The number of scenarios in which each law is best by a statistic, most first; laws that never are left out."""
    wins = {law: sum(s not in without for s in where) for law, where in standings.wins[words].items()}
    return {law: count for law, count in sorted(wins.items(), key=lambda pair: -pair[1]) if count}


def champion(counts: Mapping[str, int], scenarios: int) -> str:
    """The law that is best in more than half of the scenarios, or `NOBODY`."""
    return next((law for law, count in counts.items() if 2 * count > scenarios), NOBODY)


def tally_words(counts: Mapping[str, int], scenarios: int) -> str:
    """A tally in words."""
    undecided = scenarios - sum(counts.values())
    words = [f"{law} in {n}" for law, n in counts.items()] + [f"undecided in {undecided}"] * bool(undecided)
    return ", ".join(words)


def counted_change(
    words: str, standings: wb.evidence.Standings, statistic: str = PRIMARY.words, without: Collection[str] = ()
) -> Change:
    """A change of which each scenario is judged by itself."""
    scenarios = sum(scenario not in without for scenario in standings.judgements)
    counts = count_wins(standings, statistic, without)
    return Change(words, champion(counts, scenarios), counts, scenarios, tally_words(counts, scenarios))


def pooled_change(words: str, judgement: wb.evidence.LawJudgement) -> Change:
    """A change by which scenarios are judged together."""
    one = judgement.by[PRIMARY.words]
    return Change(words, one.best or NOBODY, detail=leading_laws(one, 2))


def base(evidence: Evidence, key: str) -> Change:
    """The question as it was declared before the runs."""
    return counted_change(f"{MEASURE}, as declared", evidence.cost[key])


def changes(evidence: Evidence, key: str) -> Iterator[Change]:
    """All that the study has computed otherwise for the laws with the same measurements."""
    cost = evidence.cost[key]
    for other in OTHERS:
        yield counted_change(f"{other.words} in place of the mean", cost, other.words)
    for words, standings in evidence.changed_standings[key].items():
        one = counted_change(words, standings)
        yield replace(one, detail=f"{one.detail}{compared_pairs(standings, cost)}")
    for way, pooled in evidence.pooled_judgements[key].items():
        yield pooled_change(f"all scenarios together, {way}", pooled.whole)
    for words, standings in evidence.weighted_standings.get(key, {}).items():
        yield counted_change(f"weights: {words}", standings)
    for scenario in cost.judgements:
        yield without_scenario(cost, scenario)
    if seen := [one for one in SEEN_SCENARIOS if one in cost.judgements]:
        yield counted_change(f"without {quote_names(seen)}, which have a motion of the tuning", cost, without=seen)
    for way, pooled in evidence.pooled_judgements[key].items():
        for scenario, judgement in pooled.without.items():
            yield pooled_change(f"all but '{scenario}' together, {way}", judgement)


def without_scenario(cost: wb.evidence.Standings, scenario: str) -> Change:
    """The question about all scenarios but one."""
    return counted_change(f"without scenario '{scenario}'", cost, without=(scenario,))


def quote_names(scenarios: Sequence[str]) -> str:
    """The names of scenarios in words."""
    return wb.document.join_names(f"'{one}'" for one in scenarios)


def compared_pairs(fewer: wb.evidence.Standings, all_laws: wb.evidence.Standings) -> str:
    """A remark on the number of comparisons, where fewer laws are judged than in the base."""
    sizes = [len(next(iter(one.judgements.values())).samples.laws) for one in (fewer, all_laws)]
    few, many = (n * (n - 1) // 2 for n in sizes)
    return "" if few == many else f"; {few} pair{'s' * (few > 1)} of laws in place of {many}"


def leading_laws(one: wb.evidence.Comparison, most: int = 3) -> str:
    """The laws with the least levels, with these levels."""
    order = sorted(one.samples.laws, key=lambda law: one.level.value[one.samples.place(law)])
    return ", ".join(f"{law} {three_digits(one.level.value[one.samples.place(law)])}" for law in order[:most])


def three_digits(value: float) -> str:
    """A number with three digits, zeros at its end among them, or with all before the point."""
    return f"{value:#.3g}".rstrip(".") if abs(value) < 999.5 else f"{value:,.0f}"


def sample(evidence: Evidence) -> str:
    """The sample of each scenario."""
    judgement = next(iter(evidence.cost[BOTH.key].judgements.values()))
    return f"{len(judgement.samples)} draws in each of {SCENARIOS} scenarios, the same draws for all laws."


def scenario_words(name: str) -> str:
    """A scenario with its words."""
    return next((f"'{name}' ({one.words})" for one in HELD_OUT if one.name == name), f"'{name}'")


def heaviest(pooled_judgement: wb.evidence.PooledJudgement) -> tuple[str, dict[str, float]]:
    """The scenario that is more than half of the sum for the most laws, and its part of the sum of each law."""
    return max(
        pooled_judgement.shares.items(),
        key=lambda pair: (sum(2 * part > 1 for part in pair[1].values()), sum(pair[1].values())),
    )
