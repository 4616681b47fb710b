"""Bars, points with names and maps of cells on matplotlib's axes, whose limits are set already."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from workbench.report.figures.labels import written
from workbench.report.figures.looks import GREY, LINES, MARKS, POINTS_LOOK, SMALL_LETTERS
from workbench.report.figures.marks import CAP, EDGE, FAINT, WHISKER, ink_on, shades_of, tint, written_cells
from workbench.study.shapes import Bars, HeatMap, Points


def add_bars(bars: Bars, ax: Axes, zorder: float) -> None:
    """Bars with their texts and intervals."""
    starts, ends, rows = (np.asarray(part, dtype=float) for part in (bars.starts, bars.ends, bars.places))
    look: dict[str, Any] = {
        "color": tint(bars.style, bars.shade),
        "edgecolor": LINES[bars.style]["color"],
        "linewidth": EDGE,
    }
    label = written(bars.label) or "_"
    drawn = ax.barh(rows, ends - starts, bars.thick, starts, label=label, zorder=zorder, **look)
    if bars.texts:
        ax.bar_label(drawn, bars.texts, label_type="center", size=SMALL_LETTERS, color=ink_on(bars.style, bars.shade))
    _add_intervals(ax, "x", bars.low, bars.high, rows)


def _add_intervals(ax: Axes, along: str, low: Any, high: Any, aside: Any) -> None:
    """Intervals along an axis, which end at the edge where they go on beyond it."""
    known = ~(np.isnan(low) | np.isnan(high))
    ends = np.clip([low, high], *(ax.get_xlim() if along == "x" else ax.get_ylim()))[:, known]
    strokes = ax.hlines if along == "x" else ax.vlines
    strokes(np.asarray(aside)[known], *ends, zorder=4, **WHISKER)
    caps: dict[str, Any] = {
        "marker": "|" if along == "x" else "_",
        "markersize": 2 * CAP,
        "linestyle": "none",
    } | WHISKER
    for end in ends:
        places = (end, np.asarray(aside)[known])
        ax.plot(*(places if along == "x" else places[::-1]), zorder=4, label="_", **caps)


def add_points(points: Points, ax: Axes, zorder: float) -> None:
    """Points with their intervals, their names up and right of them: only a report looks for free room."""
    _add_intervals(ax, "x", points.xlow, points.xhigh, points.y)
    _add_intervals(ax, "y", points.ylow, points.yhigh, points.x)
    look = LINES[points.style] | MARKS | POINTS_LOOK
    ax.plot(np.asarray(points.x), np.asarray(points.y), label=written(points.label) or "_", zorder=zorder + 2, **look)
    for name, x, y in zip(points.names, np.asarray(points.x), np.asarray(points.y), strict=False):
        ax.annotate(written(name), (x, y), (3, 3), textcoords="offset points", fontsize=SMALL_LETTERS)


def add_map(held: HeatMap, ax: Axes, zorder: float) -> None:
    """Cells with their numbers."""
    shades = shades_of(held)
    for (i, j), text in written_cells(held).items():
        shade = float(shades[i, j])
        cell = Rectangle((j - 0.5, i - 0.5), 1, 1, facecolor=tint(held.style, shade), edgecolor=GREY, linewidth=0.4)
        ax.add_patch(cell).set_zorder(zorder)
        color = FAINT if np.asarray(held.faint)[i, j] else ink_on(held.style, shade)
        ax.text(j, i, text, ha="center", va="center", size=SMALL_LETTERS, color=color, zorder=zorder + 1)
