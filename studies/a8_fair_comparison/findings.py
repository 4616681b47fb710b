"""What follows from the judgements of a8: who is best where, what that depends on, and which parts matter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from studies.a8_fair_comparison.conditions import HELD_OUT
from studies.a8_fair_comparison.entrants import BOTH, FILTER, GIVEN, READINGS, Given
from studies.a8_fair_comparison.evidence import (
    ACCEPTABLE,
    ASKED,
    CONTENDERS,
    DRAWS,
    FAMILY,
    FEW,
    MARGIN,
    SEED,
    TOGETHER,
    WORDS,
)
from studies.a8_fair_comparison.laws import PROPOSED
from studies.a8_fair_comparison.results import Found
from workbench.study.document.document import Verdict
from workbench.study.evidence import Judgement, Shape, Standings, shapes

SAMPLE = (
    f"{{draws}} draws in each of {len(HELD_OUT)} scenarios; intervals of all laws and scenarios at once with "
    f"{100 * FAMILY:g} %, a difference counts beyond {100 * MARGIN:g} %"
)
SCENARIOS = len(HELD_OUT)
MEASURE = f"{ASKED.words} cost"
NO_MODEL = ", and to all but PID a model"
SHOWN = 3  # shapes of samples in the words of one finding


def tally(held: Standings, words: str = ASKED.words) -> dict[str, int]:
    """In how many scenarios each law is best by a statistic, those with most first; laws that never are left out."""
    return {law: len(where) for law, where in held.wins[words].items() if where}


def champion(held: Standings, words: str = ASKED.words) -> str | None:
    """The law that is best in most scenarios, which is more than half of them; None if there is none."""
    most = [law for law, count in tally(held, words).items() if 2 * count > len(held.judgements)]
    return most[0] if most else None


def told(held: Standings, words: str = ASKED.words) -> str:
    """A tally in words."""
    counts = tally(held, words)
    rest = len(held.judgements) - sum(counts.values())
    return ", ".join([*(f"{law} {n}" for law, n in counts.items()), *([f"open {rest}"] if rest else [])])


def conditions(found: Found, key: str) -> dict[str, tuple[Standings, str]]:
    """All under which scenarios are counted: each statistic, then what was done otherwise, by the statistic asked."""
    cost = found.cost[key]
    return {words: (cost, words) for words in next(iter(cost.judgements.values())).by} | {
        WORDS[kind]: (held, ASKED.words) for kind, held in found.again[key].items()
    }


def reversals(found: Found, key: str) -> dict[str, str]:
    """What has another champion than the statistic asked, with its law: a search or a budget against the same laws."""
    champions = {words: champion(*pair) for words, pair in conditions(found, key).items()}
    against = {words: champions[WORDS[FEW] if words in WORDS.values() else ASKED.words] for words in champions}
    champions[TOGETHER], against[TOGETHER] = found.together[key].best, champions[ASKED.words]
    return {words: law for words, law in champions.items() if law and words != WORDS[FEW] and law != against[words]}


def winner(found: Found, given: Given) -> Verdict:
    """The law that is best in most scenarios among laws that are given the same, and what turns that round."""
    under = conditions(found, given.key)
    first = champion(found.cost[given.key])
    others = reversals(found, given.key)
    count = tally(found.cost[given.key]).get(first or "", 0)
    tallied = told(found.cost[given.key])
    best = (
        f"{first} has the least {MEASURE} in {count} of {SCENARIOS} scenarios"
        if first
        else f"no law has the least {MEASURE} in most scenarios ({tallied})"
    )
    kind = "depends" if others else "found" if first else "open"
    statement = f"which law is best depends on what is asked: {best}; {_by_law(others)}" if others else best
    return Verdict(
        kind,
        f"Given {given.words}, {statement}.",
        f"Best in so many scenarios by {'; by '.join(f'{words}: {told(*pair)}' for words, pair in under.items())}. "
        f"Over all scenarios together: {found.together[given.key].sentence}.",
        estimand=f"{_upper(MEASURE)}, declared before the runs; {_sample(found)}.",
        given=f"To each law {given.words}{NO_MODEL if given in (READINGS, FILTER) else ''}; its numbers by searches "
        "with one budget a number.",
        reversal=(f"{_upper(_by_law(others))}. " if others else "Nothing that was tried. ")
        + "Tried were the five statistics, all scenarios together, and with the numbers of another search or of half "
        f"of the budget the {CONTENDERS} laws of least training cost and {PROPOSED}, against the same laws as tuned.",
    )


def _by_law(champions: Mapping[str, str]) -> str:
    """Each champion with all that has it first."""
    held: dict[str, list[str]] = {}
    for words, law in champions.items():
        held.setdefault(law, []).append(words)
    return "; ".join(f"{law} by {_and(words)}" for law, words in held.items())


def proposed(found: Found) -> Verdict:
    """How AOSMC-RGS stands, whatever it is given."""
    held = {given: found.cost[given.key] for given in GIVEN}
    counts = {given: tally(one).get(PROPOSED, 0) for given, one in held.items()}
    by = {words: tally(*pair).get(PROPOSED, 0) for words, pair in conditions(found, BOTH.key).items()}
    elsewhere = _and([f"{counts[given] or 'none'} given {given.name}" for given in GIVEN if given != BOTH])
    least = [s for s, one in held[BOTH].judgements.items() if _least(one) == PROPOSED and one.best != PROPOSED]
    tied = f"; in {_and([repr(s) for s in least])} its mean is the least, and tied with others" if least else ""
    return Verdict(
        "depends" if len({2 * n > SCENARIOS for n in by.values()}) > 1 else "found",
        f"{PROPOSED} is significantly best by {MEASURE} in {counts[BOTH] or 'none'} of {SCENARIOS} scenarios behind "
        f"its "
        f"own observers{tied}; it is so in {elsewhere}.",
        f"Behind its own observers {_behind(held[BOTH])}.",
        estimand=f"{_upper(MEASURE)}; {_sample(found)}.",
        given="In each case the same to all laws.",
        reversal=f"Behind its own observers it is best by {', '.join(f'{words} in {n}' for words, n in by.items())}.",
    )


def _least(one: Judgement) -> str:
    """The law of the least level by the statistic asked, significant or not."""
    asked = one.by[ASKED.words]
    return asked.paired.laws[int(np.argmin(asked.level.value))]


def tails(found: Found) -> tuple[Verdict, ...]:
    """The laws with a heavy tail, two groups of runs, or lost ones, and what predicts these."""
    return tuple(one for given in GIVEN if (one := _tails(found, given)))


def _tails(found: Found, given: Given) -> Verdict | None:
    odd: dict[str, dict[str, Shape]] = {}
    for scenario, runs in found.runs[given.key].items():
        first = next(iter(runs.values()))
        values = found.cost[given.key].judgements[scenario].paired
        for shape in shapes(values, first.drawn, first.factors, confidence=1 - (1 - FAMILY) / len(HELD_OUT), seed=SEED):
            if shape.kind != "one group":
                odd.setdefault(shape.law, {})[scenario] = shape
    if not odd:
        return None
    ordered = sorted(odd.items(), key=lambda pair: (pair[0] != PROPOSED, -len(pair[1])))
    counts = ", ".join(f"{law} in {len(where)}" for law, where in ordered)
    first_of_each = (next(iter(where.items())) for _, where in ordered)
    shown = [f"'{scenario}': {shape.sentence}." for scenario, shape in first_of_each][:SHOWN]
    return Verdict(
        "found",
        f"Given {given.words}, the cost has a heavy tail, two groups or lost runs for {counts} of {SCENARIOS} "
        "scenarios: there one number does not describe it.",
        " ".join(shown),
        estimand=f"The shape of each sample, {_sample(found).split(';')[0]}; a false alarm in any with "
        f"{100 - 100 * FAMILY:g} %.",
        given=f"To each law {given.words}.",
        reversal="Other ranges of the draws: the groups are told by what was drawn.",
    )


def diverged(found: Found) -> Verdict:
    """The runs that did not last, and whether the law or its integrator lost them."""
    runs = [one for held in found.runs.values() for laws in held.values() for one in laws.values()]
    total, count = sum(map(len, runs)), sum(one.failed for one in runs)
    by_integrator, by_law, open_ = (
        sum(getattr(one, kind) for one in found.causes.values()) for kind in ("by_integrator", "by_law", "unsettled")
    )
    said = (
        f"{law} given {words} in '{scenario}', {len(one.lost['fine'])} of {DRAWS} ({one.sentence})"
        for (scenario, law, words), one in found.causes.items()
    )
    return Verdict(
        "found",
        f"{count:,} of {total:,} runs diverge: {by_law} by the law, {by_integrator} by its integrator, {open_} "
        "unsettled."
        if count
        else f"All {total:,} runs stay finite.",
        f"Diverged: {'; '.join(said)}." if count else "",
        estimand="A run counts as diverged when a state is no longer finite, or an angle is beyond 1e12 rad. It is "
        "lost by the integrator if it lasts where the memories of law and observer move near their exact flow.",
        given="All laws with the numbers of all searches together.",
    )


def parts_matter(found: Found) -> Verdict:
    """Which parts of AOSMC-RGS lower its mean cost, in the scenarios in which it was taken apart."""
    said: dict[str, dict[str, list[str]]] = {"below": {}, "above": {}, "alike": {}, "undecided": {}}
    for scenario, (judgement, *_) in found.parts.items():
        one = judgement.by[ASKED.words]
        for part in one.paired.laws:
            if part != PROPOSED:
                order = "alike" if one.alike(PROPOSED, part) else one.order(PROPOSED, part)
                said[order].setdefault(part, []).append(scenario)
    words = {
        "below": "cost rises without",
        "above": "cost falls without",
        "alike": f"cost changes by less than {100 * MARGIN:g} % without",
        "undecided": "open is",
    }
    parts = "; ".join(
        f"{words[order]} {', '.join(f'{part} ({_and(where)})' for part, where in held.items())}"
        for order, held in said.items()
        if held
    )
    useful = sorted(set(said["below"]) - set(said["above"]) - set(said["alike"]) - set(said["undecided"]))
    count = len({part for held in said.values() for part in held})
    return Verdict(
        "found",
        f"{len(useful)} of {count} parts of {PROPOSED} lower its {MEASURE} in both scenarios in which it was taken "
        f"apart" + (f": {_and(useful)}." if useful else "."),
        f"As tuned, {parts}.",
        estimand=f"{_upper(MEASURE)} in the scenarios {_and(list(found.parts))}.",
        given="The numbers of the whole law: a part is taken out, and nothing is tuned again.",
        reversal="Tuning what is left again, which was not done.",
    )


def success(found: Found) -> Verdict:
    """How often the cost is acceptable, for the laws behind both observers."""
    held = found.cost[BOTH.key].judgements["paper"]
    name = next(words for words in held.by if words.startswith("success"))
    one = held.by[name]
    shares = sorted(zip(one.paired.laws, 1 - one.level.value, strict=True), key=lambda pair: -pair[1])
    return Verdict(
        "found",
        f"In 'paper', behind both observers, the cost is at most {ACCEPTABLE:g} in "
        + ", ".join(f"{100 * share:.0f} % ({law})" for law, share in shares)
        + " of the draws.",
        "A cost of so much has all terms acceptable on the average.",
    )


def _behind(held: Standings) -> str:
    """The laws that are significantly below AOSMC-RGS, each with the number of scenarios."""
    counts: dict[str, int] = {}
    for judgement in held.judgements.values():
        one = judgement.by[ASKED.words]
        for law in one.paired.laws:
            if law != PROPOSED and one.order(law, PROPOSED) == "below":
                counts[law] = counts.get(law, 0) + 1
    ordered = sorted(counts.items(), key=lambda pair: -pair[1])
    return "below it are " + (", ".join(f"{law} in {n}" for law, n in ordered) or "none")


def _sample(found: Found) -> str:
    judgement: Judgement = next(iter(found.cost[BOTH.key].judgements.values()))
    return SAMPLE.format(draws=len(judgement.paired))


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]


def _and(names: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
