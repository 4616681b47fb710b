"""The paper's claims, and the verdict on each: which stand, and which fall.

Runs in about a minute on two cores.
"""

from collections.abc import Mapping, Sequence
from typing import get_args

import workbench as wb
from studies.a2_claims import arm, convergence, findings, law, observer, rivals, searches
from studies.a2_claims.checks import HORIZONS, numbers
from studies.a2_claims.observer import ASTRAY
from studies.a2_claims.phrases import phrase
from studies.a2_claims.printed_statements import DEFINITIONS, PRINTED_STATEMENTS, chosen_by, decisive, line_of
from studies.a2_claims.searches import D_MAX, FLOOR, L_D, REACH, SEED, V2_AT_START, WorstRun
from studies.paper.citation import introduction
from studies.paper.comparison import comparison

PAPER_LEDGER, ASSUMED_LEDGER = "The claims one by one", "The comparisons with the numbers of a1"
OUR_LEDGER = "Our repairs and readings"
STEMS = {PAPER_LEDGER: "ledger", ASSUMED_LEDGER: "ledger_assumed", OUR_LEDGER: "ledger_ours"}
WORDS: Mapping[str, str] = {"does not hold under": "false under a condition", "depends on": "depending on Q and R"}
OF_OURS = (
    *("Assumption 3, derived C", "(15), everywhere", "Theorem 1, swinging arm", "Theorem 1, small errors at rest"),
    *("(30), repaired", "(34), input"),
)
LEGEND = (
    "For each claim the tables have its ranges and who chose them: the paper or we. A claim is refuted only if it "
    "fails over the ranges of the paper, in its most favourable reading. A claim that fails only for numbers that we "
    "chose 'depends on' them; a claim that fails only under a condition that we chose 'does not hold under' it. "
    "'Proved' means proved by exact or interval arithmetic, or by the given argument. A finite simulation can refute a "
    "claim, but never prove it. A witness keeps, at every step, each of the claim's hypotheses that a run can break. "
    "The witness is a line of Python. It runs unchanged in the folder of the project, after ",
    wb.document.Code("from studies.a2_claims.replay import *"),
    ", and gives the numbers of its row. ",
    wb.document.Code("rerun"),
    " gives by how much the claim is broken, the error of the step, and the excess of the hypothesis that is kept "
    "most narrowly; this excess is negative if all hypotheses are kept. A proof that rests on a refuted hypothesis has "
    "no consequence here.",
)
WORTH = (
    "Searches use differential evolution on whole batches of runs, with the seed "
    f"{SEED}. The search for (42) samples |q_i(0)| <= pi and |qd_i(0)| <= {REACH['plant.qd'][1]:g} rad/s, as "
    f"Assumption 1 names no numbers. D is one sine for each joint, with |D| <= {D_MAX} N m and |D'| <= {L_D} N m/s. A "
    "run counts only if it keeps its hypotheses at every step.",
    "A run that refutes a claim is repeated at half its step; it must break the claim by more than twice the change. "
    "Its numbers are cut to the fewest decimals that keep 95 % of the violation. A statement on a limit rests on a "
    f"proof, never on a run alone. Interval arithmetic: {wb.proofs.guarantee()}.",
    "Comparisons with the rivals rest on numbers that the paper does not state, and that report a1 assumes: "
    f"{numbers('Q', 'R', 'l', 'SS: a1, a2', 'SS: f')}, {HORIZONS}, and for the rivals the numbers that a1 lists.",
)


CHECKS = {one.claim.name: one.check for one in (*arm.CHECKS, *observer.CHECKS, *law.CHECKS, *convergence.CHECKS)}
CLAIMS = (*(one.claim for one in (*arm.CHECKS, *observer.CHECKS, *law.CHECKS)), *convergence.CLAIMS)
FREE = wb.Case("free swing", "observer (10)", wb.Run(searches.free_loop(*ASTRAY), (), until=2.0, every=5e-3, h=5e-4))


def ruling_of(name: str) -> wb.proofs.Ruling:
    """The ruling on a claim, by its name."""
    return CHECKS[name]()


def ledger(results: wb.Results) -> wb.proofs.ClaimLedger:
    """Every claim with its ruling, in the order of the paper."""
    rulings: dict[str, wb.proofs.Ruling] = dict(zip(CHECKS, results.work("claims"), strict=True))
    rulings[convergence.FINITE_TIME.name] = convergence.finite_time(results.work("worst_run")[0].result)
    ours = (line_of(claim, rulings[claim.name]) for claim in CLAIMS)
    return wb.proofs.ClaimLedger((*ours, *wb.proofs.ClaimLedger.of(rivals.checks(results))))


def group_ledgers(ledger: wb.proofs.ClaimLedger) -> Mapping[str, wb.proofs.ClaimLedger]:
    """The ledger in three: each line in one of them, in its order."""
    groups: dict[str, list[wb.proofs.ClaimEntry]] = {group: [] for group in STEMS}
    for line in ledger:
        name = line.claim.name
        groups[
            OUR_LEDGER if name in OF_OURS else ASSUMED_LEDGER if name.endswith(", numbers of a1") else PAPER_LEDGER
        ].append(line)
    return {group: wb.proofs.ClaimLedger(tuple(lines)) for group, lines in groups.items()}


def count_verdicts(ledger: wb.proofs.ClaimLedger) -> str:
    """The number of lines, and of the lines with each verdict."""
    counts = {kind: ledger.count(kind) for kind in get_args(wb.proofs.Kind)}
    verdicts = ", ".join(f"{count} {WORDS.get(kind, kind)}" for kind, count in counts.items() if count)
    return f"{len(ledger)} claims: {verdicts}"


def swing_figure(results: wb.Results) -> wb.document.Figure:
    """A free swing that the observer loses."""
    runs = results[FREE.scenario, FREE.law].measurement.trajectories
    t, q = runs.t, runs["q"][0]
    lines = {"arm": q, "its estimate by (10)": q - runs["q_error"][0]}
    panels = tuple(
        wb.document.Panel(
            (wb.notation.symbol(f"q_{i + 1}"), " [rad]"),
            tuple(wb.document.Series(label, t, y[:, i], style) for style, (label, y) in enumerate(lines.items())),
            xlim=(0.0, float(t[-1])),
        )
        for i in (0, 1)
    )
    caption = "A freely swinging arm from a rare start, and the estimate by (10) with the gains of section 5."
    return wb.document.Figure("swinging_arm", caption, panels, 2)


def finite_time(worst: WorstRun) -> wb.document.Figure:
    """The sliding variable along the worst run, and the bound of (42)."""
    t, size = worst.t, worst.s
    after = t > 0.05
    allowed = wb.document.Series(
        "V2(0) / (c t), which (42) allows", t[after], V2_AT_START / (FLOOR * t[after]), style="bound"
    )
    panel = wb.document.Panel(
        "size of s [rad/s]",
        (wb.document.Series("as printed but for C", t, size, style=0), allowed),
        xlim=(0.0, float(t[-1])),
    )
    caption = f"(42) along the worst run of the search: the sliding variable, and the bound with c = {FLOOR:g} N m."
    return wb.document.Figure("finite_time", caption, (panel,))


def hypotheses(ledger: wb.proofs.ClaimLedger, line: wb.proofs.ClaimEntry) -> str:
    """The hypotheses of a claim, each with its verdict, or how it stands with one that is no line of the ledger."""
    verdicts = dict(ledger.hypotheses(line.claim.name))
    return "; ".join(
        f"{below.name} ({verdicts[below.name] or ('checked in each run' if below.margin else 'taken as given')})"
        for below in line.claim.hypotheses
    )


def kept_words(line: wb.proofs.ClaimEntry) -> str:
    """The hypotheses that a witness keeps, in words."""
    names = line.ruling.kept_hypotheses if line.ruling.kind in wb.proofs.WITNESS_KINDS else ()
    return f" The witness keeps: {', '.join(names)}." if names else ""


def row(ledger: wb.proofs.ClaimLedger, line: wb.proofs.ClaimEntry) -> tuple[wb.document.Cell, ...]:
    """A line of the ledger as a row of its table."""
    ruling, claim = line.ruling, line.claim
    verdict = (
        wb.document.Strong(ruling.verdict) if ruling.kind in ("proved", *wb.proofs.BREAKING_KINDS) else ruling.verdict
    )
    rests = hypotheses(ledger, line)
    words = f" {claim.statement}" + (f" Rests on: {rests}." if rests else "")
    hollow = (
        " It rests on a refuted hypothesis." if ruling.kind == "proved" and ledger.broken_hypotheses(claim.name) else ""
    )
    left_out = f" Unstated: {ruling.unstated_numbers}." if ruling.unstated_numbers else ""
    witness = (" ", wb.document.Code(ruling.witness)) if ruling.witness else ()
    evidence = (*phrase(ruling.evidence + left_out + hollow + kept_words(line)), *witness)
    return (wb.document.Strong(claim.name), *phrase(words)), phrase(chosen_by(line)), verdict, evidence


def by_equation(ledger: wb.proofs.ClaimLedger) -> wb.document.ReportTable:
    """The printed equations that assert something, each once, with the verdict on each."""
    rows = []
    for item in PRINTED_STATEMENTS:
        line, others = decisive(ledger, item), item.claims[1:]
        more = f" See also {', '.join(others)}." if others else ""
        rows.append(
            (
                item.name,
                phrase(item.quote),
                wb.document.Strong(line.ruling.verdict),
                phrase(line.claim.statement + more),
            )
        )
    columns = (
        wb.document.TableColumn("printed as"),
        wb.document.TableColumn("words of the paper"),
        wb.document.TableColumn("verdict"),
        wb.document.TableColumn("read as"),
    )
    caption = "The printed equations, assumptions and theorems that assert something, each once."
    definitions = ", ".join(f"({number})" for number in DEFINITIONS)
    note = f"Models, definitions and repetitions, which assert nothing by themselves: {definitions}."
    return wb.document.ReportTable("by_equation", caption, columns, tuple(rows), (note,))


def sections(results: wb.Results) -> wb.Page:
    """The answer and its findings, two runs to look at, the printed equations, and the ledger behind them."""
    whole = ledger(results)
    pictures = swing_figure(results), finite_time(*results.work("worst_run"))
    columns = (
        wb.document.TableColumn("claim"),
        wb.document.TableColumn("ranges, and who chose them"),
        wb.document.TableColumn("verdict"),
        wb.document.TableColumn("evidence and witness"),
    )
    tables = (
        wb.document.ReportTable(
            STEMS[name], f"{name}. {count_verdicts(group)}.", columns, tuple(row(whole, line) for line in group)
        )
        for name, group in group_ledgers(whole).items()
    )
    return wb.Page(
        findings.answer(whole),
        findings.findings(whole),
        (
            wb.Section("The printed equations", (*pictures, by_equation(whole))),
            wb.Section("The claims behind them", (wb.Paragraph(LEGEND), *tables)),
            wb.Section("What these verdicts are worth", (wb.document.Itemize(tuple(map(phrase, WORTH))),)),
        ),
    )


def headlines(results: wb.Results) -> Sequence[str]:
    """The answer, then one line for each printed equation."""
    whole = ledger(results)
    return [findings.answer(whole)] + [
        f"{item.name}: {decisive(whole, item).ruling.verdict}" for item in PRINTED_STATEMENTS
    ]


study = wb.Study(
    name="a2_claims",
    title="AOSMC-RGS: the ledger of claims",
    question=(
        "Which of the paper's printed equations, assumptions and theorems are true, which are false, and which depend "
        "on numbers that the paper does not state?"
    ),
    method=(
        f"{introduction(10, 24, 33, 34, 35, 42)} Each printed equation is quoted and judged once, in its most "
        "favourable reading, by one or more claims with their hypotheses and ranges. Identities are judged by exact "
        "normal forms, bounds and equilibria by interval arithmetic, and linear modes by Routh's array in rational "
        "arithmetic. A search for the worst run within the paper's assumptions judges the bound (42). Comparisons with "
        "the rivals are judged as published, and again with the numbers of report a1."
    ),
    cases=(FREE, *comparison("FS"), *comparison("SS")),
    works=(
        wb.Work("claims", ruling_of, tuple(CHECKS), seconds=0.3),
        wb.Work("worst_run", searches.worst_run, (SEED,), seconds=0.6),
    ),
    sections=sections,
    headlines=headlines,
    seed=SEED,
)
