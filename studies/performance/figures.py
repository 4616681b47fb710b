"""The figures of the report on speed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from studies.performance.accuracy import work_precision
from studies.performance.effort import Effort, ours
from studies.performance.engine import compilation, rates
from studies.performance.peers import casadi_cvodes
from studies.performance.row import Row
from workbench.study.document.document import Figure, Panel, Series

STEPS = (2.5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)  # s
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
SLOWEST = 0.05  # runs/s, where the bars begin


def speed_figure(rows: Sequence[Row]) -> Figure:
    """Runs a second of each peer, with that of the engine above, and the most that its bar leaves to each."""
    peers = [row for row in rows if row.ratio is not None and row.runs_per_s is not None]
    mine = [row.runs_per_s * row.ratio for row in peers]
    places = np.arange(1.0, 1 + len(peers))
    bars = [
        Series(row.name, (place, place), (SLOWEST, row.runs_per_s), style=style)
        for style, (row, place) in enumerate(zip(peers, places, strict=True), start=1)
    ]
    most = [rate / row.bar for rate, row in zip(mine, peers, strict=True)]
    panel = Panel(
        "runs/s of one core",
        (
            Series("what its bar leaves to a peer", places, most, "bound", "marks"),
            Series("workbench, beside that peer", places, mine, look="marks"),
            *bars,
        ),
        xlabel="line of the table",
        xlim=(0.5, len(peers) + 0.5),
        yscale="log",
    )
    return Figure("speed", "Runs of W in a second of CPU time of one core; 10 s of simulated time each.", (panel,))


def precision_figure(rows: Sequence[Row], effort: Effort) -> Figure:
    """Error beside speed: the two whose accuracy can be chosen as curves, the others as marks."""
    curves = (
        ("workbench, RK4 at 2.5 to 0.1 ms", work_precision(STEPS, lambda h: partial(_ours, effort, h), effort)),
        ("CVODES, 1e-3 to 1e-8", work_precision(TOLERANCES, partial(casadi_cvodes.runner, effort.horizon), effort)),
    )
    lines = [
        Series(name, *np.array(points).T, style=style, look=look if look == "marks" else "line")
        for style, (name, points) in enumerate(curves)
        for look in ("line", "marks")
    ]
    marks = [
        Series(row.name, [row.error], [row.runs_per_s], style, "marks")
        for style, row in enumerate((r for r in rows if r.error and "CVODES" not in r.name), start=2)
    ]
    panel = Panel(
        "runs/s of one core", (*lines, *marks), xlabel="relative error of the RMSE", xscale="log", yscale="log"
    )
    return Figure("precision", "Error and speed of each at its settings: better is up and to the left.", (panel,))


def _ours(effort: Effort, h: float, p: np.ndarray) -> np.ndarray:
    return ours(p, effort.horizon, h)


def flat_figure(effort: Effort) -> Figure:
    """The rate over the number of runs in a call."""
    found = rates(effort)
    series = [Series("workbench", list(found), list(found.values()), look=look) for look in ("line", "marks")]
    top = 1.15 * max(found.values())
    panel = Panel("runs/s of one core", tuple(series), xlabel="runs in a call", xscale="log", ylim=(0.0, top))
    return Figure("flat", "The rate over the number of runs that are asked for at once.", (panel,))


def compile_figure(effort: Effort) -> Figure:
    """Compile time over the operations of a step, with a straight line through it."""
    size, seconds = np.array([row[1:] for row in compilation(effort)]).T
    slope, start = np.polyfit(size, seconds, 1)
    line = Series(f"{1e6 * slope:.0f} µs an operation", size, start + slope * size, style="bound")
    panel = Panel(
        "time to compile [s]",
        (Series("arms of 2 to 7 links", size, seconds, look="marks"), line),
        xlabel="floating-point operations of a step",
        ylim=(0.0, 1.1 * float(max(seconds))),
    )
    return Figure("compile", "From the step to machine code, in seconds of CPU time, without the cache.", (panel,))
