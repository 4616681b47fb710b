"""The page of a8: its answer and its findings, the cost in each scenario, what changes an answer, and what parts are "
"worth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from studies.a8_fair_comparison import changes, findings, riccati_worth
from studies.a8_fair_comparison.ablations import PARTS, RETUNED, RICCATI, STEADY
from studies.a8_fair_comparison.conditions import HELD_OUT
from studies.a8_fair_comparison.conditions_section import conditions_section
from studies.a8_fair_comparison.entrants import BOTH, ENTRANTS, FILTER, GIVEN, LAWS, OBSERVER, PROPOSED, READINGS, Given
from studies.a8_fair_comparison.evidence import ACCEPTABLE, ASKED, MARGIN, Evidence, evidence
from studies.a8_fair_comparison.other_numbers import PLAIN, run_name
from studies.a8_fair_comparison.tuning_section import trust, tuning
from workbench.study.document.document import Column, Figure, Page, Paragraph, Section, Table
from workbench.study.evidence import ablation_table, change_without, level_of
from workbench.study.evidence.comparison_tables import BOLD, HALF
from workbench.study.pictures import standings_figure
from workbench.study.pictures.traces import loops_section
from workbench.study.study import Results

KNOBS = (
    "Each law as it was tuned behind both observers, in the first held-out scenario with one draw of the noise. On the "
    "page of this report, the conditions that are drawn are knobs."
)
BRACKETS = HALF.replace("in brackets", "In brackets:")


def sections(results: Results) -> Page:
    held = evidence(results)
    return Page(
        answer=findings.answer(held),
        findings=(
            findings.winner(held, BOTH),
            findings.winner(held, READINGS),
            findings.pooled_cost(held),
            findings.proposed(held),
            findings.riccati(held),
        ),
        sections=(
            Section("Cost in each scenario", (standings(held, BOTH), short(standings(held, READINGS)))),
            changed(held),
            together(held),
            parts(held),
            Section(
                "Other measurements",
                (Paragraph(lead(held)), short(standings(held, FILTER)), short(standings(held, OBSERVER))),
            ),
            conditions_section(),
            tuning(results),
            trust(results, held),
            loops_section("The laws with knobs", KNOBS, results.outcomes),
        ),
    )


def lead(held: Evidence) -> str:
    """A reason for the lead of RBF-ASMC with raw readings, with its counts."""
    law = "RBF-ASMC"
    raw, filtered = (changes.tally(held.cost[given.key]).get(law, 0) for given in (READINGS, FILTER))
    return (
        f"The network of {law} has a leak. Near e = 0 it acts as a low-pass filter of s beside the gain K / phi. With "
        f"raw readings {law} is therefore the one law with a filter against the noise of the velocity. With filtered "
        f"velocities all laws have one, and {law} has the lowest cost in {filtered} scenarios in place of {raw}."
    )


def standings(held: Evidence, given: Given) -> Figure:
    judgements = held.cost[given.key].judgements
    return standings_figure(
        f"standings_{given.key}",
        f"Cost of the laws in each scenario. Every law has {given.words}.",
        {scenario: one.by for scenario, one in judgements.items()},
        ASKED.words,
        (),
    )


def short(shown: Figure) -> Figure:
    """A figure without the note that the first of its kind has."""
    return replace(shown, caption=shown.numbers.caption)


def changed(held: Evidence) -> Section:
    """The number of scenarios in which each law is best, by what was done otherwise."""
    words = (
        "A row has the number of scenarios in which a law has the lowest cost, beyond its interval and "
        f"{100 * MARGIN:g} %. The last column has the law that is lowest in more than half of them. Where all "
        "scenarios are judged together there are no numbers, and it has the law that is significantly lowest. Laws "
        "that are lowest in at most one scenario by each change share a column. Other weights were judged for raw "
        "readings and for both observers alone: the least and the most that a law can measure."
    )
    care = (
        "Other searches and half of the budget were run for the three laws with the least cost in tuning, and for "
        "AOSMC-RGS. The second and the third best search of a law are the other two of its three searches. Each of "
        "these changes has two rows. In the first the other laws stay as tuned, and all 66 pairs of laws are "
        "compared, so that the row shows the search alone. In the second these few laws are compared alone. There are "
        "then fewer pairs, the intervals are narrower, and more scenarios are decided."
    )
    tables = (table for given in GIVEN for table in (changes_table(held, given), without_table(held, given)))
    return Section("What changes the answer", (Paragraph(words), Paragraph(care), *tables))


def changes_table(held: Evidence, given: Given) -> Table:
    """One row a change, one column a law that is best in a scenario by one of them."""
    whole = {f"all scenarios together, {way}" for way in held.pooled[given.key]}
    rows = [changes.base(held, given.key), *changes.changes(held, given.key)]
    rows = [row for row in rows if row.counts is not None or row.words in whole]
    most = {law.name: max((row.counts or {}).get(law.name, 0) for row in rows) for law in LAWS}
    laws = [law for law, n in most.items() if n > 1]
    rest = any(n == 1 for n in most.values())
    columns = (
        Column("what is changed"),
        *(Column(law, align="right") for law in [*laws, "another law"][: None if rest else -1]),
        Column("undecided", align="right"),
        Column("lowest in most"),
    )
    return Table(
        f"changes_{given.key}",
        f"Scenarios in which each law has the lowest cost. Every law has {given.words}.",
        columns,
        tuple((row.words, *counts_of(row, laws, rest), row.answer) for row in rows),
    )


def without_table(held: Evidence, given: Given) -> Table:
    """The law that is significantly lowest over all scenarios but one, by each way to pool."""
    pools = held.pooled[given.key]
    rows = [("none", *(one.answer for one in pools.values()))]
    rows += [(s.name, *(one.answers[s.name] for one in pools.values())) for s in HELD_OUT]
    return Table(
        f"without_{given.key}",
        f"The law with the lowest cost over all scenarios but one. Every law has {given.words}.",
        (Column("scenario left out"), *map(Column, pools)),
        tuple(rows),
    )


def counts_of(row: changes.Change, laws: Sequence[str], rest: bool) -> tuple[int | None, ...]:
    """The scenarios of each law, of all other laws and the undecided ones; missing where all are judged together."""
    if row.counts is None:
        return (None,) * (len(laws) + rest + 1)
    shown, total = [row.counts.get(law, 0) for law in laws], sum(row.counts.values())
    return (*shown, *[total - sum(shown)] * rest, row.scenarios - total)


def together(held: Evidence) -> Section:
    words = (
        "Costs of ten scenarios become one number in three ways. The arithmetic mean depends most on the scenario "
        "with the largest costs. The ratio to the best of each scenario and the geometric mean do not depend on the "
        "unit of a scenario. The last columns name the scenario with the largest part of a law's sum, and the mean "
        "without the scenario that dominates for most laws. The geometric mean is that of each draw, and then the mean "
        "over the draws. It is therefore not the geometric mean of the levels in the figures above, which a law that "
        f"chatters in few draws raises more. {rare(held)}"
    )
    return Section("All scenarios together", (Paragraph(words), *(together_table(held, given) for given in GIVEN)))


def rare(held: Evidence) -> str:
    """The draws of the dominant scenario in which the law of least cost is above what is acceptable."""
    pooled = held.pooled[BOTH.key]
    name, _ = changes.heaviest(pooled[changes.SUM])
    one, paired = pooled[changes.BASE].whole.by[ASKED.words], pooled[changes.BASE].members[name]
    law = min(paired.laws, key=lambda law: one.level.value[one.paired.place(law)])
    values = paired.values[:, paired.place(law)]
    above = int((values > ACCEPTABLE).sum())
    return (
        f"In '{name}' most laws behind both observers do not track, but chatter in a limit cycle. Of {law} "
        f"{above} of {len(values)} draws cost more than {ACCEPTABLE:g} there, at most {changes.rounded(values.max())}."
    )


def together_table(held: Evidence, given: Given) -> Table:
    by = held.pooled[given.key]
    total = by[changes.SUM]
    name, _ = changes.heaviest(total)
    comparisons = [one.whole.by[ASKED.words] for one in by.values()] + [total.without[name].by[ASKED.words]]
    heads = (*by, f"{changes.SUM} without '{name}'")
    rows = []
    for law in comparisons[0].paired.laws:
        parts = {scenario: share[law] for scenario, share in total.shares.items() if law in share}
        largest = max(parts, key=lambda scenario: parts[scenario]) if parts else None
        part = 100 * parts[largest] if largest else None
        rows.append((law, *(level_of(one, law) for one in comparisons), largest, part))
    columns = (
        Column("law"),
        *(Column(head, align="right") for head in heads),
        Column("largest part"),
        Column("of the sum", "%", "right", digits=2),
    )
    whole = comparisons[0]
    notes = (f"{BOLD} {BRACKETS}; {whole.holds}.", whole.paired.said)
    return Table(
        f"together_{given.key}", f"Cost over all scenarios. Every law has {given.words}.", columns, tuple(rows), notes
    )


def parts_table(held: Evidence) -> Table:
    """One row a part: the change of the pooled cost without it, with the numbers of the whole law and tuned again."""
    frozen, retuned = held.parts.frozen.whole.by[ASKED.words], held.parts.retuned[changes.BASE].whole.by[ASKED.words]
    name = riccati_worth.decisive(held.parts)
    rest = held.parts.retuned[changes.BASE].without[name].by[ASKED.words]
    searches = held.parts.searches.whole.by[ASKED.words]
    other, *_ = riccati_worth.change_of(searches, run_name(PROPOSED, "_other"))
    rows = [
        (
            f"without {part}",
            change_without(frozen, part, PROPOSED),
            change_without(frozen, STEADY, PROPOSED) if part == RICCATI else None,
            change_without(retuned, part, PROPOSED),
            change_without(rest, part, PROPOSED),
            len(RETUNED[part].tuned),
        )
        for part in PARTS
    ]
    plain = (change_without(one, PLAIN, PROPOSED) for one in (retuned, rest))
    rows.append((f"plain {PLAIN}", None, None, *plain, len(ENTRANTS[BOTH.key][1].tuned)))
    return Table(
        "parts",
        f"Change of the geometric mean of the cost over all scenarios, as {PROPOSED} loses one of its parts.",
        (
            Column("law"),
            Column("numbers of the whole law", "%", "right"),
            Column("P at its steady value", "%", "right"),
            Column("tuned again", "%", "right"),
            Column(f"tuned again, without '{name}'", "%", "right"),
            Column("numbers tuned", align="right"),
        ),
        tuple(rows),
        (
            f"A positive change says that the part lowers the cost. Bold: significant, by the chance of the draws; "
            f"the second best search of the whole law changes its cost by {riccati_worth.digits(other, '+')} %. "
            f"{BRACKETS}; {retuned.holds}.",
            retuned.paired.said,
        ),
    )


def parts(held: Evidence) -> Section:
    """The worth of each part of AOSMC-RGS, as tuned and tuned again."""
    words = (
        "A law that loses a part with the numbers of the whole law is not tuned for what is left. So each law without "
        "a part is tuned again, with the same budget for each of its numbers. The tuned P(0) is a start pulse. (34) "
        "takes it within 0.05 to 0.1 s to a steady value that is more than a thousand times smaller, and K has taken "
        "its rise after 10 ms. To keep P at P(0) therefore makes K grow without end, and says nothing about (34). The "
        "second column keeps P at the steady value for K(0) at the posture in which a scenario starts. In a3 P(0) is "
        "near the steady value, so that P kept at P(0) has another effect there: it changes the error by a few "
        "percent. Without the state observer the law takes the noisy readings; without the disturbance estimate it is "
        f"{PROPOSED} behind observer (10). The last table has what (34) is worth by other searches."
    )
    by_term = ablation_table(
        "parts_by_term",
        "The same change of the cost and of each of its terms, each law without a part tuned again.",
        held.parts.by_term,
        PROPOSED,
    )
    last = riccati_worth.searches_table(held.parts)
    return Section("What each part of AOSMC-RGS is worth", (Paragraph(words), parts_table(held), by_term, last))
