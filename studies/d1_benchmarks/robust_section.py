"""The section on published problems of robust and structured design."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

import workbench as wb
from studies.d1_benchmarks.robust_problems import (
    COMPLEIB,
    LEAST,
    MOST,
    PUBLISHED,
    STARTS,
    Bounds,
    Problem,
    StaticDesign,
)

Counts: TypeAlias = tuple[int, int]  # those that are reached, and all
ENOUGH = 6  # digits in which both bounds are printed as one number if they agree


def agrees(problem: Problem, answer: Bounds) -> bool:
    """True if a number between the bounds rounds to the printed figure, or if both keep a printed requirement."""
    if problem.relation == MOST:
        return answer.high <= problem.printed_figure
    if problem.relation == LEAST:
        return answer.low >= problem.printed_figure
    half = 0.5 * 10.0**-problem.digits
    return answer.low - half <= problem.printed_figure <= answer.high + half


def reaches_target(name: str, answer: StaticDesign) -> bool:
    """True if the bound of a norm, in the printed digits, is no more than the best published figure."""
    target = float(COMPLEIB[name]["target"])
    digits = len(str(COMPLEIB[name]["target"]).partition(".")[2])
    return round(answer.gamma.high, digits) <= target


def section(results: wb.Results) -> wb.Section:
    """Both tables with what they say."""
    about = (
        "Each figure below is computed between two bounds and stands beside the figure that is printed for it. The "
        "loops of the satellite look perfect one by one, but they become unstable if one gain grows by a tenth while "
        "the other falls by a tenth. The column has good nominal performance and stays stable under the uncertainty of "
        "its inputs, but this uncertainty costs it its performance. Two masses on a spring are the benchmark of Wie "
        "and Bernstein (1992): a force moves the first, the second is measured, and the loop must be stable for "
        "springs from 0.5 to 2 N/m."
    )
    static = (
        "Five problems of COMPleib ask for static output feedback with a small H-infinity norm. They were chosen, with "
        f"their figures, before any was tuned here. The search is local and runs from {STARTS} starts. The last column "
        "has the least norm of any controller. Its design needs noise on each measurement and is refused without."
    )
    blocks = (wb.Paragraph(about), robust_table(results), wb.Paragraph(static), static_table(results))
    return wb.Section("Published problems of robust design", blocks)


def robust_table(results: wb.Results) -> wb.document.ReportTable:
    """The figures of robust design beside the printed ones."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for problem, answer in zip(PUBLISHED, results.work("robust"), strict=True):
        printed = f"{problem.printed_figure:.{problem.digits}f}".replace("-", "\N{MINUS SIGN}")
        printed = printed if problem.relation == "=" else f"{problem.relation} {printed}"
        printed += "" if problem.was_read else "*"
        verdict = "yes" if agrees(problem, answer) else "no"
        rows.append((problem.name, problem.figure, printed, answer.low, answer.high, verdict, problem.source))
    columns = (
        wb.document.TableColumn("problem"),
        wb.document.TableColumn("figure"),
        wb.document.TableColumn("in print", align="right"),
        wb.document.TableColumn("lower bound", "", "right", digits=ENOUGH),
        wb.document.TableColumn("upper bound", "", "right", digits=ENOUGH),
        wb.document.TableColumn("agrees"),
        wb.document.TableColumn("source"),
    )
    notes = (
        "Agrees: a number between the bounds is the printed figure when it is rounded to its digits, or both bounds "
        "keep a printed requirement. The zeros of the tanks lie between their bounds for all levels, valves and "
        "outlets that round to the printed digits; the printed digits themselves give \N{MINUS SIGN}0.0172 1/s for P-, "
        "and 0.0128 1/s for P+. The peak of T is attained at one spring, and proved for all springs by a real "
        "perturbation. Settling is to 5 % and to 2 % of the peak, where the source says about 15 s. The probability is "
        "over k from 0.5 to 2 N/m and both masses from 0.5 to 1.5 kg. A figure marked * is quoted from memory, as its "
        "source was not at hand; so is the controller of design A. [1] Skogestad and Postlethwaite (2005), "
        "Multivariable Feedback Control, with the section. Of the programs of its authors that were read, the one for "
        "section 3.7.1 has no figure, and the one for figure 8.15 "
        "notes 0.500, 0.5242 and 5.7726 on a grid of frequencies, which may miss a peak. [2] Johansson "
        "(2000), The quadruple-tank process, table II; [3] Benner, Byers, Mehrmann and Xu (2007), Linear Algebra Appl. "
        "425, as a program quotes it; [4] Chait (2003), QFT Toolbox, program "
        "qftex5; [5] Chiang and Safonov (2004), Robust Control Toolbox 2, program accdemo, design 1; [6] Stengel and "
        "Marrison (1992), Robustness of solutions to a benchmark control problem, J. Guidance Control Dyn. 15.",
    )
    return wb.document.ReportTable(
        "robust_problems", "Published figures of robust design.", columns, tuple(rows), notes
    )


def static_table(results: wb.Results) -> wb.document.ReportTable:
    """The static controllers beside the published ones."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for name, answer in zip(COMPLEIB, results.work("static"), strict=True):
        problem = COMPLEIB[name]
        figures = ", ".join(f"{value:g} ({who})" for who, value in problem["figures"].items())
        ends = [end for end in answer.starts if np.isfinite(end)]
        best = sum(end <= min(ends) * 1.001 for end in ends)
        full: wb.document.Cell = answer.full if np.isfinite(answer.full) else wb.document.MissingCell("refused")
        verdict = "yes" if reaches_target(name, answer) else "no"
        rows.append(
            (name, problem["about"], figures, answer.gamma.high, verdict, f"{best} of {len(answer.starts)}", full)
        )
    columns = (
        wb.document.TableColumn("problem"),
        wb.document.TableColumn("plant"),
        wb.document.TableColumn("in print"),
        wb.document.TableColumn("norm here", "", "right", digits=ENOUGH),
        wb.document.TableColumn("no worse"),
        wb.document.TableColumn("starts that end there"),
        wb.document.TableColumn("full order", "", "right", digits=ENOUGH),
    )
    notes = (
        "Norm here: its upper bound. No worse: this bound, rounded to the digits of the best published figure, is no "
        "more than it. Starts that end there: within 0.1 % of the best one. HIFOO and hinfstruct are programs for this "
        "kind of problem. For AC15 and HE4 the figures were read in a published program; those of AC8, HE1 and REA2 "
        "are quoted from memory of the papers that structured_benchmarks.json of this study names. Of one of these "
        "papers, arXiv:2003.02295, the list of problems was read, and the tables were not.",
    )
    return wb.document.ReportTable(
        "static_controllers", "H-infinity norms under static controllers.", columns, tuple(rows), notes
    )


@dataclass(frozen=True)
class Score:
    """The figures of a group that are reached, and all of them: of those that were read, and of those from memory."""

    read: Counts
    from_memory: Counts

    @staticmethod
    def of(verdicts: Sequence[tuple[bool, bool]]) -> Score:
        """The score of verdicts, each a pair: the figure was read, and it is reached."""
        read, from_memory = ([reached for was_read, reached in verdicts if was_read == side] for side in (True, False))
        return Score((sum(read), len(read)), (sum(from_memory), len(from_memory)))


def scores(results: wb.Results) -> tuple[Score, Score]:
    """The figures of robust design, and the norms under static controllers."""
    robust = [
        (one.was_read, agrees(one, answer)) for one, answer in zip(PUBLISHED, results.work("robust"), strict=True)
    ]
    static = [
        (bool(COMPLEIB[name]["figure_was_read"]), reaches_target(name, answer))
        for name, answer in zip(COMPLEIB, results.work("static"), strict=True)
    ]
    return Score.of(robust), Score.of(static)


def count_read(results: wb.Results) -> Counts:
    """The published figures that are reached among those that were read, and all that were read."""
    robust, static = scores(results)
    return robust.read[0] + static.read[0], robust.read[1] + static.read[1]


def finding(results: wb.Results) -> wb.Finding:
    """The published figures that are met."""
    robust, static = scores(results)
    met, count = count_read(results)
    from_memory = robust.from_memory[0] + static.from_memory[0], robust.from_memory[1] + static.from_memory[1]
    quoted = list(dict.fromkeys(one.name for one in PUBLISHED if not one.was_read))
    quoted += [name for name, problem in COMPLEIB.items() if not problem["figure_was_read"]]
    variations = [
        wb.Variation(words, "all" if good == total else "some", f"{good} of {total}")
        for words, (good, total) in (
            ("only figures of robust design that were read", robust.read),
            ("only static controllers whose published figures were read", static.read),
            ("only figures that are quoted from memory", from_memory),
        )
    ]
    return wb.Finding(
        name="published_figures",
        statement=f"Of {robust.read[1]} figures and requirements of robust design that were read, {robust.read[0]} are "
        f"met in all printed digits. Of {static.read[1]} published norms under static controllers that were read, "
        f"{static.read[0]} are reached or undercut.",
        evidence="The figures of robust design are norms, structured singular values, zeros, a least norm, ranges of "
        "springs and a time. Each has a lower and an upper bound here.",
        statistic="A figure is met if a number between the bounds rounds to it, and a requirement if both bounds keep "
        "it. A norm is reached if its upper bound, "
        "in the printed digits, is no more than the best published one.",
        sample=f"{count} figures in published papers and programs; the five problems of COMPleib were chosen before "
        "tuning.",
        information="All numbers of each plant are printed in its source.",
        assumptions=f"{STARTS} starts of each search. {from_memory[1]} more figures are quoted from memory and not "
        f"counted, of which {from_memory[0]} agree: {', '.join(quoted)}.",
        answer="all" if met == count else "some",
        variations=tuple(variations),
        limitations="Figures that are printed with more digits than their data support.",
    )
