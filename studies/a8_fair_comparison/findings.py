"""The findings of a8: the best law among laws with the same measurements, what changes that, and what (34) is worth."""

from __future__ import annotations

from collections import Counter

import numpy as np

import workbench as wb
from studies.a8_fair_comparison.changes import (
    ASSUMPTIONS,
    BASE,
    FITS,
    LESS,
    MEASURE,
    NOBODY,
    SCENARIOS,
    SUM,
    WHOLE,
    Change,
    base,
    changes,
    compared_pairs,
    count_wins,
    counted_change,
    heaviest,
    leading_laws,
    sample,
    scenario_words,
    tally_words,
)
from studies.a8_fair_comparison.evidence import DRAWS, Evidence, by_mean_costs, together
from studies.a8_fair_comparison.riccati_worth import CHATTERS, more_or_less, riccati, spread
from studies.paper.costs import FAMILY, MARGIN, PRIMARY
from studies.paper.entrants import ALL_INFORMATION, BOTH, FILTER, LAWS, PROPOSED_LAW, READINGS, Information

__all__ = ["answer", "divergence_words", "pooled_cost", "proposed_finding", "riccati", "winner"]

NAMES = {READINGS.key: "raw_readings", BOTH.key: "own_observers"}
PLACES = {READINGS.key: "with raw readings", BOTH.key: "behind both observers (of state and disturbance)"}
LOWEST = (
    "A law counts as the best of a scenario if its mean cost is significantly lower than that of each other law: the "
    f"whole confidence interval of the difference lies beyond {100 * MARGIN:g} % plus the integration errors of both "
    "laws."
)
LIMITATIONS = "Other scenarios and ranges, a cost with other terms, and laws that are tuned for another cost."


def winner(evidence: Evidence, information: Information) -> wb.Finding:
    """The law that is best in most scenarios among laws with the same measurements."""
    first, pooled = base(evidence, information.key), evidence.pooled_judgements[information.key][BASE]
    variations = tuple(change.variation for change in changes(evidence, information.key))
    whole = pooled.whole.by[PRIMARY.words]
    models = "; all but PID have a model" if information in (READINGS, FILTER) else ""
    place = PLACES[information.key]
    return wb.Finding(
        NAMES[information.key],
        f"{place[0].upper()}{place[1:]}, {first.answer} has the significantly lowest {MEASURE} in most of the "
        f"{SCENARIOS} "
        f"scenarios: {tally_words(first.counts or {}, SCENARIOS)}.",
        f"{LOWEST} If no law is best, the scenario is undecided. {other_searches(evidence, information)} By the "
        f"geometric mean over all scenarios, {whole.best or 'no law'} is significantly lowest: {leading_laws(whole)}.",
        statistic=f"{MEASURE.capitalize()} in each scenario, declared before the runs. The intervals of all pairs of "
        f"laws in all scenarios hold at once with a confidence of {100 * FAMILY:g} %.",
        sample=sample(evidence),
        information=f"Each of the {len(LAWS)} laws has {information.words}{models}.",
        assumptions=ASSUMPTIONS,
        fitted_numbers=FITS,
        answer=first.answer,
        variations=variations,
        limitations=LIMITATIONS,
        is_decided=first.answer != NOBODY or any(one.answer != NOBODY for one in variations),
    )


def other_searches(evidence: Evidence, information: Information) -> str:
    """The tallies by the second and the third best search of the laws that run with other numbers, with their names."""
    again = evidence.changed_standings[information.key]
    found = [
        f"by their {words.removeprefix('the ').split(' of each')[0]}, the best laws are: "
        f"{tally_words(count_wins(standings), len(standings.judgements))}"
        for words, standings in again.items()
        if words.endswith("laws") and "search" in words
    ]
    if not found:
        return ""
    some = next(one for words, one in again.items() if words.endswith("laws alone"))
    names = wb.document.join_names(next(iter(some.judgements.values())).samples.laws)
    return f"Each law was tuned by three searches. If {names} run as tuned {'; '.join(found)}."


def pooled_variations(evidence: Evidence) -> list[wb.Variation]:
    """Other numbers, weights, ways to pool, each scenario left out of each, and the other measurements."""
    by = evidence.pooled_judgements[BOTH.key]
    first = by[BASE]
    weights = {f"weights: {words}": one for words, one in evidence.weighted_standings.get(BOTH.key, {}).items()}
    cost = evidence.cost[BOTH.key]
    again = evidence.changed_standings[BOTH.key]
    others = {words: together(one) for words, one in {**again, **weights}.items()}
    others["the geometric mean of the mean costs"] = by_mean_costs(first.members)
    pairs = {words: compared_pairs(one, cost) for words, one in again.items()}
    searched = [
        wb.Variation(words, one.answer, f"{leading_laws(one, 2)}{pairs.get(words, '')}", WHOLE)
        for words, one in ((words, judgement.by[PRIMARY.words]) for words, judgement in others.items())
    ]
    variations = [
        wb.Variation(f"the {way}", p.answer, leading_laws(p.whole.by[PRIMARY.words], 2), WHOLE)
        for way, p in by.items()
        if p is not first
    ]
    variations += [
        wb.Variation(f"the {way} without '{s}'", one.answer, leading_laws(one, 2), LESS)
        for way, p in by.items()
        for s, one in ((s, judgement.by[PRIMARY.words]) for s, judgement in p.without.items())
    ]
    variations += [
        wb.Variation(f"the {BASE} with {given.name}", p.answer, leading_laws(p.whole.by[PRIMARY.words], 2), WHOLE)
        for given in ALL_INFORMATION
        if (p := evidence.pooled_judgements[given.key][BASE]) is not first
    ]
    return searched + variations


def pooled_cost(evidence: Evidence) -> wb.Finding:
    """The laws over all scenarios together, and the scenario on which that rests."""
    by = evidence.pooled_judgements[BOTH.key]
    first, total = by[BASE], by[SUM]
    one = first.whole.by[PRIMARY.words]
    name, share = heaviest(total)
    heavy = [100 * part for part in share.values() if 2 * part > 1]
    rest = total.without[name].by[PRIMARY.words]
    parts = " to ".join(dict.fromkeys(f"{part:.0f}" for part in (min(heavy), max(heavy)))) if heavy else ""
    part = (
        f"'{name}' makes up {parts} % of the sum for {len(heavy)} law{'s' * (len(heavy) > 1)}"
        if heavy
        else "no scenario makes up more than half of the sum for any law"
    )
    return wb.Finding(
        "pooled_cost",
        f"Over all {SCENARIOS} scenarios together, behind both observers, "
        + (
            f"{one.best} has the lowest geometric mean of the cost: {leading_laws(one)}."
            if one.best
            else f"the lowest geometric mean of the cost is {one.answer}: {leading_laws(one)}."
        ),
        f"Without {scenario_words(name)}, the lowest means are {leading_laws(first.without[name].by[PRIMARY.words])}. "
        f"In "
        f"the arithmetic mean, {part}. The lowest arithmetic means are {leading_laws(total.whole.by[PRIMARY.words])}; "
        f"without '{name}' they are {leading_laws(rest, 5)}.",
        statistic="For each draw, the geometric mean of the costs over the scenarios is taken. The statistic is the "
        "mean of these over the draws. A given ratio of the costs of two laws counts the same in every scenario. The "
        "geometric mean of the mean costs is another number, and one of the variations.",
        sample=sample(evidence),
        information=f"Each of the {len(LAWS)} laws has {BOTH.words}.",
        assumptions=ASSUMPTIONS,
        fitted_numbers=FITS,
        answer=first.answer,
        variations=tuple(pooled_variations(evidence)),
        limitations=LIMITATIONS,
    )


def proposed_finding(evidence: Evidence) -> wb.Finding:
    """The number of scenarios in which AOSMC-RGS is best, whatever it measures."""
    first = base(evidence, BOTH.key)
    others = [change for change in changes(evidence, BOTH.key) if change.counts is not None]
    others += [
        counted_change(f"with {given.name} in place of both observers", evidence.cost[given.key])
        for given in ALL_INFORMATION
        if given != BOTH
    ]
    comparisons = [one.by[PRIMARY.words] for one in evidence.cost[BOTH.key].judgements.values()]
    lower, higher = (
        balance(Counter(law for one in comparisons for law in one.samples.laws if one.order(law, PROPOSED_LAW) == side))
        for side in ("below", "above")
    )
    return wb.Finding(
        "proposed_law",
        f"Behind both observers, which belong to its design, {PROPOSED_LAW} is significantly better than all others in "
        f"{places(first) or 'none'} of the {SCENARIOS} scenarios.{least_and_tied(evidence)}",
        f"Laws with a significantly lower mean cost than {PROPOSED_LAW}, by the number of scenarios: {lower}. Laws "
        f"with a significantly higher mean cost: {higher}.",
        statistic=f"Number of scenarios in which {PROPOSED_LAW} has the significantly lowest {MEASURE}. {LOWEST}",
        sample=sample(evidence),
        information=f"Each of the {len(LAWS)} laws has {BOTH.words}.",
        assumptions=f"{ASSUMPTIONS} The law has the four repairs of report a1.",
        fitted_numbers=FITS,
        answer=frequency(first),
        variations=tuple(
            wb.Variation(one.words, frequency(one), f"{places(one)} of {one.scenarios}") for one in others
        ),
        limitations=LIMITATIONS,
    )


def least_and_tied(evidence: Evidence) -> str:
    """A sentence on the scenarios in which AOSMC-RGS has the least mean without being best, and on the tied laws."""
    ties = []
    for scenario, judgement in evidence.cost[BOTH.key].judgements.items():
        one = judgement.by[PRIMARY.words]
        if leading_laws(one, 1).startswith(f"{PROPOSED_LAW} ") and one.best is None:
            others = [law for law in one.leaders if law != PROPOSED_LAW]
            ties.append(f"'{scenario}', where it is tied with {wb.document.join_names(others)}")
    return f" Its mean is the lowest in {'; in '.join(ties)}." if ties else ""


def balance(scenarios: Counter[str]) -> str:
    """Laws by the number of scenarios, most first; laws with the same number together."""
    groups: dict[int, list[str]] = {}
    for law, n in scenarios.most_common():
        groups.setdefault(n, []).append(law)
    return "; ".join(f"{', '.join(laws)} in {n}" for n, laws in groups.items()) or "none"


def places(change: Change) -> int:
    """The number of scenarios in which AOSMC-RGS is best."""
    return (change.counts or {}).get(PROPOSED_LAW, 0)


def frequency(change: Change) -> str:
    """The same in words: in no scenario, in some, or in most."""
    n = places(change)
    return "in most scenarios" if 2 * n > change.scenarios else "in some scenarios" if n else "in no scenario"


def divergence_words(evidence: Evidence) -> str:
    """The runs that did not last, whether the law or its integrator lost them, and those that last at a high cost."""
    runs = [one for by in evidence.runs.values() for laws in by.values() for one in laws.values()]
    causes = evidence.causes.values()
    failed, total = sum(one.diverged_count for one in runs), sum(map(len, runs))
    if not failed:
        return (
            f"No state becomes infinite, and no angle exceeds 1e12 rad, in any of {total:,} runs. Runs with other "
            "numbers and runs of laws without a part are not counted here. Not all of these runs track. "
            f"{costly(evidence)}"
        )
    by_law, by_integrator = sum(one.by_law for one in causes), sum(one.by_integrator for one in causes)
    where = "; ".join(
        f"{law} with {words} in '{scenario}', {len(one.diverges['fine'])} of {DRAWS} ({one.sentence})"
        for (scenario, law, words), one in evidence.causes.items()
    )
    return (
        f"{failed:,} of {total:,} runs diverge: {by_law} by the law, {by_integrator} by its integrator, and "
        f"{sum(one.undecided_runs for one in causes)} for a reason that is not settled. {where}. A run diverges if a "
        "state is no longer finite, or an angle exceeds 1e12 rad. The integrator is the reason if the run does not "
        "diverge once the memories of law and observer are integrated almost exactly. "
        f"{costly(evidence)}"
    )


def costly(evidence: Evidence) -> str:
    """The runs with a high cost, and the laws of which all runs in a scenario have one."""
    costs = [one.samples for by in evidence.cost.values() for one in by.judgements.values()]
    high = np.array([(one.values > CHATTERS).sum(axis=0) for one in costs])
    every: dict[str, list[str]] = {}
    for scenario, one in evidence.cost[BOTH.key].judgements.items():
        always = np.asarray((one.samples.values > CHATTERS).all(axis=0))
        every[scenario] = [law for law, high_in_all in zip(one.samples.laws, always, strict=True) if high_in_all]
    where = "; ".join(f"{', '.join(laws)} in '{scenario}'" for scenario, laws in every.items() if laws)
    return (
        f"A cost of {CHATTERS:g} is five times an acceptable one. {high.sum():,} runs cost more than {CHATTERS:g}, in "
        f"{(high > 0).sum()} of the {high.size} combinations of law, measurements and scenario. Behind both observers "
        f"these laws cost more than {CHATTERS:g} in every draw: {where or 'none'}."
    )


def answer(evidence: Evidence) -> str:
    """The line under the title, of at most forty words."""
    readings, both = base(evidence, READINGS.key), base(evidence, BOTH.key)
    law, count = leader(readings)
    found = f"{law} is significantly best in {count or 'any'}"
    span = spread(evidence.parts.searches.whole)
    search = ", depending on the search" if span[0] != span[1] else ""
    return (
        f"With raw readings, {found} of {readings.scenarios} scenarios; behind both observers, {leads(both, law)}. "
        f"Retuned without its Riccati equation, {PROPOSED_LAW} costs {more_or_less(span)}{search}."
    )


def leader(change: Change) -> tuple[str, int]:
    """The law that is best in the most scenarios, and their number."""
    return next(iter((change.counts or {}).items()), (NOBODY, 0))


def leads(change: Change, before: str) -> str:
    """The law that is best in the most scenarios, unless it was named just before, and AOSMC-RGS."""
    law, count = leader(change)
    if not count:
        return f"{NOBODY} in any"
    undecided = change.scenarios - sum((change.counts or {}).values())
    rest = f" ({undecided} undecided)" if undecided else ""
    if law == before:
        return f"in {count}{rest}" + ("" if law == PROPOSED_LAW else f", {PROPOSED_LAW} in {places(change) or 'none'}")
    return f"{law} in {count}{rest}" + (
        "" if law == PROPOSED_LAW else f", {PROPOSED_LAW} in {places(change) or 'none'}"
    )
