"""The sections on predictive and linear laws: costs at the usual limits, and what limits are worth."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.d2_planning.batches import AGAIN, DELAYED, DRAWS, MORE
from studies.d2_planning.choices import CANDIDATES, Item
from studies.d2_planning.designs import BY_KEY, laws_of
from studies.d2_planning.evidence import CONFIDENCE, MARGIN, PRIMARY, Condition, Evidence
from studies.d2_planning.predictive import MANY_SWEEPS, MODES
from studies.d2_planning.problems import PROBLEMS, Problem

SHORT = {"arm": "the paper's arm", "tank": "four tanks", "quadrotor": "quadrotor"}
TERMS = ("RMSE", "late RMSE", "variation")


def cost_section(evidence: Evidence) -> wb.Section:
    """The laws at the usual limits."""
    words = (
        "Each plant is brought to a target by two limited inputs. All laws read the same noisy and coarse readings "
        "through the same steady Kalman filter, which also estimates a constant disturbance of each input. The "
        "predictive law, the clipped LQR and the LQR behind a reference governor use this estimate, as do the laws for "
        "the arm. LQI integrates the errors instead, and with anti-windup its integrals are unwound by "
        "back-calculation. All laws clip at the same limits and have the same period. Each was tuned on "
        "the same training runs with the same number of candidates for its own numbers. The cost adds the error of the "
        "whole run, that of its second half and the variation of the inputs, each in units of what is called "
        "acceptable. A run that diverges, or ends far from its target, is lost."
    )
    sweeps = (
        f"All {CANDIDATES} candidates of MPC are tuned with {MANY_SWEEPS} sweeps and {MODES} kept modes, so that none "
        "is preferred because its sweeps err less. The best one then gets the method, the modes and the number of "
        "sweeps that its design derives from a sample of closed loops of the exact law. It is judged with these alone."
    )
    tables = (cost_table(evidence, problem) for problem in PROBLEMS.values())
    last = wb.Paragraph(sweeps), derived_table(evidence)
    return wb.Section("Predictive and linear laws", (wb.Paragraph(words), *tables, *last))


def cost_table(evidence: Evidence, problem: Problem) -> wb.document.ReportTable:
    """The laws of a plant at the usual limits."""
    at = Condition(problem.key)
    comparison = evidence.judge(at).by[PRIMARY.words]
    rows: list[tuple[wb.document.Cell, ...]] = []
    for i, law in enumerate(laws_of(problem)):
        cost = evidence.cost(at, law)
        low, high = comparison.level.low[i], comparison.level.high[i]
        span = f"{low:.3g} to {high:.3g}" if np.isfinite([low, high]).all() else "not bounded"
        terms = np.nanmedian(evidence.terms[at, law.key], axis=0)
        mean = wb.document.MissingCell("runs lost") if evidence.lost_runs(at, law) else float(np.mean(cost))
        rows.append((law.name, mean, span, float(np.nanmedian(cost)), evidence.lost_runs(at, law), *map(float, terms)))
    unit, rate = problem.output_unit, f"{problem.unit}/s"
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("mean cost", align="right", digits=3),
        wb.document.TableColumn("interval", align="right"),
        wb.document.TableColumn("median", align="right", digits=3),
        wb.document.TableColumn("lost", align="right"),
        *(
            wb.document.TableColumn(name, u, "right", digits=3)
            for name, u in zip(TERMS, (unit, unit, rate), strict=True)
        ),
    )
    name = f"{problem.name[0].upper()}{problem.name[1:]}"
    notes = (
        f"{DRAWS} draws. Intervals of the mean at a confidence of {100 * CONFIDENCE:.2f} %, so that those of all "
        "plants and limits hold at once. The last three columns are medians of the terms.",
    )
    return wb.document.ReportTable(f"costs_{problem.key}", f"{name} at its usual limits.", columns, tuple(rows), notes)


def derived_table(evidence: Evidence) -> wb.document.ReportTable:
    """The numbers that the designs of the predictive laws derive from their samples."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for problem in PROBLEMS.values():
        for level in (1.0, problem.levels[0]):
            own = evidence.choices[Item(problem.key, "mpc", level)].design
            if own is None:
                continue
            costs = [
                wb.document.MissingCell("runs lost") if np.isnan(one) else one
                for one in (own.training_cost, own.converged_cost)
            ]
            name = problem.name if level == 1.0 else ""
            evidence_cells = own.largest_error, own.other_error, 100 * own.active_share, own.residual_bound
            rows.append((name, f"{level:g}", own.method, own.sweeps, *evidence_cells, *costs))
    sizes = {(one.loops, one.moves) for item in evidence.choices.values() if (one := item.design)}
    counts = {one.other_loops for item in evidence.choices.values() if (one := item.design)}
    moves = wb.document.join_names([f"{count} moves of {loops} loops" for loops, count in sorted(sizes)])
    others = wb.document.join_names([f"{count}" for count in sorted(counts)])
    columns = (
        wb.document.TableColumn("plant"),
        wb.document.TableColumn("level", align="right"),
        wb.document.TableColumn("method"),
        wb.document.TableColumn("sweeps", align="right"),
        wb.document.TableColumn("error", "spans", "right", digits=2),
        wb.document.TableColumn("in others", "spans", "right", digits=2),
        wb.document.TableColumn("limit acts", "%", "right", digits=2),
        wb.document.TableColumn("residual bound", "spans", "right", digits=2),
        wb.document.TableColumn("training cost", align="right", digits=4),
        wb.document.TableColumn(f"{MANY_SWEEPS} sweeps", align="right", digits=4),
    )
    notes = (
        f"Level: of the limits at which the law was tuned. Error: the largest in {moves} of the exact law, with limits "
        "active in the stated share of the periods. It is sampled, not proved. The design takes the cheapest candidate "
        f"whose error is at most 0.01, and whose cost in these loops and in {others} others is within 1 % of the exact "
        "law's. In others: the largest error along those, by which it was not chosen. A run whose residual passes the "
        "bound, twice the largest of the sample, is beyond what the design has judged. The last two columns are costs "
        "of the chosen weights in the same training "
        f"runs, with the derived sweeps and with {MANY_SWEEPS}.",
    )
    caption = "What the designs of the predictive laws derive, and the cost with more sweeps."
    return wb.document.ReportTable("derived_sweeps", caption, columns, tuple(rows), notes)


def limits_section(evidence: Evidence) -> wb.Section:
    """The cost of each law as a function of the limits."""
    words = (
        "The same runs with other limits of the inputs, which all laws know. The numbers of the laws stay those that "
        "were tuned at the usual limits (level 1). At the tightest limits each law was also tuned anew. A law is as "
        f"good as MPC where the difference of the means is within {100 * MARGIN:g} % or not significant."
    )
    blocks = (wb.Paragraph(words), limit_figure(evidence), ratio_table(evidence), other_table(evidence))
    return wb.Section("What limits are worth", blocks)


def limit_figure(evidence: Evidence) -> wb.document.Figure:
    """Median costs and lost runs by the level of the limits."""
    panels = []
    for problem in PROBLEMS.values():
        marks: list[wb.document.Mark] = []
        mpc = laws_of(problem)[0]
        unit = middle(evidence.cost(Condition(problem.key, problem.levels[-1]), mpc))
        for law in laws_of(problem):
            y = [middle(evidence.cost(Condition(problem.key, level), law)) / unit for level in problem.levels]
            marks.append(wb.document.Series(law.name, np.array(problem.levels), np.array(y), law.style))
        panels.append(wb.document.Panel(COST, tuple(marks), LEVEL, ylim=SHOWN, title=SHORT[problem.key]))
    for problem in PROBLEMS.values():
        marks = []
        for law in laws_of(problem):
            y = [100 * evidence.lost_runs(Condition(problem.key, level), law) / DRAWS for level in problem.levels]
            marks.append(wb.document.Series(law.name, np.array(problem.levels), np.array(y), law.style))
        panels.append(wb.document.Panel("lost runs [%]", tuple(marks), LEVEL, ylim=(-2.0, 50.0)))
    caption = (
        "The median cost of each law over all draws, and the share of lost runs, by the level of the limits. Costs are "
        "multiples of the cost of MPC at the widest limits, and a lost run costs more than any other. Costs beyond "
        f"{SHOWN[1]:g} are not shown."
    )
    return wb.document.Figure("limits", caption, tuple(panels), columns=3)


COST, SHOWN = "median cost (multiple)", (0.6, 2.1)
LEVEL = "limit / usual limit"


def middle(cost: wb.Array) -> float:
    """The median of costs, of which lost runs are the largest; NaN if half of them are lost."""
    value = float(np.median(np.where(np.isnan(cost), np.inf, cost)))
    return value if np.isfinite(value) else np.nan


def ratio_words(evidence: Evidence, at: Condition, rival: str) -> str:
    """The mean cost of a rival over that of MPC, with its interval, or the numbers of lost runs."""
    laws = {law.key: law for law in laws_of(PROBLEMS[at.problem])}
    lost = evidence.lost_runs(at, laws["mpc"]), evidence.lost_runs(at, laws[rival])
    if any(lost):
        return f"lost: {lost[1]} (MPC {lost[0]})"
    one = evidence.judge(at, only=("mpc", rival)).by[PRIMARY.words]
    level = one.level.value[one.samples.place(laws["mpc"].name)]
    i, j = (one.samples.place(laws[key].name) for key in (rival, "mpc"))
    parts = (one.difference.value, one.difference.low, one.difference.high)
    value, low, high = (1 + float(part[i, j] / level) for part in parts)
    span = f"{low:.2f} to {high:.2f}" if low >= 0 and np.isfinite(high) else "not bounded"
    return f"{value:.2f} ({span})"


def ratio_table(evidence: Evidence) -> wb.document.ReportTable:
    """The linear laws beside MPC at each limit."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for problem in PROBLEMS.values():
        for level in problem.levels:
            at = Condition(problem.key, level)
            cells: list[wb.document.Cell] = [problem.name if level == problem.levels[0] else "", f"{level:g}"]
            for rival in ("governor", "lqr", "lqi"):
                text = ratio_words(evidence, at, rival)
                is_decided = evidence.order(at, BY_KEY[rival]) != "undecided"
                cells.append(wb.document.Strong(text) if is_decided else text)
            rows.append(tuple(cells))
    columns = (
        wb.document.TableColumn("plant"),
        wb.document.TableColumn("level", align="right"),
        wb.document.TableColumn("LQR + governor", align="right"),
        wb.document.TableColumn("clipped LQR", align="right"),
        wb.document.TableColumn("LQI + anti-windup", align="right"),
    )
    caption = "The mean cost of linear laws over that of MPC, by the level of the limits."
    notes = (
        "Intervals of paired differences, of all plants and limits at once, in parts of the mean cost of MPC. Bold: "
        "the difference is significant. Where runs are lost the means are infinite, and the numbers of lost runs "
        f"stand instead, of {DRAWS}.",
    )
    return wb.document.ReportTable("limit_ratios", caption, columns, tuple(rows), notes)


def other_table(evidence: Evidence) -> wb.document.ReportTable:
    """Other conditions: tuned anew, with a delay, and with more sweeps."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for problem in PROBLEMS.values():
        for k, law in enumerate(laws_of(problem)):
            tight = problem.levels[0]
            cells: list[wb.document.Cell] = [problem.name if k == 0 else "", law.name]
            for at in (
                Condition(problem.key, tight),
                Condition(problem.key, tight, AGAIN),
                Condition(problem.key),
                Condition(problem.key, 1.0, DELAYED),
            ):
                cells.append(cost_words(evidence, at, law.key))
            rows.append(tuple(cells))
        more = [cost_words(evidence, Condition(problem.key, level, MORE), "mpc") for level in (problem.levels[0], 1.0)]
        rows.append(("", f"MPC, {MANY_SWEEPS} sweeps", more[0], None, more[1], None))
    columns = (
        wb.document.TableColumn("plant"),
        wb.document.TableColumn("law"),
        wb.document.TableColumn("tightest limits", align="right"),
        wb.document.TableColumn("tuned there", align="right"),
        wb.document.TableColumn("usual limits", align="right"),
        wb.document.TableColumn("delayed a period", align="right"),
    )
    notes = (f"Mean cost, or the number of lost runs of {DRAWS}. No law knows of the delay.",)
    return wb.document.ReportTable("other_conditions", "The laws under other conditions.", columns, tuple(rows), notes)


def cost_words(evidence: Evidence, at: Condition, key: str) -> str:
    """The mean cost of a law, or the number of its lost runs."""
    law = next(one for one in laws_of(PROBLEMS[at.problem]) if one.key == key)
    lost = evidence.lost_runs(at, law)
    return f"{lost} lost" if lost else f"{np.mean(evidence.cost(at, law)):.3g}"
