"""How a2 reads: the answers first, then the ledger, then two runs to look at, then what each verdict is worth."""

from collections.abc import Mapping, Sequence
from typing import Literal, get_args

import numpy as np

from studies.a2_claims.checks import HORIZONS, numbers
from studies.a2_claims.groups import grouped
from studies.a2_claims.loops import free_arm
from studies.a2_claims.lyapunov import FLOOR, V2_AT_START
from studies.a2_claims.observers import ASTRAY
from studies.a2_claims.phrases import phrase
from studies.a2_claims.searches import PRINTED, REACH, SEED, found, hunt
from studies.a2_claims.statements import D_MAX, L_D
from workbench.claims.verdicts import BROKEN, Kind, Ledger, Line
from workbench.core import Claim, rk4
from workbench.notation.formula import symbol
from workbench.proofs.interval import guarantee
from workbench.simulate import simulate
from workbench.study.document.document import (
    Cell,
    Code,
    Column,
    Figure,
    Itemize,
    Panel,
    Paragraph,
    Reference,
    Section,
    Series,
    Strong,
    Table,
    Verdict,
    parts,
)
from workbench.validation.refusals import Array

OUTCOME: Mapping[Kind, Literal["holds", "fails", "open", "depends"]] = {
    "proved": "holds",
    "refuted": "fails",
    "does not hold under": "depends",
    "not refuted": "open",
    "not checkable as published": "open",
    "ill-posed": "open",
    "not checkable": "open",
}
# By verdict, with what a finding names: its {samples}, the condition {under} which it fails, what is {unstated}.
SAMPLES: Mapping[Kind, str] = {
    "proved": "All values that the claim allows, by exact or interval arithmetic.",
    "refuted": "A witness, printed in the ledger with all of its digits.",
    "does not hold under": "One choice of numbers: {under}.",
    "not refuted": "{samples} samples of a search.",
    "not checkable as published": "None.",
    "ill-posed": "None.",
    "not checkable": "None.",
}
REVERSALS: Mapping[Kind, str] = {
    "proved": "Nothing, where its hypotheses hold.",
    "refuted": "Nothing, as the claim is worded; a further hypothesis that excludes the witness makes another claim.",
    "does not hold under": "Other numbers under which it holds, if there are any.",
    "not refuted": "One run that breaks it.",
    "not checkable as published": "Publication of {unstated}.",
    "ill-posed": "A statement of what is meant.",
    "not checkable": "A sharper check.",
}
IN_TALLY = {"does not hold under": "not true under the numbers of a1"}
STEMS = ("ledger", "ledger_assumed", "ledger_ours", "ledger_blocks")  # of the tables' files, group by group
RESTS_ON = "Rests on: hypotheses with their verdicts; a proof that rests on a refuted one says nothing here."
FIRST = (
    "Assumption 2",
    "Assumption 3, derived C",
    "(3)",
    "Theorem 1",
    "Theorem 1, gains of section 5",
    "(24)",
    "(33), shapes",
    "(33), gain",
    "(34), cost",
    "(41), along (35)",
    "(42)",
    "Theorem 2, bounded signals",
    "superior tracking",
    "superior tracking, numbers of a1",
)


def answers(ledger: Ledger) -> Section:
    """What was found, before anything else."""
    tallies = "; ".join(f"{_lowered(name)}, {_tally(group)}" for name, group in grouped(ledger).items())
    return Section(
        "What was found",
        (
            Paragraph((f"Claims are counted apart: {tallies}. The paper's are in ", Reference("ledger"), ".")),
            *(_answer(ledger, ledger[name]) for name in FIRST),
        ),
    )


def _tally(ledger: Ledger) -> str:
    """How many lines there are, and how many have which verdict."""
    counts = {kind: ledger.count(kind) for kind in get_args(Kind)}
    words = ", ".join(f"{count} {IN_TALLY.get(kind, kind)}" for kind, count in counts.items() if count)
    return f"{len(ledger)}, of which {words}"


def _lowered(title: str) -> str:
    return title[0].lower() + title[1:]


def _answer(ledger: Ledger, line: Line) -> Verdict:
    claim, finding = line.claim, line.finding
    words = {"samples": f"{finding.samples:,}", "under": finding.under, "unstated": finding.unstated}
    kept = f" The witness keeps: {', '.join(finding.kept)}." if finding.kept and finding.kind in BROKEN else ""
    statement, evidence = f"{claim.name}: {claim.statement}", f"{finding.verdict.capitalize()}. {finding.evidence}"
    if finding.under:  # the verdict is of that condition, and says no more of the claim
        statement, evidence = f"{claim.name}: {finding.verdict}.", f"The claim: {claim.statement} {finding.evidence}"
    return Verdict(
        OUTCOME[finding.kind],
        phrase(statement),
        phrase(evidence),
        phrase(SAMPLES[finding.kind].format(**words)),
        phrase(f"Hypotheses: {_rests(ledger, claim) or 'none'}.{kept}"),
        phrase(REVERSALS[finding.kind].format(**words)),
    )


def _rests(ledger: Ledger, claim: Claim) -> str:
    """The hypotheses of a claim, each with its verdict."""
    verdicts = dict(ledger.hypotheses(claim.name))
    return "; ".join(f"{below.name} ({verdicts[below.name] or _given(below)})" for below in claim.hypotheses)


def the_ledger(ledger: Ledger) -> Section:
    """One table for each group of claims."""
    columns = (Column("claim"), Column("source"), Column("verdict"), Column("evidence and witness"))
    return Section(
        "The ledger",
        (
            Paragraph(
                (
                    "A claim is proved by exact or interval arithmetic, refuted by a witness, or not refuted in so "
                    "many samples; it does not hold under a named condition where a witness breaks it there and other "
                    "numbers may keep it; it is not checkable as published where the paper leaves out what a check "
                    "needs, and ill-posed where it says nothing that could be true or false. A finite simulation can "
                    "refute, and never proves. A witness against a claim keeps each of the claim's hypotheses that a "
                    "run can break, at every step. It is a line of Python that runs as it stands in the folder of the "
                    "project, after ",
                    Code("from studies.a2_claims.replay import *"),
                    ", and gives the numbers of its line from the digits printed here. ",
                    Code("rerun"),
                    " gives by how much its claim is broken, the change as the step is halved, and the excess of the "
                    "hypothesis kept most narrowly, which is negative where all are kept.",
                )
            ),
            *(
                Table(
                    stem,
                    f"{name}, {_tally(group)}. Each with what it rests on, its source, its verdict, the evidence, and "
                    "a witness to replay.",
                    columns,
                    tuple(_row(ledger, line) for line in group),
                    (RESTS_ON,),
                )
                for stem, (name, group) in zip(STEMS, grouped(ledger).items(), strict=True)
            ),
        ),
    )


def _row(ledger: Ledger, line: Line) -> tuple[Cell, ...]:
    finding, claim = line.finding, line.claim
    verdict = Strong(finding.verdict) if finding.kind in ("proved", *BROKEN) else finding.verdict
    rests = _rests(ledger, claim)
    words = f" {claim.statement}" + (f" Rests on: {rests}." if rests else "")
    witness = (" ", Code(finding.witness)) if finding.witness else ()
    hollow = " It rests on a refuted hypothesis." if finding.kind == "proved" and ledger.fallen(claim.name) else ""
    left_out = f" Unstated: {finding.unstated}." if finding.unstated else ""
    kept = f" The witness keeps: {', '.join(finding.kept)}." if finding.kept and finding.kind in BROKEN else ""
    evidence = (*parts(phrase(finding.evidence + left_out + hollow + kept)), *witness)
    return (Strong(claim.name), *parts(phrase(words))), claim.source, verdict, evidence


def _given(hypothesis: Claim) -> str:
    """How it stands with a hypothesis that is no line of the ledger."""
    return "as given" if hypothesis.margin is None else "asked of each run"


def two_runs() -> Section:
    """A run of the observer, and one of (42)."""
    return Section(
        "Two runs to look at",
        (
            Paragraph(
                "The first starts the observer as section 5 does, with estimates of zero, beside the arm that swings "
                "freely from a rare start; its estimate of the position parts from the arm. The second was found by "
                "the search, within the bounds stated below: s exceeds, for a while, what (42) allows."
            ),
            _swinging(),
            _finite_time(),
        ),
    )


def _worst_run(name: str, signals: Sequence[str], h: float, every: float) -> tuple[Array, dict[str, Array]]:
    """The worst run of a search, kept every so many seconds."""
    worst, ode = found(name).worst, hunt(name).watched
    assert worst is not None
    p, x0 = worst.rows(hunt(name).ode)
    runs = simulate(rk4(ode, h), p, x0, until=worst.until, every=every)
    return runs.t, {signal: runs[signal][0] for signal in signals}


def _swinging() -> Figure:
    ode = free_arm()
    x0 = ode.states.pack({"plant.q": ASTRAY[0], "plant.qd": ASTRAY[1]})
    runs = simulate(rk4(ode, 5e-4), None, x0, until=2.0, every=5e-3)
    t, y = runs.t, {signal: runs[signal][0] for signal in ("q", "q_error")}
    estimate = y["q"] - y["q_error"]
    panels = tuple(
        Panel(
            (symbol(f"q_{i + 1}"), " [rad]"),
            (Series("arm", t, y["q"][:, i], style=0), Series("its estimate by (10)", t, estimate[:, i], style=1)),
            xlim=(0.0, float(t[-1])),
        )
        for i in (0, 1)
    )
    return Figure(
        "swinging_arm", "The arm without torque, and its estimate by (10) with the gains of section 5.", panels, 2
    )


def _finite_time() -> Figure:
    t, y = _worst_run("finite_time", ("s",), PRINTED / 2, 5e-3)
    size = np.linalg.norm(y["s"], axis=1)
    after = t > 0.05
    panel = Panel(
        "size of s [rad/s]",
        (
            Series("as printed but for C", t, size, style=0),
            Series("V2(0) / (c t), which (42) allows", t[after], V2_AT_START / (FLOOR * t[after]), style="bound"),
        ),
        xlim=(0.0, float(t[-1])),
    )
    caption = f"The sliding variable of the worst run, and what (42) allows with c = {FLOOR:g} N m."
    return Figure("finite_time", caption, (panel,))


def worth() -> Section:
    """What the verdicts mean and where the searches have looked."""
    fastest, late = REACH["plant.qd"][1], found("late_error")
    assert late.worst is not None
    points = (
        "Identities are proved by normal forms in rational arithmetic, growth and decay of modes by Routh's array in "
        "rational arithmetic with every double taken for the fraction that it is, bounds by intervals "
        f"({guarantee()}).",
        "Searches are differential evolution on whole batches of runs, then exact gradients by sensitivities where "
        f"there are any, with the seed {SEED}. Unless a line says otherwise |q_i(0)| <= pi, |qd_i(0)| <= {fastest:g} "
        f"rad/s, as Assumption 1 names no numbers, and D is a sine a joint with |D| <= {D_MAX} N m, |D'| <= {L_D} "
        "N m/s. A run counts only if it keeps its hypotheses at every step.",
        "A run that refutes is run again at half its step, and breaks the claim by more than the change. Its numbers "
        "are cut to the fewest decimals that keep 95 % of the violation, printed with all of these, and run again by "
        "the tests from the printed page.",
        "What is said of a limit rests on a proof, never on a run alone.",
        "The paper states neither Q, R, l, a1, a2, f nor the horizons. A run with the numbers beside it refutes what "
        "is claimed for all of them; with other numbers the behaviour differs: with small Q the gain of (33) stayed "
        "definite for 30 s, and with small Q and large R (34) lowered the cost of the loop, as the lines on both say.",
        "Comparisons with the rivals stand on numbers that the paper does not state, and that a1 assumes: "
        f"{numbers('Q', 'R', 'l', 'SS: a1, a2', 'SS: f')}, {HORIZONS}, and "
        "for the rivals what a1 lists.",
        f"The worst late error of the repaired law among {late.kept} runs within these bounds is "
        f"{late.worst.value:.3f} rad, from 5 s to {late.worst.until:g} s.",
    )
    return Section("What these verdicts are worth", (Itemize(tuple(map(phrase, points))),))


def headlines(ledger: Ledger) -> list[str]:
    """One line a claim, group by group."""
    groups = grouped(ledger).items()
    return [f"{name}: {_tally(group)}" for name, group in groups] + [
        f"{line.claim.name}: {line.finding.verdict}" for _, group in groups for line in group
    ]
