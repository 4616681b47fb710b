"""The section on the paper's arm: six laws beside linear designs with the same crossovers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.d1_benchmarks.arm_designs import (
    DESIGNS,
    INTEGRATING,
    REGULATED,
    SLOW,
    TUNED,
    Crossovers,
    crossovers,
    law_crossovers,
    matching_design,
)
from studies.d1_benchmarks.arm_runs import DRAWS, standings, weighted_standings
from studies.paper.costs import FAMILY, OTHERS, PRIMARY, WEIGHTS
from studies.paper.scenarios import HELD_OUT

EQUAL = "the linear law with equal information"  # for PID the one that uses no model, for the others the one that does
LOWER, HIGHER, OPEN = "the law is lower", "the linear law is lower", "undecided"


@dataclass(frozen=True)
class ArmDesigns:
    """The crossovers of a law of the paper, and of both linear designs that match them."""

    law: Crossovers
    designs: tuple[Crossovers, ...]
    weights: tuple[tuple[float, ...], ...]


def arm_designs(law: str) -> ArmDesigns:
    """The crossovers of a law and of its linear designs."""
    made = [matching_design(design, law) for design in DESIGNS]
    found = tuple(crossovers(one.loop(HELD_OUT[0].at_rest)) for one in made)
    return ArmDesigns(law_crossovers(law), found, tuple(one.weights for one in made))


@dataclass(frozen=True)
class ArmEvidence:
    """The judgements of each law beside its linear laws, by the cost and by the cost with other weights."""

    cost: Mapping[str, wb.evidence.Standings]
    cost_by_weights: Mapping[str, Mapping[str, wb.evidence.Standings]]

    @staticmethod
    def of(results: wb.Results) -> ArmEvidence:
        """The judgements of all runs, made once."""
        return ArmEvidence(
            {law: standings(results, law) for law in TUNED},
            {
                words: {law: weighted_standings(results, law, weights) for law in TUNED}
                for words, weights in WEIGHTS.items()
            },
        )


def tally(verdicts: wb.evidence.Standings, law: str, design: str, words: str = PRIMARY.words) -> dict[str, int]:
    """The scenarios in which a law costs significantly less or more than a linear design, and the undecided ones."""
    orders = [one.by[words].order(law, design) for one in verdicts.judgements.values()]
    return {LOWER: orders.count("below"), HIGHER: orders.count("above"), OPEN: orders.count("undecided")}


def linear_law(law: str, design: str) -> str:
    """The linear law beside a law: one for all laws, or with `EQUAL` the one that knows the model if the law does."""
    if design != EQUAL:
        return design
    return INTEGRATING if law == "PID" else REGULATED


def counts(every: Mapping[str, wb.evidence.Standings], design: str, words: str = PRIMARY.words) -> tuple[int, int, int]:
    """The pairs of a law and a scenario in which the law costs less, more, and neither."""
    sums = [tally(verdicts, law, linear_law(law, design), words) for law, verdicts in every.items()]
    low, high, neither = (sum(one[key] for one in sums) for key in (LOWER, HIGHER, OPEN))
    return low, high, neither


def tallies(every: Mapping[str, wb.evidence.Standings], design: str, words: str = PRIMARY.words) -> str:
    """The sum of the tallies of all laws in words."""
    low, high, neither = counts(every, design, words)
    return f"less in {low}, more in {high}, and neither in {neither}"


def verdict(every: Mapping[str, wb.evidence.Standings], design: str, words: str = PRIMARY.words) -> str:
    """The side that has the lower cost in more of the pairs of a law and a scenario."""
    low, high, _ = counts(every, design, words)
    return "the six laws" if low > high else "the linear laws" if high > low else "neither"


def ratios(verdicts: wb.evidence.Standings, law: str, design: str) -> wb.Array:
    """The mean cost of a linear design over that of the law in each scenario; infinite if one of its runs failed."""
    found = []
    for one in verdicts.judgements.values():
        level = dict(zip(one.samples.laws, one.by[PRIMARY.words].level.value, strict=True))
        found.append(level[design] / level[law])
    return np.array(found)


def changed_answers(evidence: ArmEvidence) -> tuple[wb.Variation, ...]:
    """The answers by the other design, statistics and weights, for one law alone and without each scenario."""
    every = evidence.cost
    return (
        *(wb.Variation(f"all beside {one}", verdict(every, one), tallies(every, one)) for one in DESIGNS),
        *(
            wb.Variation(
                f"by the {one.words} of the cost",
                verdict(every, EQUAL, one.words),
                tallies(every, EQUAL, one.words),
            )
            for one in OTHERS
        ),
        *(
            wb.Variation(f"weights: {words}", verdict(other, EQUAL), tallies(other, EQUAL))
            for words, other in evidence.cost_by_weights.items()
        ),
        *(
            wb.Variation(f"only {law}", verdict({law: verdicts}, EQUAL), tallies({law: verdicts}, EQUAL))
            for law, verdicts in every.items()
        ),
        *(
            wb.Variation(
                f"without scenario '{left}'",
                verdict({law: without(verdicts, left) for law, verdicts in every.items()}, EQUAL),
                tallies({law: without(verdicts, left) for law, verdicts in every.items()}, EQUAL),
            )
            for left in (scenario.name for scenario in HELD_OUT)
        ),
    )


def finding(evidence: ArmEvidence) -> wb.Finding:
    """The worth of the six laws beside linear laws with their crossovers."""
    every = evidence.cost
    base = verdict(every, EQUAL)
    variations = changed_answers(evidence)
    pairs = len(TUNED) * len(HELD_OUT)
    return wb.Finding(
        name="linear_laws_for_the_arm",
        statement=f"Beside a linear law with the same crossovers and equal information, the six laws of the paper cost "
        f"{tallies(every, EQUAL)}, of {pairs} pairs of a law and a scenario.",
        evidence="Each linear law has the gain crossovers of one of the six, joint by joint, so neither is faster near "
        "rest. The numbers of the six laws were tuned for this cost, in two other scenarios. Those of "
        "the linear laws follow from the crossovers alone.",
        statistic="The pairs in which the difference of the mean costs is significant. Intervals of all three laws in "
        f"all scenarios hold at once with a confidence of {100 * FAMILY:g} % for each of the six laws.",
        sample=f"{DRAWS} draws of the arm, the disturbance, the start and the noise in each of the {len(HELD_OUT)} "
        "scenarios of report a8, the same for all laws.",
        information="All laws read noisy positions and velocities, without an observer. PID and the LQR with "
        "integrals beside it use no model of the arm while they run; the other laws and their LQR do.",
        assumptions="The scenarios, the cost and the ranges of the draws of report a8; the pose at which the arm is "
        "linearised, the start of the paper's first scenario; equal weights of both positions; an integral action of "
        f"{SLOW:g} 1/s.",
        fitted_numbers="The numbers of the six laws, as report a8 tuned them for raw readings; the two weights of each "
        "linear law, to the crossovers.",
        answer=base,
        variations=variations,
        limitations="Other measurements, such as those of observers, and linear laws that are tuned for this cost.",
    )


def without(verdicts: wb.evidence.Standings, left: str) -> wb.evidence.Standings:
    """The standings without one scenario."""
    return wb.evidence.Standings({name: one for name, one in verdicts.judgements.items() if name != left})


def section(results: wb.Results, evidence: ArmEvidence) -> wb.Section:
    """The arm under six laws and under linear laws of the same crossovers."""
    about = (
        "How much of the performance of the six laws is due to their form, and how much to their bandwidth? Each law "
        "is compared with two linear laws that have its gain crossovers at both torques, near rest. LQR + model adds "
        "an LQR to the torque that the model needs for the reference motion. LQR with integrals adds integrals of the "
        "position errors, and uses no model while it runs; its gains are designed from one. Of the six, PID uses no "
        "model and is compared with the second for equal information, the others with the first. All run in the same "
        "computer with the same noise and limits."
    )
    blocks = (wb.Paragraph(about), ratio_figure(evidence), crossover_table(results), tally_table(evidence))
    return wb.Section("The paper's arm under linear laws", blocks)


def crossover_table(results: wb.Results) -> wb.document.ReportTable:
    """The crossovers that are matched, and the peaks of the sensitivity."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for law, found in zip(TUNED, results.work("arm_designs"), strict=True):
        for name, one in ((law, found.law), *zip(DESIGNS, found.designs, strict=True)):
            rows.append((law if name == law else "", "" if name == law else name, *one.omega, one.Ms))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("linear law with its crossovers"),
        wb.document.TableColumn("crossover of torque 1", "rad/s", "right", digits=4),
        wb.document.TableColumn("crossover of torque 2", "rad/s", "right", digits=4),
        wb.document.TableColumn("larger Ms", "", "right", digits=3),
    )
    notes = (
        "Each torque is cut while the loop of the other is closed, at rest in the pose in which the paper's first "
        "scenario starts, in the computer of 1 ms. Gains that adapt are held at their first values.",
    )
    return wb.document.ReportTable(
        "arm_crossovers", "The crossovers of each law and of its linear laws.", columns, tuple(rows), notes
    )


def tally_table(evidence: ArmEvidence) -> wb.document.ReportTable:
    """The scenarios in which each law costs less or more than its linear laws."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for law in TUNED:
        verdicts = evidence.cost[law]
        for design in DESIGNS:
            found, share = tally(verdicts, law, design), ratios(verdicts, law, design)
            ends = (_finite(np.min(share)), _finite(np.max(share)))
            rows.append((law if design == DESIGNS[0] else "", design, *found.values(), *ends))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("linear law"),
        wb.document.TableColumn("law lower", align="right"),
        wb.document.TableColumn("linear law lower", align="right"),
        wb.document.TableColumn("undecided", align="right"),
        wb.document.TableColumn("least ratio", "", "right", digits=3),
        wb.document.TableColumn("largest ratio", "", "right", digits=3),
    )
    caption = (
        f"In how many of the {len(HELD_OUT)} scenarios a law of the paper or its linear law has the lower mean cost."
    )
    notes = (
        "The ratio is the mean cost of the linear law over that of the law of the paper: the least and the largest of "
        "the scenarios. Undecided: the difference of the mean costs is not significant.",
    )
    return wb.document.ReportTable("arm_tally", caption, columns, tuple(rows), notes)


def _finite(value: float) -> float | wb.document.MissingCell:
    return float(value) if np.isfinite(value) else wb.document.MissingCell("diverged")


def ratio_figure(evidence: ArmEvidence) -> wb.document.Figure:
    """The costs of the linear laws over those of the laws."""
    panels = []
    for design in DESIGNS:
        marks: list[wb.document.Mark] = []
        for i, law in enumerate(TUNED):
            share = ratios(evidence.cost[law], law, design)
            marks.append(wb.document.Points(law, np.full(len(share), i + 1.0), share, style=i))
        panels.append(
            wb.document.Panel(
                "cost of the linear law / cost of the law",
                tuple(marks),
                "law of the paper, in the order of the table",
                yscale="log",
                title=design,
                hlines=(1.0,),
            )
        )
    caption = (
        "The mean cost of a linear law over that of the law whose crossovers it has; a point for each of the "
        f"{len(HELD_OUT)} scenarios. Above one, the law of the paper costs less."
    )
    return wb.document.Figure("arm_ratios", caption, tuple(panels), columns=2)
