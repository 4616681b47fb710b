"""Regions, arrows and the named lines of a grid, drawn by the pen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.report.figures.pen import Pen, Rectangle, extent, mathtext
from workbench.report.figures.rulers import Ruler
from workbench.report.figures.style import LINES, LineStyle
from workbench.study.document.figure import Area, Arrows, Guides

FILL = 0.2  # of the colour of a region
HEAD, HALF = 6.5, 2.4  # points: the length and half of the width of an arrow's head
SMALL_HEAD = 0.55  # of that: the head of an arrow with a shaft
LINE: LineStyle = {"color": "#b9b9b9", "linewidth": 0.5}
INK, SIZE = "#666666", 6.5  # of the names of a grid, in points
CORNERS = 3.0 * np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 0.0]])  # of a point, in points
HALO = 0.8  # points of white around a name
TRIES = np.concatenate([np.arange(0.0, 0.6, 0.03), np.arange(0.6, 0.95, 0.05)])  # of a line, from its end backwards


def draw_area(pen: Pen, box: Rectangle, area: Area, x: Ruler, y: Ruler) -> None:
    """A region in a light tone, and its edge."""
    across, up = box.at(x.share(area.x), y.share(area.y))
    look = LINES[area.style]
    pen.area(across, up, look["color"], FILL, box)
    pen.line(np.append(across, across[0]), np.append(up, up[0]), look | {"linestyle": "-", "linewidth": 0.6}, box)


def draw_arrows(pen: Pen, box: Rectangle, arrows: Arrows, x: Ruler, y: Ruler) -> None:
    """Each arrow as a piece: its shaft, if it has one, and its head."""
    across, up = box.at(x.share(arrows.x), y.share(arrows.y))
    u, v = box.width * x.slope(arrows.x, arrows.u), box.height * y.slope(arrows.y, arrows.v)
    size = np.hypot(u, v)
    inside = (
        (across >= box.left) & (across <= box.left + box.width) & (up >= box.bottom) & (up <= box.bottom + box.height)
    )
    color = LINES[arrows.style]["color"]
    for k in np.flatnonzero(inside & (size > 0)).tolist():
        along = np.array([u[k], v[k]]) / size[k]
        with pen.piece("mark", k):
            _arrow(pen, box, np.array([across[k], up[k]]), along, arrows.length, color)


def _arrow(pen: Pen, box: Rectangle, start: Array, along: Array, length: float, color: str) -> None:
    scale = SMALL_HEAD if length else 1.0
    tip = start + along * (length or HEAD / 2)
    aside, base = np.array([-along[1], along[0]]) * HALF * scale, tip - along * HEAD * scale
    if length:
        shaft = np.array([start, base])
        pen.line(shaft[:, 0], shaft[:, 1], {"color": color, "linewidth": 0.6}, box)
    head = np.array([tip, base + aside, base - aside])
    pen.area(head[:, 0], head[:, 1], color, within=box)


def draw_guides(
    pen: Pen,
    box: Rectangle,
    place: tuple[int, int],
    guides: Guides,
    x: Ruler,
    y: Ruler,
    beside: Sequence[tuple[Array, Array]],
    points: Sequence[tuple[Array, Array]],
) -> None:
    """The lines, and each name on its line near its end, off other names and, if it can be, off curves and points."""
    lines = [box.at(x.share(line[0]), y.share(line[1])) for line in guides.lines]
    with pen.group("series", *place):
        for line in lines:
            pen.line(*line, LINE, box)
    curves = _obstacles(beside, points)
    held: list[Array] = []
    with pen.group("guides", *place):
        for line, name in zip(lines, guides.names, strict=False):
            words = mathtext(name)
            if words and (found := _room(box, line, words, held, curves)) is not None:
                held.append(found)
                foot = found[:2] + HALO
                pen.area(*Rectangle(*found[:2], *(found[2:] - found[:2])).corners, "#ffffff")
                pen.words(words, foot[0], foot[1] + extent(words, SIZE).descent / 2, SIZE, color=INK)


def _obstacles(beside: Sequence[tuple[Array, Array]], points: Sequence[tuple[Array, Array]]) -> Array:
    """Places (N, 2) that names should not cover: those along curves, and around points."""
    held = [np.column_stack(_dense(line)) for line in beside]
    held += [np.column_stack(mark) + shift for mark in points for shift in CORNERS]
    return np.concatenate(held) if held else np.zeros((0, 2))


def guide_points(box: Rectangle, line: tuple[Array, Array]) -> Array:
    """The points of a line inside a box, one a point of its length, from its end backwards: (N, 2)."""
    points = np.column_stack(_dense(line))
    low = np.array([box.left, box.bottom])
    inside = ((points >= low) & (points <= low + (box.width, box.height))).all(axis=1)
    return np.asarray(points[inside][::-1])


def _dense(line: tuple[Array, Array]) -> tuple[Array, Array]:
    """A line with about a point for each 2 points of its length; without its gaps."""
    x, y = np.asarray(line[0], dtype=float), np.asarray(line[1], dtype=float)
    steps = np.hypot(np.diff(x), np.diff(y))
    counts = np.clip(np.nan_to_num(steps, nan=0.0) / 2, 1, 400).astype(int)
    starts = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(starts)) - np.repeat(np.cumsum(counts) - counts, counts)) / np.repeat(counts, counts)
    across = x[starts] + share * (x[starts + 1] - x[starts])
    up = y[starts] + share * (y[starts + 1] - y[starts])
    across, up = np.append(across, x[-1:]), np.append(up, y[-1:])
    kept = np.isfinite(across + up)
    return across[kept], up[kept]


def _room(box: Rectangle, line: tuple[Array, Array], words: str, held: list[Array], curves: Array) -> Array | None:
    """The rectangle [left, bottom, right, top] of a name on its line; None if all places are taken."""
    points = guide_points(box, line)
    if not len(points):
        return None
    size = extent(words, SIZE)
    wide, high = size.width + 2 * HALO, size.ascent + size.descent / 2 + 2 * HALO
    low = np.array([box.left, box.bottom]) + 1
    top = low + (box.width - 2 - wide, box.height - 2 - high)
    first = None
    for share in TRIES:
        middle = points[min(int(share * len(points)), len(points) - 1)]
        corner = np.clip(middle - (wide / 2, high / 2), low, np.maximum(low, top))
        found = np.concatenate([corner, corner + (wide, high)])
        if any((found[:2] < other[2:] + 1).all() and (other[:2] < found[2:] + 1).all() for other in held):
            continue
        first = found if first is None else first
        if not ((curves > found[:2] - 1) & (curves < found[2:] + 1)).all(axis=1).any():
            return found
    return first
