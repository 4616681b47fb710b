"""The paper's claims, and the verdict on each: which stand, and which fall.

Runs in about half a minute on two cores.
"""

from collections.abc import Mapping, Sequence
from typing import get_args

from studies.a1_paper_tables.study import comparison
from studies.a2_claims import arm, law, observer, rivals, searches
from studies.a2_claims.checks import HORIZONS, numbers
from studies.a2_claims.observer import ASTRAY
from studies.a2_claims.phrases import phrase
from studies.a2_claims.searches import D_MAX, FLOOR, L_D, REACH, SEED, V2_AT_START, WorstRun
from workbench.claims.claim_ledger import BROKEN, Finding, Kind, Ledger, Line
from workbench.notation.formula import symbol
from workbench.proofs.interval import guarantee
from workbench.study.contract import Run
from workbench.study.document.document import Figure, Itemize, Panel, Paragraph, Section, Series, Verdict
from workbench.study.document.phrases import Cell, Code, Column, Reference, Strong, Table
from workbench.study.study import Case, Results, Study
from workbench.study.work import Work

# By verdict: how its box is marked, the sample, and what would reverse it, in terms of the fields of a finding.
NOTHING = "Nothing, as the claim is worded; a further hypothesis that excludes the witness makes another claim."
BOXES: Mapping[Kind, tuple[str, str, str]] = {
    "proved": (
        "holds",
        "All values that the claim allows, by exact or interval arithmetic.",
        "Nothing, where its hypotheses hold.",
    ),
    "refuted": ("fails", "A witness, printed in the ledger with all of its digits.", NOTHING),
    "does not hold under": (
        "depends",
        "One choice of numbers: {under}.",
        "Other numbers under which it holds, if there are any.",
    ),
    "not refuted": ("open", "{samples:,} samples of a search.", "One run that breaks it."),
    "not checkable as published": ("open", "None.", "Publication of {unstated}."),
    "ill-posed": ("open", "None.", "A statement of what is meant."),
    "not checkable": ("open", "None.", "A sharper check."),
}
PAPER, ASSUMED = "The paper's claims", "The paper's comparisons under the numbers of a1"
OURS = "Our repairs and readings"
STEMS = {PAPER: "ledger", ASSUMED: "ledger_assumed", OURS: "ledger_ours"}
OF_OURS = (
    *("Assumption 3, derived C", "Theorem 1, swinging arm", "Theorem 1, small errors at rest", "(30), repaired"),
)
FIRST = (
    *("Assumption 2", "Assumption 3, derived C", "(3)", "Theorem 1", "Theorem 1, gains of section 5", "(24)"),
    *("(33), shapes", "(33), gain", "(34), cost", "(41), along (35)", "(42)", "Theorem 2, bounded signals"),
    *("superior tracking", "superior tracking, numbers of a1"),
)
LEGEND = (
    "Proved: by exact or interval arithmetic. Refuted, or not true under a named condition: by a witness. Not "
    "refuted: in so many samples; a finite simulation can refute, and never proves. Not checkable as published: the "
    "paper leaves out what a check needs. Ill-posed: it says nothing that could be true or false. A witness keeps "
    "each of the claim's hypotheses that a run can break, at every step. It is a line of Python that runs as it "
    "stands in the folder of the project, after ",
    Code("from studies.a2_claims.replay import *"),
    ", and gives the numbers of its line. ",
    Code("rerun"),
    " gives by how much its claim is broken, the error of the step, and the excess of the hypothesis kept "
    "most narrowly, which is negative where all are kept. A proof that rests on a refuted hypothesis says nothing "
    "here.",
)
WORTH = (
    "Searches are differential evolution on whole batches of runs, then exact gradients by sensitivities where there "
    f"are any, with the seed {SEED}. |q_i(0)| <= pi, |qd_i(0)| <= {REACH['plant.qd'][1]:g} rad/s, as Assumption 1 "
    f"names no numbers, and D is a sine a joint with |D| <= {D_MAX} N m, |D'| <= {L_D} N m/s. A run counts only if it "
    "keeps its hypotheses at every step.",
    "A run that refutes is run again at half its step, and breaks the claim by more than twice the change. Its numbers "
    "are cut to the fewest decimals that keep 95 % of the violation. What is said of a limit rests on a proof, never "
    f"on a run alone; intervals: {guarantee()}.",
    "Comparisons with the rivals stand on numbers that the paper does not state, and that a1 assumes: "
    f"{numbers('Q', 'R', 'l', 'SS: a1, a2', 'SS: f')}, {HORIZONS}, and for the rivals what a1 lists.",
)


CHECKS = {one.claim.name: one.check for one in (*arm.CHECKS, *observer.CHECKS, *law.CHECKS)}
CLAIMS = (*(one.claim for one in (*arm.CHECKS, *observer.CHECKS)), *law.CLAIMS)
FREE = Case("free swing", "observer (10)", Run(searches.free_loop(*ASTRAY), (), until=2.0, every=5e-3, h=5e-4))


def checked(name: str) -> Finding:
    """The finding on a claim, by its name."""
    return CHECKS[name]()


def ledger(results: Results) -> Ledger:
    """Every claim with its finding, in the order of the paper."""
    findings: dict[str, Finding] = dict(zip(CHECKS, results.work("claims"), strict=True))
    findings[law.FINITE_TIME.name] = law.finite_time(results.work("worst_run")[0].found)
    ours = (Line(claim, findings[claim.name]) for claim in CLAIMS)
    return Ledger((*ours, *Ledger.of(rivals.checks(results))))


def grouped(ledger: Ledger) -> Mapping[str, Ledger]:
    """The ledger in three: each line in one of them, in its order."""
    groups: dict[str, list[Line]] = {group: [] for group in STEMS}
    for line in ledger:
        name = line.claim.name
        groups[OURS if name in OF_OURS else ASSUMED if name.endswith(", numbers of a1") else PAPER].append(line)
    return {group: Ledger(tuple(lines)) for group, lines in groups.items()}


def tally(ledger: Ledger) -> str:
    """The number of lines, and of those of each verdict."""
    counts = {kind: ledger.count(kind) for kind in get_args(Kind)}
    words = ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)
    return f"{len(ledger)}, of which {words.replace('does not hold under', 'not true under the numbers of a1')}"


def swinging(results: Results) -> Figure:
    """A free swing that the observer loses."""
    runs = results[FREE.scenario, FREE.law].measurement.trajectories
    t, q = runs.t, runs["q"][0]
    lines = {"arm": q, "its estimate by (10)": q - runs["q_error"][0]}
    panels = tuple(
        Panel(
            (symbol(f"q_{i + 1}"), " [rad]"),
            tuple(Series(label, t, y[:, i], style) for style, (label, y) in enumerate(lines.items())),
            xlim=(0.0, float(t[-1])),
        )
        for i in (0, 1)
    )
    caption = "An arm that swings freely from a rare start, and its estimate by (10) with the gains of section 5."
    return Figure("swinging_arm", caption, panels, 2)


def finite_time(worst: WorstRun) -> Figure:
    """The sliding variable along the worst run, and the bound of (42)."""
    t, size = worst.t, worst.s
    after = t > 0.05
    allowed = Series("V2(0) / (c t), which (42) allows", t[after], V2_AT_START / (FLOOR * t[after]), style="bound")
    panel = Panel(
        "size of s [rad/s]", (Series("as printed but for C", t, size, style=0), allowed), xlim=(0.0, float(t[-1]))
    )
    caption = f"(42) along the worst run of the search: the sliding variable, and the bound with c = {FLOOR:g} N m."
    return Figure("finite_time", caption, (panel,))


def answer(ledger: Ledger, line: Line) -> Verdict:
    """A line of the ledger as a finding."""
    claim, finding = line.claim, line.finding
    kind, sample, reversal = (words.format(**vars(finding)) for words in BOXES[finding.kind])
    statement, evidence = f"{claim.name}: {claim.statement}", f"{finding.verdict.capitalize()}. {finding.evidence}"
    if finding.under:  # the verdict is of that condition, and says no more of the claim
        statement, evidence = f"{claim.name}: {finding.verdict}.", f"The claim: {claim.statement} {finding.evidence}"
    given = f"Hypotheses: {hypotheses(ledger, line) or 'none'}.{kept(line)}"
    return Verdict(kind, *map(phrase, (statement, evidence, sample, given, reversal)))


def hypotheses(ledger: Ledger, line: Line) -> str:
    """The hypotheses of a claim, each with its verdict, or how it stands with one that is no line of the ledger."""
    verdicts = dict(ledger.hypotheses(line.claim.name))
    return "; ".join(
        f"{below.name} ({verdicts[below.name] or ('asked of each run' if below.margin else 'as given')})"
        for below in line.claim.hypotheses
    )


def kept(line: Line) -> str:
    """The hypotheses that a witness keeps, in words."""
    names = line.finding.kept if line.finding.kind in BROKEN else ()
    return f" The witness keeps: {', '.join(names)}." if names else ""


def row(ledger: Ledger, line: Line) -> tuple[Cell, ...]:
    """A line of the ledger as a row of its table."""
    finding, claim = line.finding, line.claim
    verdict = Strong(finding.verdict) if finding.kind in ("proved", *BROKEN) else finding.verdict
    rests = hypotheses(ledger, line)
    words = f" {claim.statement}" + (f" Rests on: {rests}." if rests else "")
    hollow = " It rests on a refuted hypothesis." if finding.kind == "proved" and ledger.fallen(claim.name) else ""
    left_out = f" Unstated: {finding.unstated}." if finding.unstated else ""
    witness = (" ", Code(finding.witness)) if finding.witness else ()
    evidence = (*phrase(finding.evidence + left_out + hollow + kept(line)), *witness)
    return (Strong(claim.name), *phrase(words)), claim.source, verdict, evidence


def sections(results: Results) -> Sequence[Section]:
    """Two runs to look at and the claims that matter most, the ledger, and the worth of its verdicts."""
    held = ledger(results)
    groups = grouped(held)
    pictures = swinging(results), finite_time(*results.work("worst_run"))
    tallies = "; ".join(f"{name[0].lower()}{name[1:]}, {tally(group)}" for name, group in groups.items())
    counted = Paragraph((f"Claims are counted apart: {tallies}. The paper's are in ", Reference("ledger"), "."))
    columns = (Column("claim"), Column("source"), Column("verdict"), Column("evidence and witness"))
    tables = (
        Table(STEMS[name], f"{name}, {tally(group)}.", columns, tuple(row(held, line) for line in group))
        for name, group in groups.items()
    )
    return (
        Section("What was found", (*pictures, counted, *(answer(held, held[name]) for name in FIRST))),
        Section("The ledger", (Paragraph(LEGEND), *tables)),
        Section("What these verdicts are worth", (Itemize(tuple(map(phrase, WORTH))),)),
    )


def headlines(results: Results) -> Sequence[str]:
    """The tally of each group, then one line a claim."""
    groups = grouped(ledger(results)).items()
    return [f"{name}: {tally(group)}" for name, group in groups] + [
        f"{line.claim.name}: {line.finding.verdict}" for _, group in groups for line in group
    ]


study = Study(
    name="a2_claims",
    title="AOSMC-RGS: the ledger of claims",
    question=(
        "Of what the paper assumes, states as a theorem, derives, and concludes from its simulations: what is "
        "proved, what is refuted by a witness that anyone can replay, what fails under named numbers alone, and "
        "what cannot be checked as published?"
    ),
    method=(
        "Each claim is data: a statement, its source, its hypotheses. Identities are judged by exact normal forms, "
        "bounds and rest points by interval arithmetic, linear modes by Routh's array in rational arithmetic; what "
        "only a run can break, by a search for the worst run within the paper's assumptions; comparisons with the "
        "rivals twice, as published and on the numbers of a1."
    ),
    cases=(FREE, *comparison("FS"), *comparison("SS")),
    works=(
        Work("claims", checked, tuple(CHECKS), seconds=0.3),
        Work("worst_run", searches.worst_run, (SEED,), seconds=0.6),
    ),
    sections=sections,
    headlines=headlines,
    seed=SEED,
)
