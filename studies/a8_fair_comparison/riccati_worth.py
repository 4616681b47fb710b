"""The finding of a8 on the Riccati equation (34): what AOSMC-RGS costs without it, by which searches are compared."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

import workbench as wb
from studies.a8_fair_comparison.ablations import RICCATI, STEADY
from studies.a8_fair_comparison.changes import (
    ASSUMPTIONS,
    BASE,
    FITS,
    LESS,
    SCENARIOS,
    WHOLE,
    sample,
    scenario_words,
    three_digits,
)
from studies.a8_fair_comparison.evidence import Evidence, Parts
from studies.a8_fair_comparison.other_numbers import AGAIN, PLAIN, run_name
from studies.paper.costs import PRIMARY
from studies.paper.entrants import BOTH, PROPOSED_LAW

TIMES = 1000  # percent, from which on a change is printed as a factor
CHATTERS = 20.0  # a cost five times as high as an acceptable one
OPEN = "undecided"
A3 = "better with (34)"  # the answer of a3 to the same question
SEARCHES = ("", *(kind for kind in AGAIN if kind != "_half"))  # the best search, and the others
PAIRS = (
    *product(SEARCHES, SEARCHES),
    ("", "_half"),
    ("_half", ""),
    ("_half", "_half"),
)  # of the whole law, of the other


def effect(one: wb.evidence.Comparison, without: str, whole: str = PROPOSED_LAW) -> str:
    """The effect of a part on the cost of AOSMC-RGS, in words."""
    if one.alike(whole, without):
        return "no difference"
    return {"below": "better with (34)", "above": "worse with (34)"}.get(one.order(whole, without), OPEN)


def change_of(one: wb.evidence.Comparison, without: str, whole: str = PROPOSED_LAW) -> tuple[float, float, float]:
    """The change of the cost of AOSMC-RGS without a part, in percent, and the ends of its interval."""
    at, i, d = one.samples.place(whole), one.samples.place(without), one.difference
    value, low, high = (100 * float(part[i, at] / one.level.value[at]) for part in (d.value, d.low, d.high))
    return value, low, high


def least_change(pooled_judgement: wb.evidence.PooledJudgement, law: str) -> tuple[str, float]:
    """The scenario without which the change of the cost is smallest in size, and that change in percent."""
    changed = {scenario: change_of(one.by[PRIMARY.words], law)[0] for scenario, one in pooled_judgement.without.items()}
    return min(changed.items(), key=lambda pair: abs(pair[1]))


def moves(one: wb.evidence.Comparison, without: str, whole: str = PROPOSED_LAW) -> str:
    """The change of the cost of AOSMC-RGS without a part, as a verb with its number and its interval."""
    value, low, high = change_of(one, without, whole)
    if value >= TIMES:
        return f"rises to {three_digits(1 + value / 100)} times its value"
    verb = "rises" if value > 0 else "falls"
    return f"{verb} by {digits(abs(value))} % ({digits(low, '+')} to {digits(high, '+')} %)"


def digits(percent: float, sign: str = "") -> str:
    """A percentage with two digits, or with all before the point."""
    percent = round(percent, 9) + 0.0  # a rounding error is no decrease: neither 1e-14 nor minus zero
    text = f"{percent:{sign}#.2g}".rstrip(".") if 0 < abs(percent) < 99.5 else f"{percent:{sign}.0f}"
    return text.replace("-", "−")


def spread(judgement: wb.evidence.LawJudgement, rival: str = RICCATI) -> tuple[float, float]:
    """The least and the greatest change of the cost without (34), in percent, among all pairs of searches."""
    one = judgement.by[PRIMARY.words]
    changed = [change_of(one, run_name(rival, b), run_name(PROPOSED_LAW, a))[0] for a, b in product(SEARCHES, SEARCHES)]
    return min(changed), max(changed)


def decisive(parts: Parts) -> str:
    """The scenario without which the searches differ least."""
    pooled = parts.searches
    return min(pooled.without, key=lambda scenario: float(np.ptp(spread(pooled.without[scenario]))))


def worth(parts: Parts) -> str:
    """The effect of (34), if it is the same between all pairs of searches of both laws; else it is not decided."""
    one = parts.searches.whole.by[PRIMARY.words]
    first = effect(parts.retuned_parts[BASE].whole.by[PRIMARY.words], RICCATI)
    others = {effect(one, run_name(RICCATI, b), run_name(PROPOSED_LAW, a)) for a, b in product(SEARCHES, SEARCHES)}
    return first if others == {first} else OPEN


def pair_words(rival: str, whole: str, other: str) -> str:
    """The numbers of the whole law and of a law that is compared with it."""
    numbers = {"": "the best search", **{kind: words for kind, (words, _) in AGAIN.items()}}
    law = "the law without (34)" if rival == RICCATI else f"plain {rival}"
    return f"{law} by {numbers[other]}, the whole law by {numbers[whole]}"


def search_variations(parts: Parts) -> Iterator[wb.Variation]:
    """The worth of (34) by the searches of both laws, with all scenarios and without the decisive one."""
    pooled, name = parts.searches, decisive(parts)
    for rival, (whole, other) in product((RICCATI, PLAIN), PAIRS):
        if whole or other:
            words, laws = pair_words(rival, whole, other), (run_name(rival, other), run_name(PROPOSED_LAW, whole))
            yield effect_of(words, pooled.whole, *laws)
            yield effect_of(f"{words}, without '{name}'", pooled.without[name], *laws, question=LESS)


def riccati_variations(parts: Parts) -> list[wb.Variation]:
    """The worth of (34) by other searches, other pools and other laws without it, and with each scenario left out."""
    rivals: list[tuple[str, wb.evidence.PooledJudgement, str]] = [
        (f"the best search of each law, {way}", pooled, RICCATI) for way, pooled in parts.retuned_parts.items()
    ]
    rivals += [
        ("P at its steady value, not tuned again", parts.frozen_parts, STEADY),
        ("P at the tuned P(0), not tuned again", parts.frozen_parts, RICCATI),
    ]
    rivals += [(f"plain {PLAIN}, {way}", p, PLAIN) for way, p in parts.retuned_parts.items()]
    base_of = (parts.retuned_parts[BASE], RICCATI) if worth(parts) != OPEN else ()
    variations = [effect_of(words, p.whole, law) for words, p, law in rivals if (p, law) != base_of]
    variations += [
        effect_of(f"{words}, without '{s}'", less, law, question=LESS)
        for words, p, law in rivals
        for s, less in p.without.items()
    ]
    return [*search_variations(parts), *variations]


def effect_of(
    words: str, judgement: wb.evidence.LawJudgement, law: str, whole: str = PROPOSED_LAW, question: str = WHOLE
) -> wb.Variation:
    """A variation of the worth of (34)."""
    one = judgement.by[PRIMARY.words]
    return wb.Variation(words, effect(one, law, whole), moves(one, law, whole), question)


def headline(parts: Parts) -> str:
    """The change of the cost of AOSMC-RGS without (34), by the searches, where these have different answers."""
    one, name = parts.retuned_parts[BASE].whole.by[PRIMARY.words], decisive(parts)
    if worth(parts) != OPEN:
        scenario, less = least_change(parts.retuned_parts[BASE], RICCATI)
        return (
            f"With a constant P in place of (34) and tuned again, the cost of {PROPOSED_LAW} {moves(one, RICCATI)} "
            f"over all scenarios together, and changes by {digits(less, '+')} % without '{scenario}'."
        )
    all_of_them, rest = (spread(judgement) for judgement in (parts.searches.whole, parts.searches.without[name]))
    return (
        f"The worth of the Riccati equation (34) is not decided. Tuned again with a constant P, {PROPOSED_LAW} costs "
        f"{more_or_less(all_of_them)} over all scenarios together, depending on which of the three searches of "
        f"each law are compared. Without scenario {scenario_words(name)}, it costs {more_or_less(rest)}."
    )


def more_or_less(span: tuple[float, float]) -> str:
    """A span of changes of a cost, in percent, in words: '33 % less to 43 % more'."""
    low, high = (f"{digits(abs(end))} %" for end in span)
    first, last = ("less" if end < 0 else "more" for end in span)
    if first != last:
        return f"{low} {first} to {high} {last}"
    near, far = (high, low) if first == "less" else (low, high)
    return f"{near} {first}" if near == far else f"{near.removesuffix(' %')} to {far} {first}"


def ends(span: tuple[float, float]) -> str:
    """The ends of a span of changes, in percent."""
    return " to ".join(digits(end, "+") for end in span)


def costly_draws(parts: Parts) -> dict[str, dict[str, list[int]]]:
    """The draws with a high cost, by scenario, by law and for each search, where a search has them in most draws."""
    found = {}
    for name, paired in parts.searches.members.items():
        high = {
            law: [int((paired.values[:, paired.place(run_name(law, kind))] > CHATTERS).sum()) for kind in SEARCHES]
            for law in (PROPOSED_LAW, RICCATI)
        }
        if 2 * max(max(counts) for counts in high.values()) > len(paired):
            found[name] = high
    return found


def failures(parts: Parts) -> str:
    """A sentence on the scenarios in which a search ends at a law with a high cost in most draws; empty without any."""
    found = costly_draws(parts)
    if not found:
        return ""
    most = max(max(counts) for high in found.values() for counts in high.values())
    # the headline has described the decisive scenario
    names = (f"'{name}'" if name == decisive(parts) else scenario_words(name) for name in found)
    draws = len(next(iter(parts.searches.members.values())))
    return (
        f" In {wb.document.join_names(names)}, some searches end at a law that costs more than {CHATTERS:g} in up to "
        f"{most} of {draws} draws."
    )


def costly_draws_table(parts: Parts) -> tuple[wb.document.ReportTable, ...]:
    """One row for each such scenario and law: the draws with a high cost, by the search; no table without any."""
    found = costly_draws(parts)
    if not found:
        return ()
    draws = len(next(iter(parts.searches.members.values())))
    words = {PROPOSED_LAW: "the whole law", RICCATI: "the law without (34)"}
    return (
        wb.document.ReportTable(
            "costly_draws",
            f"The number of draws, of {draws}, with a cost of more than {CHATTERS:g}, by tuning search. "
            "The table has the scenarios in which a search ends at such a cost in most draws.",
            (
                wb.document.TableColumn("scenario"),
                wb.document.TableColumn("law"),
                *(wb.document.TableColumn(f"{place} search", align="right") for place in ("best", "second", "third")),
            ),
            tuple((name, words[law], *counts) for name, high in found.items() for law, counts in high.items()),
        ),
    )


def riccati(evidence: Evidence) -> wb.Finding:
    """The worth of the Riccati equation (34) in AOSMC-RGS."""
    parts = evidence.parts
    one, frozen = parts.retuned_parts[BASE].whole.by[PRIMARY.words], parts.frozen_parts.whole.by[PRIMARY.words]
    plain = change_of(one, PLAIN)[0]
    name, rest = least_change(parts.retuned_parts[BASE], PLAIN)
    answer = worth(parts)
    by_best = (
        f"Between the best searches of both laws, the cost {moves(one, RICCATI)} without (34).{failures(parts)} "
        if answer == OPEN
        else ""
    )
    elsewhere = f" Report a3 has the same question without noise; its answer is '{A3}'." if answer != A3 else ""
    return wb.Finding(
        "riccati_gain",
        headline(parts),
        f"{by_best}Without tuning again, the cost {moves(frozen, STEADY)} if P is kept at its steady value, and "
        f"{moves(frozen, RICCATI)} if P is kept at the tuned P(0). In the whole law, P stays near P(0) for at most "
        f"0.1 s. "
        f"Plain {PLAIN} costs {more_or_less((plain, plain))}, and {more_or_less((rest, rest))} without "
        f"'{name}'.{elsewhere}",
        statistic=f"Change of the {BASE} of the cost over the {SCENARIOS} scenarios, with its interval. The answer is "
        "that of the best searches, if every pair of searches of both laws gives it; otherwise it is 'undecided'.",
        sample=sample(evidence),
        information=f"Both laws have {BOTH.words}.",
        assumptions=f"{ASSUMPTIONS} P is steady for K(0) and the posture in which a scenario starts.",
        fitted_numbers=FITS,
        answer=answer,
        variations=tuple(riccati_variations(parts)),
        limitations="Other shapes of (33), a larger budget, and more than three searches.",
        is_decided=answer != OPEN,
        cites=("a3_riccati_gains/riccati_gain",) if answer == A3 else (),
    )


def searches_table(parts: Parts) -> wb.document.ReportTable:
    """One row for each pair of searches: the change of the cost without (34), and with scenarios left out."""
    pooled, name = parts.searches, decisive(parts)
    whole, rest = pooled.whole.by[PRIMARY.words], pooled.without[name].by[PRIMARY.words]
    others = [one.by[PRIMARY.words] for scenario, one in pooled.without.items() if scenario != name]
    rows: list[tuple[wb.document.Cell, ...]] = []
    for rival, (first, second) in product((RICCATI, PLAIN), PAIRS):
        laws = run_name(rival, second), run_name(PROPOSED_LAW, first)
        changed = [change_of(one, *laws)[0] for one in others]
        cells = (wb.evidence.change_without(one, *laws) for one in (whole, rest))
        rows.append((pair_words(rival, first, second), *cells, ends((min(changed), max(changed)))))
    return wb.document.ReportTable(
        "searches_of_34",
        f"Change of the {BASE} of the cost without (34), by the searches that are compared.",
        (
            wb.document.TableColumn("searches that are compared", width=30),
            wb.document.TableColumn("all scenarios", "%", "right"),
            wb.document.TableColumn(f"without '{name}'", "%", "right"),
            wb.document.TableColumn("without one other scenario", "%", "right"),
        ),
        tuple(rows),
        (
            f"A positive change means that the whole law costs less. The last column has the least and the greatest "
            f"change if one scenario other than '{name}' is left out. Bold: significant; {whole.holds}.",
            whole.samples.footnote,
        ),
    )
