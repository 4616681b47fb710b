"""The findings of a8: the best law of those that are given the same, what that depends on, and which parts matter."""

from __future__ import annotations

from collections import Counter

from studies.a8_fair_comparison.conditions import HELD_OUT
from studies.a8_fair_comparison.entrants import BOTH, FILTER, GIVEN, PROPOSED, READINGS, Given
from studies.a8_fair_comparison.evidence import AS_TUNED, ASKED, DRAWS, FAMILY, MARGIN, Evidence
from workbench.study.document.document import Verdict
from workbench.study.evidence import Standings

SCENARIOS = len(HELD_OUT)
MEASURE = f"{ASKED.words} cost"
TOGETHER = "all scenarios together"


def tally(held: Standings, words: str = ASKED.words) -> dict[str, int]:
    """The number of scenarios in which each law is best by a statistic, most first; laws that never are left out."""
    return {law: len(where) for law, where in held.wins[words].items() if where}


def champion(held: Standings, words: str = ASKED.words) -> str | None:
    """The law that is best in more than half of the scenarios; None if there is none."""
    return next((law for law, count in tally(held, words).items() if 2 * count > len(held.judgements)), None)


def counts(held: Standings, words: str = ASKED.words) -> str:
    """A tally in words."""
    best = tally(held, words)
    tallied = best | {"open": len(held.judgements) - sum(best.values())}
    return ", ".join(f"{law} {n}" for law, n in tallied.items() if n)


def alternatives(evidence: Evidence, key: str) -> dict[str, tuple[Standings, str]]:
    """Each statistic, and then all that was done otherwise by the statistic asked."""
    cost = evidence.cost[key]
    by_statistic = {words: (cost, words) for words in next(iter(cost.judgements.values())).by}
    return by_statistic | {words: (held, ASKED.words) for words, held in evidence.again[key].items()}


def reversals(evidence: Evidence, key: str) -> dict[str, str]:
    """All that has another champion than the statistic asked, a search and a budget against the same laws as tuned."""
    champions = {words: champion(*pair) for words, pair in alternatives(evidence, key).items()}
    against = {words: champions[AS_TUNED if words in evidence.again[key] else ASKED.words] for words in champions}
    champions[TOGETHER], against[TOGETHER] = evidence.together[key].best, champions[ASKED.words]
    return {words: law for words, law in champions.items() if law and words != AS_TUNED and law != against[words]}


def sample(evidence: Evidence) -> str:
    """The sample of each scenario."""
    judgement = next(iter(evidence.cost[BOTH.key].judgements.values()))
    return f"{len(judgement.paired)} draws in each of {SCENARIOS} scenarios"


def winner(evidence: Evidence, given: Given) -> Verdict:
    """The law that is best in most scenarios among laws that are given the same, and what turns that round."""
    cost, together = evidence.cost[given.key], evidence.together[given.key]
    first = champion(cost)
    turned = "; ".join(f"{law} by {words}" for words, law in reversals(evidence, given.key).items())
    by = "; by ".join(f"{words}: {counts(*pair)}" for words, pair in alternatives(evidence, given.key).items())
    return Verdict(
        "depends" if turned else "found" if first else "open",
        f"Given {given.words}, {first or 'no law'} has the least {MEASURE} in most scenarios ({counts(cost)})"
        + (f"; which is best depends on what is asked: {turned}." if turned else "."),
        f"Best in so many scenarios by {by}. Over all scenarios together: {together.sentence}.",
        estimand=f"Mean cost, declared before the runs; {sample(evidence)}; intervals of all laws and scenarios at "
        f"once with {100 * FAMILY:g} %, a difference counts beyond {100 * MARGIN:g} %.",
        given=f"To each law {given.words}{', and to all but PID a model' if given in (READINGS, FILTER) else ''}; its "
        "numbers by searches with one budget a number.",
        reversal=f"{turned or 'Nothing'}. Tried were the other statistics, all scenarios together, another search and "
        "half of the budget.",
    )


def proposed(evidence: Evidence) -> Verdict:
    """The standing of AOSMC-RGS, whatever it is given."""
    best = {given: tally(evidence.cost[given.key]).get(PROPOSED, 0) for given in GIVEN}
    by = {words: tally(*pair).get(PROPOSED, 0) for words, pair in alternatives(evidence, BOTH.key).items()}
    comparisons = [one.by[ASKED.words] for one in evidence.cost[BOTH.key].judgements.values()]
    below = Counter(law for one in comparisons for law in one.paired.laws if one.order(law, PROPOSED) == "below")
    return Verdict(
        "depends" if len({2 * n > SCENARIOS for n in by.values()}) > 1 else "found",
        f"{PROPOSED} is significantly best by {MEASURE} in {best[BOTH]} of {SCENARIOS} scenarios behind its own "
        f"observers, and in {', '.join(f'{n} given {given.name}' for given, n in best.items() if given != BOTH)}.",
        f"Behind its own observers below it are: {', '.join(f'{law} in {n}' for law, n in below.most_common())}.",
        estimand=f"Mean cost; {sample(evidence)}, with the intervals of the verdicts above.",
        given="In each case the same to all laws.",
        reversal=f"Behind its own observers it is best by {', '.join(f'{words} in {n}' for words, n in by.items())}.",
    )


def diverged(evidence: Evidence) -> Verdict:
    """The runs that did not last, and whether the law or its integrator lost them."""
    runs = [one for held in evidence.runs.values() for laws in held.values() for one in laws.values()]
    causes = evidence.causes.values()
    by_law, by_integrator = sum(one.by_law for one in causes), sum(one.by_integrator for one in causes)
    where = (
        f"{law} given {words} in '{scenario}', {len(one.lost['fine'])} of {DRAWS} ({one.sentence})"
        for (scenario, law, words), one in evidence.causes.items()
    )
    return Verdict(
        "found",
        f"{sum(one.failed for one in runs):,} of {sum(map(len, runs)):,} runs diverge: {by_law} by the law, "
        f"{by_integrator} by its integrator, {sum(one.unsettled for one in causes)} unsettled.",
        "; ".join(where),
        estimand="A run counts as diverged when a state is no longer finite, or an angle is beyond 1e12 rad. It is "
        "lost by the integrator if it lasts where the memories of law and observer move near their exact flow.",
        given="All laws with the numbers of all searches together.",
    )


def parts_matter(evidence: Evidence) -> Verdict:
    """The parts of AOSMC-RGS that lower its mean cost, in the scenarios in which it was taken apart."""
    orders: dict[str, list[str]] = {"below": [], "above": [], "alike": [], "undecided": []}
    useful: Counter[str] = Counter()
    for scenario, (judgement, *_) in evidence.parts.items():
        one = judgement.by[ASKED.words]
        for part in one.paired.laws:
            if part != PROPOSED:
                order = "alike" if one.alike(PROPOSED, part) else one.order(PROPOSED, part)
                orders[order].append(f"{part} ({scenario})")
                useful[part] += order == "below"
    lower = sorted(part for part, count in useful.items() if count == len(evidence.parts))
    below, above, alike, undecided = (", ".join(held) or "none" for held in orders.values())
    return Verdict(
        "found",
        f"{len(lower)} of {len(useful)} parts of {PROPOSED} lower its {MEASURE} in each scenario in which it was taken "
        f"apart: {', '.join(lower) or 'none'}.",
        f"As tuned, cost rises without {below}; cost falls without {above}; cost changes by less than "
        f"{100 * MARGIN:g} % without {alike}; open is {undecided}.",
        estimand=f"Mean cost in the scenarios {' and '.join(evidence.parts)}.",
        given="The numbers of the whole law: a part is taken out, and nothing is tuned again.",
        reversal="Tuning what is left again, which was not done.",
    )
