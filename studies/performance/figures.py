"""The pictures of speed: beside the peers, over the error, over the number of runs, and of compile time."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

import workbench as wb
from studies.paper.workload import rows_of
from studies.performance.measurements import Effort, Row, compilation, error, rate, rates, reference
from studies.performance.peers import Runner, casadi_cvodes
from studies.performance.steps_of_workload import through

STEPS = {  # s
    "rk4": (2.5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4),
    "stabilised": (2.5e-3, 2e-3, 1.25e-3, 1e-3, 5e-4),
    "restarted": (1e-3, 8e-4, 5e-4, 2e-4, 1e-4),
}
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
SLOWEST = 0.05  # runs/s, where the bars begin
RATE = "runs/s of one core"


def speed_figure(rows: Sequence[Row]) -> wb.document.Figure:
    """Runs per second of each peer, that of the engine in the same turns, and the most that the target allows."""
    peers = [row for row in rows if row.error is not None]
    places, speeds = np.arange(1.0, 1 + len(peers)), np.array([row.runs_per_s for row in peers], dtype=float)
    mine = speeds * np.array([row.value for row in peers], dtype=float)
    bars = [
        wb.document.Series(row.name, np.array([place, place]), np.array([SLOWEST, speed]), style=style)
        for style, (row, place, speed) in enumerate(zip(peers, places, speeds, strict=True), start=1)
    ]
    marks = (
        wb.document.Series(
            "most that the target allows a peer", places, mine / [row.bar for row in peers], "bound", "marks"
        ),
        wb.document.Series("workbench, in turns with that peer", places, mine, look="marks"),
    )
    xlim = (0.5, len(peers) + 0.5)
    panel = wb.document.Panel(RATE, (*marks, *bars), xlabel="row of the table of targets", xlim=xlim, yscale="log")
    return wb.document.Figure(
        "speed",
        "Runs of the workload W per second of CPU time of one core. Each run has 10 s of simulated time.",
        (panel,),
    )


def precision_figure(rows: Sequence[Row], effort: Effort) -> wb.document.Figure:
    """Error and speed: the methods whose accuracy can be chosen as curves, the others as marks."""
    wanted = reference(effort)
    p, series = rows_of(effort.samples), []
    curves: dict[str, list[Runner]] = {
        **{
            f"workbench, {method}, {1e3 * steps[0]:g} to {1e3 * steps[-1]:g} ms": [
                partial(through, horizon=effort.horizon, h=h, method=method) for h in steps
            ]
            for method, steps in STEPS.items()
        },
        "CVODES, 1e-3 to 1e-8": [casadi_cvodes(effort.horizon, tolerance) for tolerance in TOLERANCES],
    }
    for style, (name, runners) in enumerate(curves.items()):
        wrong = [(runner, error(runner(p), wanted)) for runner in runners]
        points = [(off, rate(runner, p, effort)) for runner, off in wrong if np.isfinite(off)]
        x, y = np.array(points).T
        series += [wb.document.Series(name, x, y, style, "line"), wb.document.Series(name, x, y, style, "marks")]
    marks = [
        wb.document.Series(row.name, _one(row.error), _one(row.runs_per_s), style, "marks")
        for style, row in enumerate((r for r in rows if r.error and "CVODES" not in r.name), start=4)
    ]
    panel = wb.document.Panel(RATE, (*series, *marks), xlabel="relative error of the RMSE", xscale="log", yscale="log")
    return wb.document.Figure(
        "precision",
        "Error and speed of each tool at its settings. Points farther up and to the left are better.",
        (panel,),
    )


def _one(value: float | None) -> wb.Array:
    """A single number as the array of a mark."""
    return np.array([value], dtype=float)


def flat_figure(effort: Effort) -> wb.document.Figure:
    """The rate over the number of runs in a call."""
    found = rates(effort)
    runs, rate_of = np.array(list(found), dtype=float), np.array(list(found.values()))
    series = (
        wb.document.Series("workbench", runs, rate_of, look="line"),
        wb.document.Series("workbench", runs, rate_of, look="marks"),
    )
    panel = wb.document.Panel(
        RATE, series, xlabel="runs in a call", xscale="log", ylim=(0.0, 1.15 * max(found.values()))
    )
    return wb.document.Figure("flat", "The rate as a function of the number of runs in one call.", (panel,))


def compile_figure(effort: Effort) -> wb.document.Figure:
    """Compile time over the operations of a step, with a straight line through it."""
    size, seconds = np.array([row[1:] for row in compilation(effort)]).T
    slope, start = np.polyfit(size, seconds, 1)
    line = wb.document.Series(f"{1e6 * slope:.0f} µs per operation", size, start + slope * size, style="bound")
    marks = wb.document.Series("arms of 2 to 7 links", size, seconds, look="marks")
    panel = wb.document.Panel("time to compile [s]", (marks, line), xlabel="floating-point operations per step")
    return wb.document.Figure("compile", "The CPU time to compile a step to machine code, without the cache.", (panel,))
