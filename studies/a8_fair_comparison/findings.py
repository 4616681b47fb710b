"""The findings of a8: the best law among laws with the same measurements, what changes that, and what (34) is worth."""

from __future__ import annotations

from collections import Counter

from studies.a8_fair_comparison.ablations import RICCATI, STEADY
from studies.a8_fair_comparison.changes import (
    BASE,
    MEASURE,
    NOBODY,
    SCENARIOS,
    SUM,
    Change,
    base,
    changes,
    counted,
    counted_change,
    heaviest,
    leading,
)
from studies.a8_fair_comparison.entrants import BOTH, FILTER, GIVEN, LAWS, PROPOSED, READINGS, Given
from studies.a8_fair_comparison.evidence import ASKED, DRAWS, FAMILY, MARGIN, Evidence, Parts
from studies.a8_fair_comparison.other_numbers import PLAIN
from workbench.study.document.finding import Finding, Variation
from workbench.study.evidence import Comparison, Judgement, Pooled
from workbench.study.evidence.judgement import figures

TUNED = "All numbers of the law and of its observers, by three searches with the same budget for each number."
CHOSEN = (
    "The terms of the cost and their acceptable values, the scenarios, the ranges of the draws, the torque limit and "
    "the computer."
)
NAMES = {READINGS.key: "raw_readings", BOTH.key: "own_observers"}
TIMES = 1000  # percent, from which on a change is told as a factor
UNTRIED = "Other scenarios and ranges, a cost with other terms, and laws that are tuned for another cost."


def sample(evidence: Evidence) -> str:
    """The sample of each scenario."""
    judgement = next(iter(evidence.cost[BOTH.key].judgements.values()))
    return f"{len(judgement.paired)} draws in each of {SCENARIOS} scenarios, the same draws for all laws."


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
        f"Over all scenarios together the lowest geometric means of the cost are {leading(whole)}. A law counts as "
        f"lowest only if its advantage exceeds {100 * MARGIN:g} % and its interval.",
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


def pooled_variations(evidence: Evidence) -> list[Variation]:
    """The ways to pool, each scenario left out of each, and the other measurements."""
    by = evidence.pooled[BOTH.key]
    first = by[BASE]
    variations = [
        Variation(f"the {way}", p.answer, leading(p.whole.by[ASKED.words], 2))
        for way, p in by.items()
        if p is not first
    ]
    variations += [
        Variation(f"the {way} without '{s}'", judgement.by[ASKED.words].answer, leading(judgement.by[ASKED.words], 2))
        for way, p in by.items()
        for s, judgement in p.without.items()
    ]
    variations += [
        Variation(f"the {BASE} with {given.name}", p.answer, leading(p.whole.by[ASKED.words], 2))
        for given in GIVEN
        if (p := evidence.pooled[given.key][BASE]) is not first
    ]
    return variations


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
            f"{one.best} has the lowest geometric mean of the cost, {figures(one, one.best)}."
            if one.best
            else f"the lowest geometric mean of the cost is {one.answer}: {leading(one)}."
        ),
        f"Without '{name}' the lowest geometric means are {leading(first.without[name].by[ASKED.words])}. In the "
        f"arithmetic mean {part}. Its lowest values are {leading(total.whole.by[ASKED.words])}, and {leading(rest, 5)} "
        f"without '{name}'.",
        statistic="Mean over the draws of the geometric mean of the cost over the scenarios, in which a ratio counts "
        "alike in every scenario.",
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
    below = Counter(law for one in comparisons for law in one.paired.laws if one.order(law, PROPOSED) == "below")
    lower = ", ".join(f"{law} in {n}" for law, n in below.most_common(3)) or "none"
    return Finding(
        "proposed_law",
        f"{PROPOSED} has the lowest {MEASURE} in {places(first)} of {SCENARIOS} scenarios behind its own observers.",
        f"Laws behind the same observers with a significantly lower mean: {lower}.",
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


def places(change: Change) -> int:
    """The number of scenarios in which AOSMC-RGS is best."""
    return (change.counts or {}).get(PROPOSED, 0)


def frequency(change: Change) -> str:
    """The same in words: in no scenario, in some, or in most."""
    n = places(change)
    return "in most scenarios" if 2 * n > change.scenarios else "in some scenarios" if n else "in no scenario"


def effect(one: Comparison, without: str) -> str:
    """The effect of a part on the cost of AOSMC-RGS, in words."""
    if one.alike(PROPOSED, without):
        return "no difference"
    return {"below": "better with (34)", "above": "worse with (34)"}.get(one.order(PROPOSED, without), "undecided")


def change_of(one: Comparison, without: str) -> tuple[float, float, float]:
    """The change of the cost of AOSMC-RGS without a part, in percent, and the ends of its interval."""
    at, i, d = one.paired.place(PROPOSED), one.paired.place(without), one.difference
    value, low, high = (100 * float(part[i, at] / one.level.value[at]) for part in (d.value, d.low, d.high))
    return value, low, high


def least_change(pooled: Pooled, law: str) -> tuple[str, float]:
    """The scenario without which the change of the cost is smallest in size, and that change in percent."""
    changed = {scenario: change_of(one.by[ASKED.words], law)[0] for scenario, one in pooled.without.items()}
    return min(changed.items(), key=lambda pair: abs(pair[1]))


def moves(one: Comparison, without: str) -> str:
    """The change of the cost of AOSMC-RGS without a part, as a verb with its figure and its interval."""
    value, low, high = change_of(one, without)
    if value >= TIMES:
        return f"rises to {1 + value / 100:,.3g} times its value"
    verb = "rises" if value > 0 else "falls"
    return f"{verb} by {digits(abs(value))} % ({digits(low, '+')} to {digits(high, '+')} %)"


def digits(percent: float, sign: str = "") -> str:
    """A percentage with two digits, or with all before the point."""
    percent = round(percent, 9) + 0.0  # a rounding error is no decrease: neither 1e-14 nor minus zero
    return f"{percent:{sign}.2g}" if abs(percent) < 100 else f"{percent:{sign}.0f}"


def riccati_variations(parts: Parts) -> list[Variation]:
    """The worth of (34) by other pools and other laws without it, and with each scenario left out."""
    rivals: list[tuple[str, Pooled, str]] = [
        (f"tuned again, {way}", pooled, RICCATI) for way, pooled in parts.retuned.items()
    ]
    rivals += [
        ("P at its steady value, not tuned again", parts.frozen, STEADY),
        ("P at the tuned P(0), not tuned again", parts.frozen, RICCATI),
    ]
    rivals += [(f"plain {PLAIN}, {way}", p, PLAIN) for way, p in parts.retuned.items()]
    base_of = (parts.retuned[BASE], RICCATI)
    variations = [effect_of(words, p.whole, law) for words, p, law in rivals if (p, law) != base_of]
    variations += [
        effect_of(f"{words}, without '{s}'", less, law) for words, p, law in rivals for s, less in p.without.items()
    ]
    return variations


def riccati(evidence: Evidence) -> Finding:
    """The worth of the Riccati equation (34) in AOSMC-RGS."""
    parts = evidence.parts
    one = parts.retuned[BASE].whole.by[ASKED.words]
    frozen = parts.frozen.whole.by[ASKED.words]
    name, rest = least_change(parts.retuned[BASE], PLAIN)
    decisive, less = least_change(parts.retuned[BASE], RICCATI)
    return Finding(
        "riccati_gain",
        f"With a constant P in place of (34) and tuned again, the cost of {PROPOSED} {moves(one, RICCATI)} over all "
        f"scenarios together, and changes by {digits(less, '+')} % without '{decisive}'.",
        f"With the numbers of the whole law it {moves(frozen, STEADY)} if P is kept at its steady value. It "
        f"{moves(frozen, RICCATI)} if P is kept at the tuned P(0), which is a start pulse. Plain {PLAIN} behind the "
        f"same observers costs {digits(change_of(one, PLAIN)[0], '+')} %, and {digits(rest, '+')} % without '{name}'.",
        statistic=f"Change of the {BASE} of the cost over the {SCENARIOS} scenarios, mean over the draws, with its "
        "interval.",
        sample=sample(evidence),
        given=f"Both laws have {BOTH.words}.",
        chosen=f"{CHOSEN} The posture for the steady value: the start of each scenario, with K(0).",
        fitted=TUNED,
        answer=effect(one, RICCATI),
        variations=tuple(riccati_variations(parts)),
        untried="Other shapes of (33), and a larger budget of the searches.",
        settled=effect(one, RICCATI) != "undecided",
        cites=("a3_riccati_gains/riccati_gain",),
    )


def effect_of(words: str, judgement: Judgement, law: str) -> Variation:
    """A variation of the worth of (34)."""
    one = judgement.by[ASKED.words]
    return Variation(words, effect(one, law), moves(one, law))


def diverged(evidence: Evidence) -> str:
    """The runs that did not last, and whether the law or its integrator lost them."""
    runs = [one for by in evidence.runs.values() for laws in by.values() for one in laws.values()]
    causes = evidence.causes.values()
    failed, total = sum(one.failed for one in runs), sum(map(len, runs))
    if not failed:
        return f"None of {total:,} runs diverges."
    by_law, by_integrator = sum(one.by_law for one in causes), sum(one.by_integrator for one in causes)
    where = "; ".join(
        f"{law} with {words} in '{scenario}', {len(one.lost['fine'])} of {DRAWS} ({one.sentence})"
        for (scenario, law, words), one in evidence.causes.items()
    )
    return (
        f"{failed:,} of {total:,} runs diverge: {by_law} by the law, {by_integrator} by its integrator, and "
        f"{sum(one.unsettled for one in causes)} for a reason that is not settled. {where}. A run diverges if a state "
        f"is "
        "no longer finite, or an angle is beyond 1e12 rad. The integrator is the reason if the run lasts where the "
        "memories of law and observer move near their exact flow."
    )


def answer(evidence: Evidence) -> str:
    """The line under the title."""
    readings, both = base(evidence, READINGS.key), base(evidence, BOTH.key)
    pooled = evidence.parts.retuned[BASE]
    change = change_of(pooled.whole.by[ASKED.words], RICCATI)[0]
    scenario, less = least_change(pooled, RICCATI)
    words = f" has the lowest mean cost in {{}} of {readings.scenarios} scenarios"
    return (
        f"With raw readings, {lead(readings, words)}; behind observers, {lead(both, ' in {}')}. {PROPOSED} leads in "
        f"{places(both) or 'none'}; retuned without its Riccati equation, it costs {digits(change, '+')} %, without "
        f"'{scenario}' {digits(less, '+')} %."
    )


def lead(change: Change, words: str) -> str:
    """The law that is best in most scenarios, with its count in words; where there is none, the most frequent one."""
    counts = dict(change.counts or {})
    if change.answer in counts:
        return f"{change.answer}{words.format(counts[change.answer])}"
    first = next((f"{law} in {n}" for law, n in counts.items()), "all undecided")
    return f"none leads in most ({first})"
