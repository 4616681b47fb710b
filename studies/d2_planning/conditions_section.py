"""The conditions of the comparison, and the numbers that the laws chose."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.d2_planning.choices import CANDIDATES, TRAINING, Item, knobs_of
from studies.d2_planning.designs import laws_of
from studies.d2_planning.evidence import Evidence
from studies.d2_planning.problems import PROBLEMS


def section(evidence: Evidence) -> wb.Section:
    """The conditions and the choices."""
    words = (
        "The plants are those of the workbench with their published numbers. All draws are uniform. The observer is "
        "told the drawn positions of the start; its other estimates start at rest, without a disturbance."
    )
    return wb.Section("Conditions and tuning", (wb.Paragraph(words), condition_table(), choice_table(evidence)))


def condition_table() -> wb.document.ReportTable:
    """Periods, limits, noise and the cost of each plant."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for one in PROBLEMS.values():
        noise = ", ".join(f"{name} {value:g}" for name, value in one.noise)
        ends = ", ".join(f"{low:g} to {high:g}" for low, high in zip(one.low, one.high, strict=True))
        drawn = ", ".join(f"{v.name} {100 * (v.low - 1):+.0f} to {100 * (v.high - 1):+.0f} %" for v in one.unknowns)
        units = ", ".join(f"{value:g}" for value in one.acceptable)
        length = f"{one.stages} of {one.period:g} s"
        rows.append(
            (one.name, length, f"{one.horizon:g}", f"{ends} {one.unit}", noise, drawn, units, f"{one.lost_beyond:g}")
        )
    columns = (
        wb.document.TableColumn("plant", width=12),
        wb.document.TableColumn("stages", width=8),
        wb.document.TableColumn("run", "s", "right"),
        wb.document.TableColumn("usual limits", width=14),
        wb.document.TableColumn("noise", width=12),
        wb.document.TableColumn("drawn", width=18),
        wb.document.TableColumn("acceptable", width=10),
        wb.document.TableColumn("lost", align="right"),
    )
    notes = (
        "Stages: of MPC and of the governor. Noise: standard deviations of readings. Acceptable: RMSE, late RMSE and "
        "variation of the inputs that count one each in the cost. Lost: the late RMSE beyond which a run is lost.",
    )
    caption = "The conditions on each plant."
    return wb.document.ReportTable("problems", caption, columns, tuple(rows), notes)


def choice_table(evidence: Evidence) -> wb.document.ReportTable:
    """The numbers that each law chose at the usual limits."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for problem in PROBLEMS.values():
        for k, law in enumerate(laws_of(problem)):
            choice = evidence.choices[Item(problem.key, law.key)]
            knobs = ", ".join(f"{name} {value:.3g}" for name, value in knobs_of(law, choice).items())
            costs = choice.costs[np.isfinite(choice.costs)]
            lossless = int((choice.losses == 0).sum())
            best = float(choice.costs[choice.best])
            rows.append((problem.name if k == 0 else "", law.name, knobs, best, float(np.median(costs)), lossless))
    columns = (
        wb.document.TableColumn("plant", width=12),
        wb.document.TableColumn("law", width=12),
        wb.document.TableColumn("chosen numbers", width=24),
        wb.document.TableColumn("cost", align="right", digits=3),
        wb.document.TableColumn("median of candidates", align="right", digits=3),
        wb.document.TableColumn("lose no run", align="right"),
    )
    notes = (
        f"Costs are means over {TRAINING} training runs that are not lost. The last column counts the candidates, of "
        f"{CANDIDATES}, that lose no training run. 'load' is the assumed drift of the disturbance in the observer, in "
        "parts of the usual one; 'inputs' and 'rates' are the weights of the inputs and of the states other than the "
        "followed ones, whose weight is 1.",
    )
    caption = "What each law chose at the usual limits."
    return wb.document.ReportTable("choices", caption, columns, tuple(rows), notes)
