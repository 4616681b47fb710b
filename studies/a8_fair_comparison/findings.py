"""The findings of a8: the best law among laws with the same measurements, what changes that, and what (34) is worth."""

from __future__ import annotations

from collections import Counter

import numpy as np

from studies.a8_fair_comparison.changes import (
    BASE,
    CHOSEN,
    LESS,
    MEASURE,
    NOBODY,
    SCENARIOS,
    SUM,
    TUNED,
    WHOLE,
    Change,
    base,
    changes,
    compared_pairs,
    counted,
    counted_change,
    described,
    heaviest,
    leading,
    rounded,
    sample,
    tally,
)
from studies.a8_fair_comparison.entrants import BOTH, FILTER, GIVEN, LAWS, PROPOSED, READINGS, Given
from studies.a8_fair_comparison.evidence import ASKED, DRAWS, FAMILY, MARGIN, Evidence, by_mean_costs, together
from studies.a8_fair_comparison.riccati_worth import CHATTERS, decisive, riccati, spread
from workbench.study.document.finding import Finding, Variation

__all__ = ["answer", "diverged", "pooled_cost", "proposed", "riccati", "winner"]

NAMES = {READINGS.key: "raw_readings", BOTH.key: "own_observers"}
POOLED_MEAN = "The mean over the draws of the geometric mean of the cost over all scenarios"
UNTRIED = "Other scenarios and ranges, a cost with other terms, and laws that are tuned for another cost."


def winner(evidence: Evidence, given: Given) -> Finding:
    """The law that is best in most scenarios among laws with the same measurements."""
    first, pooled = base(evidence, given.key), evidence.pooled[given.key][BASE]
    variations = tuple(change.variation for change in changes(evidence, given.key))
    whole = pooled.whole.by[ASKED.words]
    models = "; all but PID have a model" if given in (READINGS, FILTER) else ""
    return Finding(
        NAMES[given.key],
        f"With {given.name}, {first.answer} has the lowest {MEASURE} in most of the {SCENARIOS} scenarios: "
        f"{counted(first.counts or {}, SCENARIOS)}.",
        f"{other_searches(evidence, given)} {POOLED_MEAN} is lowest for {leading(whole)}"
        f"{'' if whole.best else ' (undecided)'}. A law counts as lowest only if its advantage exceeds "
        f"{100 * MARGIN:g} %, its interval and the error of the step.",
        statistic=f"{MEASURE.capitalize()} in each scenario, declared before the runs. The intervals of all pairs of "
        f"laws in all scenarios hold at once with {100 * FAMILY:g} %.",
        sample=sample(evidence),
        given=f"Each of {len(LAWS)} laws has {given.words}{models}.",
        chosen=CHOSEN,
        fitted=TUNED,
        answer=first.answer,
        variations=variations,
        untried=UNTRIED,
        settled=first.answer != NOBODY or any(one.answer != NOBODY for one in variations),
    )


def other_searches(evidence: Evidence, given: Given) -> str:
    """The tallies by the second and the third best search of the laws that run with other numbers."""
    found = [
        f"by {words}, {counted(tally(standings), len(standings.judgements))}"
        for words, standings in evidence.again[given.key].items()
        if words.endswith("laws") and "search" in words
    ]
    return f"In how many each law is lowest changes with the search: {'; '.join(found)}." if found else ""


def pooled_variations(evidence: Evidence) -> list[Variation]:
    """Other numbers, weights, ways to pool, each scenario left out of each, and the other measurements."""
    by = evidence.pooled[BOTH.key]
    first = by[BASE]
    weights = {f"weights: {words}": one for words, one in evidence.weighted.get(BOTH.key, {}).items()}
    cost = evidence.cost[BOTH.key]
    others = {f"{words}{compared_pairs(one, cost)}": together(one) for words, one in evidence.again[BOTH.key].items()}
    others |= {words: together(one) for words, one in weights.items()}
    others["the geometric mean of the mean costs"] = by_mean_costs(first.members)
    searched = [
        Variation(words, one.by[ASKED.words].answer, leading(one.by[ASKED.words], 2), WHOLE)
        for words, one in others.items()
    ]
    variations = [
        Variation(f"the {way}", p.answer, leading(p.whole.by[ASKED.words], 2), WHOLE)
        for way, p in by.items()
        if p is not first
    ]
    variations += [
        Variation(f"the {way} without '{s}'", one.answer, leading(one, 2), LESS)
        for way, p in by.items()
        for s, one in ((s, judgement.by[ASKED.words]) for s, judgement in p.without.items())
    ]
    variations += [
        Variation(f"the {BASE} with {given.name}", p.answer, leading(p.whole.by[ASKED.words], 2), WHOLE)
        for given in GIVEN
        if (p := evidence.pooled[given.key][BASE]) is not first
    ]
    return searched + variations


def pooled_cost(evidence: Evidence) -> Finding:
    """The laws over all scenarios together, and the scenario on which that rests."""
    by = evidence.pooled[BOTH.key]
    first, total = by[BASE], by[SUM]
    one = first.whole.by[ASKED.words]
    name, share = heaviest(total)
    heavy = {law: part for law, part in share.items() if 2 * part > 1}
    rest = total.without[name].by[ASKED.words]
    part = (
        f"'{name}' is {100 * min(heavy.values()):.0f} to {100 * max(heavy.values()):.0f} % of the sum for {len(heavy)} "
        "laws"
        if heavy
        else "no scenario is more than half of the sum for any law"
    )
    return Finding(
        "pooled_cost",
        f"Over all {SCENARIOS} scenarios together, behind both observers, "
        + (
            f"{one.best} has the lowest geometric mean of the cost: {leading(one)}."
            if one.best
            else f"the lowest geometric mean of the cost is {one.answer}: {leading(one)}."
        ),
        f"Without {described(name)} they are {leading(first.without[name].by[ASKED.words])}. In the "
        f"arithmetic mean {part}. Its lowest values are {leading(total.whole.by[ASKED.words])}, and {leading(rest, 5)} "
        f"without '{name}'.",
        statistic="Mean over the draws of the geometric mean of the cost over the scenarios, in which a ratio counts "
        "alike in every scenario. It is not the geometric mean of the mean costs, which is among the variations.",
        sample=sample(evidence),
        given=f"Each of {len(LAWS)} laws has {BOTH.words}.",
        chosen=CHOSEN,
        fitted=TUNED,
        answer=first.answer,
        variations=tuple(pooled_variations(evidence)),
        untried=UNTRIED,
    )


def proposed(evidence: Evidence) -> Finding:
    """The number of scenarios in which AOSMC-RGS is best, whatever it measures."""
    first = base(evidence, BOTH.key)
    others = [change for change in changes(evidence, BOTH.key) if change.counts is not None]
    others += [
        counted_change(f"with {given.name} in place of its own observers", evidence.cost[given.key])
        for given in GIVEN
        if given != BOTH
    ]
    comparisons = [one.by[ASKED.words] for one in evidence.cost[BOTH.key].judgements.values()]
    lower, higher = (
        balance(Counter(law for one in comparisons for law in one.paired.laws if one.order(law, PROPOSED) == side))
        for side in ("below", "above")
    )
    return Finding(
        "proposed_law",
        f"{PROPOSED} has the lowest {MEASURE} in {places(first)} of {SCENARIOS} scenarios behind its own observers.",
        f"Laws behind the same observers with a significantly lower mean: {lower}. With a significantly higher one: "
        f"{higher}.",
        statistic=f"Number of scenarios in which the {MEASURE} is below that by every other law, beyond "
        f"{100 * MARGIN:g} % and its interval.",
        sample=sample(evidence),
        given=f"Each of {len(LAWS)} laws has {BOTH.words}.",
        chosen=f"{CHOSEN} The four repairs of the law in a1.",
        fitted=TUNED,
        answer=frequency(first),
        variations=tuple(Variation(one.words, frequency(one), f"{places(one)} of {one.scenarios}") for one in others),
        untried=UNTRIED,
    )


def balance(scenarios: Counter[str]) -> str:
    """Laws by the number of scenarios, most first; laws with the same number together."""
    groups: dict[int, list[str]] = {}
    for law, n in scenarios.most_common():
        groups.setdefault(n, []).append(law)
    return "; ".join(f"{', '.join(laws)} in {n}" for n, laws in groups.items()) or "none"


def places(change: Change) -> int:
    """The number of scenarios in which AOSMC-RGS is best."""
    return (change.counts or {}).get(PROPOSED, 0)


def frequency(change: Change) -> str:
    """The same in words: in no scenario, in some, or in most."""
    n = places(change)
    return "in most scenarios" if 2 * n > change.scenarios else "in some scenarios" if n else "in no scenario"


def diverged(evidence: Evidence) -> str:
    """The runs that did not last, whether the law or its integrator lost them, and those that last at a high cost."""
    runs = [one for by in evidence.runs.values() for laws in by.values() for one in laws.values()]
    causes = evidence.causes.values()
    failed, total = sum(one.failed for one in runs), sum(map(len, runs))
    if not failed:
        return (
            f"No state of {total:,} runs becomes infinite, and no angle exceeds 1e12 rad; runs with other numbers and "
            f"without parts are not counted here. This does not say that all of them track. {costly(evidence)}"
        )
    by_law, by_integrator = sum(one.by_law for one in causes), sum(one.by_integrator for one in causes)
    where = "; ".join(
        f"{law} with {words} in '{scenario}', {len(one.lost['fine'])} of {DRAWS} ({one.sentence})"
        for (scenario, law, words), one in evidence.causes.items()
    )
    return (
        f"{failed:,} of {total:,} runs diverge: {by_law} by the law, {by_integrator} by its integrator, and "
        f"{sum(one.unsettled for one in causes)} for a reason that is not settled. {where}. A run diverges if a state "
        "is no longer finite, or an angle is beyond 1e12 rad. The integrator is the reason if the run lasts where the "
        f"memories of law and observer move near their exact flow. {costly(evidence)}"
    )


def costly(evidence: Evidence) -> str:
    """The runs with a high cost, and the laws of which all runs in a scenario have one."""
    costs = [one.paired for by in evidence.cost.values() for one in by.judgements.values()]
    high = np.array([(one.values > CHATTERS).sum(axis=0) for one in costs])
    every: dict[str, list[str]] = {}
    for scenario, one in evidence.cost[BOTH.key].judgements.items():
        always = (one.paired.values > CHATTERS).all(axis=0)
        every[scenario] = [law for law, high_in_all in zip(one.paired.laws, always, strict=True) if high_in_all]
    where = "; ".join(f"'{scenario}': {', '.join(laws)}" for scenario, laws in every.items() if laws)
    return (
        f"A cost of more than {CHATTERS:g}, five times an acceptable one, have {high.sum():,} runs, in "
        f"{(high > 0).sum()} of {high.size} cases of a law in a scenario. Behind both observers these laws have it in "
        f"every draw: {where or 'none'}."
    )


def answer(evidence: Evidence) -> str:
    """The line under the title, of at most forty words."""
    readings, both = base(evidence, READINGS.key), base(evidence, BOTH.key)
    counts = dict(both.counts or {})
    shown = dict(list(counts.items())[:1]) | {PROPOSED: places(both)}
    leads = ", ".join(f"{law} in {n or 'none'}" for law, n in shown.items())
    name = decisive(evidence.parts)
    pooled = evidence.parts.searches
    whole, rest = (factors(spread(judgement)) for judgement in (pooled.whole, pooled.without[name]))
    return (
        f"{lead(readings)} of {readings.scenarios} scenarios with raw readings; behind both observers, {leads}. "
        f"{PROPOSED} costs {whole} times as much without its Riccati equation (by search), {rest} without scenario "
        f"'{name}'."
    )


def factors(span: tuple[float, float]) -> str:
    """Changes in percent as factors."""
    low, high = (rounded(1 + percent / 100) for percent in span)
    return low if low == high else f"{low} to {high}"


def lead(change: Change) -> str:
    """The law that is best in the most scenarios, with its count in words."""
    first = next(iter((change.counts or {}).items()), None)
    return f"{first[0]} costs least in {first[1]}" if first else "No law costs least in any"
