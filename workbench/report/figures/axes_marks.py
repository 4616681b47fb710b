"""Bars, points with names, maps of cells and tiles on matplotlib's axes, whose limits are set already."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from workbench.report.figures.labels import written
from workbench.report.figures.looks import GREY, LINES, MARKS, POINTS_LOOK, SMALL_LETTERS
from workbench.report.figures.marks import CAP, EDGE, FAINT, WHISKER, ink_on, shades_of, tint, written_cells
from workbench.report.figures.tiles import FRAME, ink_over, tone
from workbench.study.document.shapes import Bars, HeatMap, Points, Tiles

ROOM = 0.05  # of the abscissa: what a bar takes at least whose text is printed


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
        wide = np.abs(ends - starts) > ROOM * abs(np.diff(ax.get_xlim()))
        texts = [text if room else "" for text, room in zip(bars.texts, wide, strict=True)]
        ax.bar_label(drawn, texts, label_type="center", size=SMALL_LETTERS, color=ink_on(bars.style, bars.shade))
    _add_intervals(ax, "x", bars.low, bars.high, rows)


def _add_intervals(ax: Axes, along: str, low: Any, high: Any, aside: Any) -> None:
    """Intervals along an axis, with an arrow at the edge where they go on beyond it."""
    known = ~(np.isnan(low) | np.isnan(high))
    ends, beside = np.array([low, high])[:, known], np.asarray(aside)[known]
    seen = np.clip(ends, *(ax.get_xlim() if along == "x" else ax.get_ylim()))
    strokes = ax.hlines if along == "x" else ax.vlines
    strokes(beside, *seen, zorder=4, **WHISKER)
    for end, place, arrow in zip(ends, seen, "<>" if along == "x" else "v^", strict=True):
        for which, mark in ((end == place, "|" if along == "x" else "_"), (end != place, arrow)):
            x, y = (place[which], beside[which]) if along == "x" else (beside[which], place[which])
            ax.plot(x, y, mark, markersize=2 * CAP, zorder=4, label="_", clip_on=False, **WHISKER)


def add_points(points: Points, ax: Axes, zorder: float) -> None:
    """Points with their intervals, their names up and right of them: only a report looks for free room."""
    _add_intervals(ax, "x", points.xlow, points.xhigh, points.y)
    _add_intervals(ax, "y", points.ylow, points.yhigh, points.x)
    look = LINES[points.style] | MARKS | POINTS_LOOK
    ax.plot(
        np.asarray(points.x),
        np.asarray(points.y),
        label=written(points.label) or "_",
        zorder=zorder + 2,
        clip_on=False,
        **look,
    )
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


def add_tiles(tiles: Tiles, ax: Axes, zorder: float) -> None:
    """Tiles with their texts and what marks them: a triangle is the marked corner."""
    for (i, j), shade in np.ndenumerate(np.asarray(tiles.shades)):
        text = "\n".join(tiles.texts[i][j])
        if text or not np.isnan(shade):
            look: dict[str, Any] = {"facecolor": tone(float(np.nan_to_num(shade))), "edgecolor": GREY, "linewidth": 0.4}
            hatch = "///" if tiles.hatched[i, j] else None
            ax.add_patch(Rectangle((j - 0.5, i - 0.5), 1, 1, hatch=hatch, zorder=zorder, **look))
            color = ink_over(float(np.nan_to_num(shade)))
            if tiles.framed[i, j]:
                ax.add_patch(Rectangle((j - 0.45, i - 0.45), 0.9, 0.9, fill=False, linewidth=FRAME, zorder=zorder + 1))
            if tiles.marked[i, j]:
                ax.fill([j + 0.3, j + 0.5, j + 0.5], [i - 0.5, i - 0.5, i - 0.2], color, zorder=zorder + 1)
            size = SMALL_LETTERS / (1 + 0.3 * (tiles.lines - 1))
            ax.text(j, i, text, ha="center", va="center", size=size, color=color, linespacing=0.9, zorder=zorder + 2)
