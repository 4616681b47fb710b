"""Bars, and points with names, drawn by the pen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import to_hex, to_rgb

from workbench.report.figures.labels import extent, mathtext
from workbench.report.figures.pen import INK, Box, Pen
from workbench.report.figures.placing import FAR, placed
from workbench.report.figures.rulers import Ruler
from workbench.report.figures.style import LINES, POINTS_LOOK, SMALL_LETTERS
from workbench.study.document.figure import Bars, Points, Style
from workbench.validation.refusals import Array

CAP = 2.0  # points: half of the mark at the end of an interval
ARROW = 3.5  # points: the arrow of an interval that goes on beyond the panel
WHISKER: dict[str, Any] = {"color": "#000000", "linewidth": 0.7}
EDGE = 0.6  # points: the outline of a bar
LEADER = {"color": "#999999", "linewidth": 0.4}
DIGIT = 0.676  # of the size of the letters: the height of a digit


def tint(style: Style, shade: float) -> str:
    """A colour thinned with white: none of it at 0, all of it at 1."""
    red, green, blue = (1 - shade * (1 - part) for part in to_rgb(LINES[style]["color"]))
    return to_hex((red, green, blue))


def ink_on(style: Style, shade: float) -> str:
    """Black or white, whichever is read better on a tint."""
    red, green, blue = to_rgb(tint(style, shade))
    return "#ffffff" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.5 else INK


def draw_bars(pen: Pen, box: Box, bars: Bars, x: Ruler, y: Ruler) -> None:
    """Bars with their texts, then their intervals."""
    starts, ends = (np.clip(x.share(part), 0, 1) for part in (bars.starts, bars.ends))
    rows = np.asarray(bars.places)
    thick = abs(float(y.share(bars.thick) - y.share(0.0))) * box.height
    middle = box.bottom + box.height * y.share(rows)
    for k in np.flatnonzero(np.isfinite(ends)).tolist():
        left, right = box.left + box.width * starts[k], box.left + box.width * ends[k]
        edges = np.array([left, right, right, left, left])
        sides = middle[k] + thick / 2 * np.array([-1, -1, 1, 1, -1])
        fill_box(pen, edges, sides, bars.style, bars.shade, box)
        text = bars.texts[k] if bars.texts else ""
        width = extent(text, SMALL_LETTERS).width if text else 0.0
        if text and width + 3 < abs(right - left):
            foot = middle[k] - DIGIT * SMALL_LETTERS / 2
            pen.words(text, (left + right - width) / 2, foot, SMALL_LETTERS, color=ink_on(bars.style, bars.shade))
    for k in np.flatnonzero(np.isfinite(ends)).tolist():
        _draw_interval(pen, box, x, (bars.low, bars.high), k, middle[k])


def fill_box(pen: Pen, x: Array, y: Array, style: Style, shade: float, within: Box | None = None) -> None:
    """A filled polygon with its outline."""
    pen.area(x, y, tint(style, shade), 1.0, within)
    pen.line(x, y, {"color": LINES[style]["color"], "linewidth": EDGE}, within)


def _draw_interval(
    pen: Pen, box: Box, ruler: Ruler, ends: Any, k: int, beside: float, upwards: bool = False
) -> list[float]:
    """An interval along a ruler, capped where it ends and with an arrow where it goes on; returns its segment."""
    low, high = (float(np.asarray(end)[k]) for end in ends)
    if np.isnan(low) or np.isnan(high):
        return []
    start, length = (box.bottom, box.height) if upwards else (box.left, box.width)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = [_share(ruler, low, -np.inf), _share(ruler, high, np.inf)]
    at = start + length * np.clip(shares, 0, 1)

    def stroke(along: list[float], aside: list[float]) -> None:
        lengthwise, crosswise = np.array(along), beside + np.array(aside)
        x, y = (crosswise, lengthwise) if upwards else (lengthwise, crosswise)
        pen.line(x, y, WHISKER)

    stroke([at[0], at[1]], [0, 0])
    for end, share, inwards in zip(at, shares, (1, -1), strict=True):
        if -1e-9 <= share <= 1 + 1e-9:
            stroke([end, end], [-CAP, CAP])
        else:
            stroke([end + inwards * ARROW, end, end + inwards * ARROW], [-CAP, 0, CAP])
    return [beside, at[0], beside, at[1]] if upwards else [at[0], beside, at[1], beside]


def _share(ruler: Ruler, end: float, beyond: float) -> float:
    return beyond if np.isinf(end) else float(ruler.share(end))


def draw_points(pen: Pen, box: Box, points: Points, x: Ruler, y: Ruler, beside: Sequence[tuple[Array, Array]]) -> None:
    """Points with their intervals, then their names where there is room, off the lines beside them."""
    at = np.column_stack([box.left + box.width * x.share(points.x), box.bottom + box.height * y.share(points.y)])
    corner, room = np.array([box.left, box.bottom]), np.array([box.width, box.height])
    there = np.flatnonzero(((at >= corner - 1) & (at <= corner + room + 1)).all(axis=1))  # neither NaN nor beyond
    segments = [ends for line in beside for ends in _segments(*line)]
    for k in there.tolist():
        segments.append(_draw_interval(pen, box, x, (points.xlow, points.xhigh), k, at[k, 1]))
        segments.append(_draw_interval(pen, box, y, (points.ylow, points.yhigh), k, at[k, 0], upwards=True))
    named = [k for k in there.tolist() if points.names and points.names[k]]
    if named:
        names = [mathtext(points.names[k]) for k in named]
        sizes = [extent(name, SMALL_LETTERS) for name in names]
        lines = np.array([segment for segment in segments if segment]).reshape(-1, 4)
        corners = placed(at[named], sizes, at[there], lines, box)
        for name, size, foot, point in zip(names, sizes, corners, at[named], strict=True):
            end = np.clip(point, foot, foot + (size.width, size.height))
            if np.hypot(*(end - point)) > FAR:
                pen.line(np.array([point[0], end[0]]), np.array([point[1], end[1]]), LEADER)
            pen.words(name, foot[0], foot[1] + size.descent, SMALL_LETTERS)
    pen.marks(at[there, 0], at[there, 1], LINES[points.style] | POINTS_LOOK)


def _segments(x: Array, y: Array) -> list[list[float]]:
    """The straight pieces of a line, from point to point."""
    pieces = np.column_stack([x[:-1], y[:-1], x[1:], y[1:]])
    return [piece for piece in pieces.tolist() if not np.isnan(piece).any()]
