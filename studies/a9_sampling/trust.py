"""The trust in the numbers of a9: the errors of the step, and what the step adds to chattering."""

from collections.abc import Sequence

import numpy as np

import workbench as wb
from studies.a9_sampling.evidence import (
    PERIODS,
    SWITCHING,
    Curve,
    Evidence,
)
from studies.a9_sampling.loops import MS, NOISY, SEED
from studies.paper.quiet_periods import (
    RMSE,
    TV,
)


def steps_figure(curves: Sequence[Curve]) -> wb.document.Figure:
    """Total variation over the step of the simulation."""
    panels = []
    for law in dict.fromkeys(one.law for one in curves):
        series = []
        for style, one in enumerate(curve for curve in curves if curve.law == law):
            label = f"{SWITCHING[one.switching]}, {f'computer of {MS}' if one.digital else 'continuous time'}"
            points = label, 1e3 * one.h, one.TV[:, 0], style
            series += [wb.document.Series(*points), wb.document.Series(*points, look="marks")]
        axes = "TV of joint 1 [N m/s]", tuple(series), "step [ms]"
        panels.append(wb.document.Panel(*axes, xscale="log", yscale="log", title=law))
    caption = (
        "Total variation of the first torque against the Runge-Kutta step, first scenario, 10 s. In continuous time "
        "this is the step of the loop; with the computer it is the step of the plant within a period."
    )
    return wb.document.Figure("tv_steps", caption, tuple(panels), columns=2)


def steps_table(curves: Sequence[Curve]) -> wb.document.ReportTable:
    """The change of total variation with the step of the simulation."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for one in curves:
        by = f"computer of {MS}" if one.digital else "continuous time"
        rows.append(
            (one.law, SWITCHING[one.switching], by, len(one.h), float((one.TV.max(axis=0) / one.TV.min(axis=0)).max()))
        )
    columns = (
        *map(wb.document.TableColumn, ("law", "switching", "run in")),
        wb.document.TableColumn("steps tried", align="right"),
        wb.document.TableColumn("largest TV over smallest", "times", "right", digits=4),
    )
    notes = ("The larger ratio of the two joints, first scenario, 10 s. The period of the computer stays the same.",)
    return wb.document.ReportTable(
        "steps", "The change of the total variation with the step of the simulation.", columns, tuple(rows), notes
    )


def trust_section(evidence: Evidence, curves: Sequence[Curve]) -> wb.Section:
    """The errors of the step, and the share of chattering that the simulation alone makes."""
    rows = [(1e3 * T, *(100 * evidence.worst_step(metric, T) for metric in (RMSE, TV))) for T in PERIODS]
    columns = (
        wb.document.TableColumn("period", "ms"),
        *(wb.document.TableColumn(name, "%", "right", digits=2) for name in (RMSE, TV)),
    )
    errors = wb.document.ReportTable(
        "errors",
        "The largest error of the step, over all laws, joints and scenarios, with exact readings.",
        columns,
        tuple(rows),
        ("Twice the change by half the substep, relative to the value, for all runs that stay finite.",),
    )
    lost = np.array([one.is_lost for (_, _, computer), one in evidence.audits.items() if computer])
    words = (
        "In continuous time RK4 runs at half of the steps of report a1, and at a quarter for the error. Beyond the "
        "stability limit of RK4 the step itself causes chattering, and with a relay in continuous time the TV grows "
        "with each shorter step. A run that chatters depends on rounding: at 5 and 10 ms one run of an adaptive law is "
        f"one of many possible runs, and the runs with noise show how they differ. Of {len(lost)} loops with a "
        f"computer {lost[:, 0].sum()} diverged with exact readings, and {lost[:, 1:].sum()} of {NOISY * len(lost)} "
        "runs with noise. A run that diverged is named, counts as larger than all others, and is in no mean. The seed "
        f"of the noise is {SEED}."
    )
    return wb.Section(
        "How far these numbers can be trusted", (wb.Paragraph(words), errors, steps_figure(curves), steps_table(curves))
    )
