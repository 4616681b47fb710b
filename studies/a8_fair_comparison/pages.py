"""The page of a8: its answer, its findings, the cost in each scenario, what changes it, and what parts are worth."""

from __future__ import annotations

from dataclasses import replace

import workbench as wb
from studies.a8_fair_comparison import changes, findings, riccati_worth
from studies.a8_fair_comparison.ablations import PARTS, RETUNED_ENTRANTS, RICCATI, STEADY
from studies.a8_fair_comparison.conditions_section import conditions_section
from studies.a8_fair_comparison.evidence import Evidence, evidence
from studies.a8_fair_comparison.other_numbers import PLAIN, run_name
from studies.a8_fair_comparison.tuning_section import trust, tuning
from studies.paper.costs import ACCEPTABLE, PRIMARY
from studies.paper.entrants import ALL_INFORMATION, BOTH, ENTRANTS, FILTER, OBSERVER, READINGS, Information
from studies.paper.entrants import PROPOSED_LAW as PROPOSED
from studies.paper.fitted_page import fitted_page
from studies.paper.rest import REST, rest_section
from studies.paper.scenarios import HELD_OUT, PERIOD, TERMS

KNOBS = (
    "Each law runs with its tuned numbers behind both observers, in scenario 'paper'. Only the noise is random. On the "
    "HTML page a reader can turn the numbers that are drawn at random in the comparison."
)
ERRORS = (
    "Tracking error e of both joints over time, one panel for each law, all on the same axes. The grey area is the "
    "range of all laws. The first second, in which the laws differ, takes half of each panel. The errors of the later "
    "seconds are thinner than a line; the tables below have them as late RMSE."
)
START = 1.0  # s, in which the laws come to the wanted motion
LEFT_OUT = {f"without scenario '{one.name}'" for one in HELD_OUT}  # changes with a table of their own
ORDER = (BOTH, *(given for given in ALL_INFORMATION if given != BOTH))  # as the findings stand


def sections(results: wb.Results) -> wb.Page:
    held = evidence(results)
    page = wb.Page(
        answer=findings.answer(held),
        findings=(
            findings.winner(held, BOTH),
            findings.winner(held, READINGS),
            findings.pooled_cost(held),
            findings.proposed_finding(held),
            findings.riccati(held),
        ),
        sections=(
            wb.Section("Cost in each scenario", (standings(held, BOTH), without_note(standings(held, READINGS)))),
            changes_section(held),
            together(held),
            parts(held),
            wb.Section(
                "Other measurements",
                (
                    wb.Paragraph(lead(held)),
                    without_note(standings(held, FILTER)),
                    without_note(standings(held, OBSERVER)),
                ),
            ),
            conditions_section(),
            tuning(results),
            trust(results, held),
            wb.pictures.loops_section(
                "One run of each law", KNOBS, results.scenario(HELD_OUT[0].name), caption=ERRORS, cut=START
            ),
            rest(results),
        ),
    )
    return fitted_page(page)


def rest(results: wb.Results) -> wb.Section:
    """The linear pictures of the proposed law in its computer, which the knobs move."""
    knobs = (
        f"{PROPOSED} is shown because section 4 removes each of its parts in turn. On the HTML page the knobs of "
        "masses, lengths and friction move these pictures with the runs. Disturbance, phases and starts do not."
    )
    law = f"It has its tuned numbers, both observers, and a computer with a period of {1e3 * PERIOD:g} ms."
    return rest_section(results[REST, PROPOSED], results[HELD_OUT[0].name, PROPOSED], law, knobs)


def lead(evidence: Evidence) -> str:
    """A reason for the lead of RBF-ASMC with raw readings, with its counts."""
    law = "RBF-ASMC"
    raw, filtered = (changes.count_wins(evidence.cost[given.key]).get(law, 0) for given in (READINGS, FILTER))
    return (
        f"The network of {law} has a leak. Near e = 0 it adds a low-pass-filtered feedback of s in parallel to the "
        f"gain K / phi. With raw readings, {law} is therefore the only law with a filter against the noise of the "
        f"velocity. With filtered velocities all laws have one; {law} is then best in {filtered}, not in {raw}."
    )


def standings(evidence: Evidence, information: Information) -> wb.document.Figure:
    judgements = evidence.cost[information.key].judgements
    return wb.pictures.standings_figure(
        f"standings_{information.key}",
        f"Mean cost of each law in each scenario. Every law has {information.words}.",
        {scenario: one.by for scenario, one in judgements.items()},
        PRIMARY.words,
        (),
    )


def without_note(figure: wb.document.Figure) -> wb.document.Figure:
    """A figure without the note that the first of its kind has."""
    return figure if figure.numbers is None else replace(figure, caption=figure.numbers.caption)


def changes_section(evidence: Evidence) -> wb.Section:
    """The number of scenarios in which each law is best, by what was changed."""
    words = (
        "Each row of these tables changes one thing. The second column has the law that is best in more than half of "
        "the scenarios. The third column has the number of scenarios in which each law is best. "
        f"{findings.LOWEST} Where all scenarios are judged together, the second column has the law that is "
        "significantly lowest, and the third the lowest means. "
        f"'Success (<= {ACCEPTABLE:g})' is the share of draws with a cost of at most {ACCEPTABLE:g}: each of the "
        f"{len(TERMS)} terms at its acceptable value. Other weights were judged only for two kinds of measurements: "
        "raw readings (no filter, no estimate), and both observers (estimated state and disturbance)."
    )
    care = (
        "The results of other searches, and of half of the budget, were judged for the three laws with the least cost "
        "in tuning, and for AOSMC-RGS. The second and the third best search of a law are the other two of its three "
        "searches. Each of these changes has two rows. In the first row all laws are compared, the other laws as "
        "tuned: this row shows the effect of the search. In the second row only these few laws are compared. There "
        "are then fewer pairs of laws, the intervals are narrower, and more scenarios are decided."
    )
    tables = (table for given in ORDER for table in (changes_table(evidence, given), without_table(evidence, given)))
    return wb.Section("What changes the answer", (wb.Paragraph(words), wb.Paragraph(care), *tables))


def changes_table(evidence: Evidence, information: Information) -> wb.document.ReportTable:
    """One row for each change of all scenarios: the law that is lowest in most of them, and the tally."""
    whole = {f"all scenarios together, {way}" for way in evidence.pooled_judgements[information.key]}
    rows = [changes.base(evidence, information.key), *changes.changes(evidence, information.key)]
    rows = [row for row in rows if (row.counts is not None or row.words in whole) and row.words not in LEFT_OUT]
    return wb.document.ReportTable(
        f"changes_{information.key}",
        f"The law that is best in most scenarios, by what is changed. Every law has {information.words}.",
        (
            wb.document.TableColumn("what is changed", width=24),
            wb.document.TableColumn("best in most", width=12),
            wb.document.TableColumn("scenarios in which each law is best, or lowest means", width=24),
        ),
        tuple((row.words, row.answer, row.detail) for row in rows),
    )


def without_table(evidence: Evidence, information: Information) -> wb.document.ReportTable:
    """The law that is lowest in most scenarios but one, and over all of them by each way to pool."""
    pools, cost = evidence.pooled_judgements[information.key], evidence.cost[information.key]
    one, others = changes.base(evidence, information.key), [changes.without_scenario(cost, s.name) for s in HELD_OUT]
    rows = [("none", one.answer, one.detail, *(best(pool.whole) for pool in pools.values()))]
    rows += [
        (s.name, one.answer, one.detail, *(best(pool.without[s.name]) for pool in pools.values()))
        for s, one in zip(HELD_OUT, others, strict=True)
    ]
    return wb.document.ReportTable(
        f"without_{information.key}",
        "The effect of leaving one scenario out. Columns 2 and 3: the best law of most of the others. Columns 4 to 6: "
        f"the best law over all the others together, by three means. Every law has {information.words}.",
        (
            wb.document.TableColumn("scenario left out"),
            wb.document.TableColumn("best in most"),
            wb.document.TableColumn("scenarios in which each law is best", width=18),
            *(wb.document.TableColumn(way) for way in pools),
        ),
        tuple(rows),
    )


def best(judgement: wb.evidence.LawJudgement) -> str:
    """The law that is significantly lowest, or `NOBODY`."""
    return judgement.by[PRIMARY.words].best or changes.NOBODY


def together(evidence: Evidence) -> wb.Section:
    words = (
        "The costs of ten scenarios become one number in three ways. The arithmetic mean depends most on the scenario "
        "with the largest costs. The order of the laws by the geometric mean, or by the mean ratio to the best law of "
        "each scenario, stays the same if all costs of one scenario are multiplied by a factor. The last columns have "
        "the arithmetic mean without the scenario that dominates it for most laws, and the scenario with the largest "
        "part of a law's sum. The geometric mean is taken over the scenarios in each draw, and then averaged over the "
        f"draws. Draws with chattering raise the geometric mean of the mean costs in the figures more. {rare(evidence)}"
    )
    tables = (together_table(evidence, given) for given in ORDER)
    return wb.Section("All scenarios together", (wb.Paragraph(words), *tables))


def rare(evidence: Evidence) -> str:
    """The draws of the dominant scenario in which the law of least cost is above what is acceptable."""
    pooled = evidence.pooled_judgements[BOTH.key]
    name, _ = changes.heaviest(pooled[changes.SUM])
    one, paired = pooled[changes.BASE].whole.by[PRIMARY.words], pooled[changes.BASE].members[name]
    law = min(paired.laws, key=lambda law: one.level.value[one.samples.place(law)])
    values = paired.values[:, paired.place(law)]
    above = int((values > ACCEPTABLE).sum())
    return (
        f"In '{name}' most laws behind both observers do not track, but chatter in a limit cycle. {law} costs more "
        f"than {ACCEPTABLE:g} there in {above} of {len(values)} draws; its largest cost is "
        f"{changes.three_digits(values.max())}."
    )


def together_table(evidence: Evidence, information: Information) -> wb.document.ReportTable:
    by = evidence.pooled_judgements[information.key]
    total = by[changes.SUM]
    name, _ = changes.heaviest(total)
    comparisons = [one.whole.by[PRIMARY.words] for one in by.values()] + [total.without[name].by[PRIMARY.words]]
    heads = (*by, f"{changes.SUM} without '{name}'")
    rows = []
    for law in comparisons[0].samples.laws:
        parts = {scenario: share[law] for scenario, share in total.shares.items() if law in share}
        largest = max(parts, key=lambda scenario: parts[scenario]) if parts else None
        part = 100 * parts[largest] if largest else None
        rows.append((law, *(wb.evidence.level_of(one, law) for one in comparisons), largest, part))
    columns = (
        wb.document.TableColumn("law"),
        *(wb.document.TableColumn(head, align="right") for head in heads),
        wb.document.TableColumn("largest part"),
        wb.document.TableColumn("of the sum", "%", "right", digits=2),
    )
    whole = comparisons[0]
    notes = (f"{wb.evidence.BOLD} {wb.evidence.HALF} In each column, {whole.holds}.", whole.samples.footnote)
    return wb.document.ReportTable(
        f"together_{information.key}",
        f"Cost over all scenarios. Every law has {information.words}.",
        columns,
        tuple(rows),
        notes,
    )


def parts_table(evidence: Evidence) -> wb.document.ReportTable:
    """One row for each part: the change of the pooled cost without it, with the same numbers and tuned again."""
    again = evidence.parts.retuned_parts[changes.BASE]
    frozen, retuned = (one.whole.by[PRIMARY.words] for one in (evidence.parts.frozen_parts, again))
    name = riccati_worth.decisive(evidence.parts)
    rest = again.without[name].by[PRIMARY.words]
    searches = evidence.parts.searches.whole.by[PRIMARY.words]
    other, *_ = riccati_worth.change_of(searches, run_name(PROPOSED, "_other"))
    rows: list[tuple[wb.document.Cell, ...]] = [
        (
            f"without {part}",
            wb.evidence.change_without(frozen, part, PROPOSED),
            wb.evidence.change_without(frozen, STEADY, PROPOSED) if part == RICCATI else None,
            wb.evidence.change_without(retuned, part, PROPOSED),
            wb.evidence.change_without(rest, part, PROPOSED),
            len(RETUNED_ENTRANTS[part].tuned_numbers),
        )
        for part in PARTS
    ]
    plain = (wb.evidence.change_without(one, PLAIN, PROPOSED) for one in (retuned, rest))
    rows.append((f"plain {PLAIN}", None, None, *plain, len(ENTRANTS[BOTH.key][1].tuned_numbers)))
    return wb.document.ReportTable(
        "parts",
        f"Change of the geometric mean of the cost over all scenarios when {PROPOSED} loses one of its parts.",
        (
            wb.document.TableColumn("law"),
            wb.document.TableColumn("not tuned again", "%", "right"),
            wb.document.TableColumn("not tuned again, P at its steady value", "%", "right"),
            wb.document.TableColumn("tuned again", "%", "right"),
            wb.document.TableColumn(f"tuned again, without '{name}'", "%", "right"),
            wb.document.TableColumn("numbers tuned", align="right"),
        ),
        tuple(rows),
        (
            "A positive change means that the part lowers the cost. Bold: significant among the draws. Searches are "
            "another source of chance: the second best search of the whole law changes its cost by "
            f"{riccati_worth.digits(other, '+')} %. {wb.evidence.HALF} In each column, {retuned.holds}.",
            retuned.samples.footnote,
        ),
    )


def parts(evidence: Evidence) -> wb.Section:
    """The worth of each part of AOSMC-RGS, as tuned and tuned again."""
    words = (
        "The parameters that were tuned for the whole law do not suit a law that has lost a part. Each law without a "
        "part is therefore also tuned again, with the same budget for each parameter. With the tuned P(0), P begins "
        "as a short pulse: within 0.05 to 0.1 s, (34) takes it to a steady value that is more than a thousand times "
        "smaller, and the rise of K is over after 10 ms. If P is kept at P(0), K grows without end, and the cost "
        "shows nothing about (34). The second column therefore keeps P at the steady value of (34), computed with K = "
        "K(0) and the posture in which a scenario starts. In report a3, P(0) is near the steady value, and keeping it "
        "changes the error by only a few percent. Without the state observer the law takes the noisy readings; "
        f"without the disturbance estimate it is {PROPOSED} behind observer (10). The last tables have the worth "
        "of (34) by other searches."
    )
    by_term = wb.evidence.ablation_table(
        "parts_by_term",
        "Change of the cost and of each of its terms when a part is taken out and the law is tuned again.",
        evidence.parts.by_term,
        PROPOSED,
    )
    worth = riccati_worth.searches_table(evidence.parts), *riccati_worth.costly_draws_table(evidence.parts)
    tables = (parts_table(evidence), by_term, *worth)
    return wb.Section("What each part of AOSMC-RGS is worth", (wb.Paragraph(words), *tables))
