"""Points with their intervals and names, which are put so that they cover neither each other nor the points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array
from workbench.report.figures.boxes import draw_interval
from workbench.report.figures.pen import Extent, Pen, Rectangle, extent, mathtext
from workbench.report.figures.rulers import Ruler
from workbench.report.figures.style import LINES, POINTS_LOOK, SHAPES, SMALL_LETTERS, LineStyle
from workbench.study.document.figure import Points

Flags = NDArray[np.bool_]

GAP = 4.0  # points between a mark and its name
MARK = 3.0  # points: half of the room that a mark takes
ROUNDS = 2  # of placing all names
APART = 2.5  # points between two names
EDGE = 1.5  # points between a name and the edge of the panel
LEADER: LineStyle = {"color": "#999999", "linewidth": 0.4}
FAR = 10.0  # points from a mark, beyond which a line leads from it to its name
TURNS = np.linspace(0, 2 * np.pi, 16, endpoint=False)
REACHES = np.array([0.0, 3.0, 7.0, 12.0, 18.0, 26.0, 36.0, 48.0, 64.0, 84.0, 108.0, 140.0, 180.0, 230.0, 290.0])


def draw_points(
    pen: Pen, box: Rectangle, points: Points, x: Ruler, y: Ruler, beside: Sequence[tuple[Array, Array]]
) -> None:
    """Points with their intervals, then their names where there is room, off the lines beside them."""
    at = np.column_stack(box.at(x.share(points.x), y.share(points.y)))
    corner, room = np.array([box.left, box.bottom]), np.array([box.width, box.height])
    there = np.flatnonzero(((at >= corner - 1) & (at <= corner + room + 1)).all(axis=1))  # neither NaN nor beyond
    segments = [ends for line in beside for ends in _segments(*line)]
    for k in there.tolist():
        with pen.piece("mark", k):
            segments.append(draw_interval(pen, box, x, (points.xlow, points.xhigh), k, at[k, 1]))
            segments.append(draw_interval(pen, box, y, (points.ylow, points.yhigh), k, at[k, 0], upwards=True))
    named = [k for k in there.tolist() if points.names and points.names[k]]
    if named:
        names = [mathtext(points.names[k]) for k in named]
        sizes = [extent(name, SMALL_LETTERS) for name in names]
        lines = np.array([segment for segment in segments if segment]).reshape(-1, 4)
        corners = place_names(at[named], sizes, at[there], lines, box)
        for k, name, size, foot in zip(named, names, sizes, corners, strict=True):
            end = np.clip(at[k], foot, foot + (size.width, size.height))
            with pen.piece("words", k):
                if np.hypot(*(end - at[k])) > FAR:
                    pen.line(np.array([at[k, 0], end[0]]), np.array([at[k, 1], end[1]]), LEADER)
                pen.words(name, foot[0], foot[1] + size.descent, SMALL_LETTERS)
    for k in there.tolist():
        with pen.piece("mark", k):
            pen.marks(at[k : k + 1, 0], at[k : k + 1, 1], LINES[points.style] | POINTS_LOOK | SHAPES[points.shape])


def _segments(x: Array, y: Array) -> list[list[float]]:
    """The straight pieces of a line, from point to point."""
    pieces = np.column_stack([x[:-1], y[:-1], x[1:], y[1:]])
    return [piece for piece in pieces.tolist() if not np.isnan(piece).any()]


def place_names(points: Array, sizes: Sequence[Extent], marks: Array, obstacles: Array, within: Rectangle) -> Array:
    """The lower left corners (N, 2) of the names of points (N, 2), each as near to its point as there is room `within`.

    The names of crowded points come first, as they have the least choice; then each is placed again beside all others,
    off all `marks` (M, 2) and, if it can be helped, off the `obstacles` (m, 4), segments from (x0, y0) to (x1, y1).
    """
    apart = np.hypot(*(points[:, np.newaxis] - points).transpose(2, 0, 1))
    crowded = np.argsort(np.sort(apart, axis=1)[:, : min(6, len(points))].sum(axis=1), kind="stable").tolist()
    dots = np.column_stack([marks - MARK, marks + MARK])
    boxes, leaders = np.full((len(points), 4), np.nan), np.full((len(points), 4), np.nan)
    for i in crowded * ROUNDS:
        tried = _around(points[i], sizes[i], within)
        others = [k for k in crowded if k != i and not np.isnan(boxes[k, 0])]
        found = np.column_stack([tried, tried + (sizes[i].width, sizes[i].height)])
        ends = np.clip(points[i], found[:, :2], found[:, 2:])
        lines = np.column_stack([np.broadcast_to(points[i], ends.shape), ends])
        length = np.hypot(*(ends - points[i]).T)
        cost = length + 1e4 * (_overlaps(found, boxes[others], APART) + _overlaps(found, dots, 0.5))
        cost += 300 * _through(found, leaders[others]).sum(axis=1) + 40 * _through(found, obstacles).sum(axis=1)
        cost += 60 * (_nearest(found, marks[np.any(marks != points[i], axis=1)]) < length)
        met = _through(boxes[others], lines).sum(axis=0) + _meetings(lines, leaders[others])
        best = int((cost + 200 * met * (length > FAR)).argmin())
        boxes[i], leaders[i] = found[best], lines[best]
    return boxes[:, :2]


def _around(point: Array, size: Extent, within: Rectangle) -> Array:
    """Lower left corners of a name around its point, nearer ones first, all of it within the panel."""
    turned = np.column_stack([np.cos(TURNS), np.sin(TURNS)])
    reach = turned * (size.width / 2 + GAP, size.height / 2 + GAP) + REACHES[:, None, None] * turned
    middle = point + reach.reshape(-1, 2)
    low = np.array([within.left, within.bottom]) + EDGE
    high = low + (within.width - size.width - 2 * EDGE, within.height - size.height - 2 * EDGE)
    return np.asarray(np.clip(middle - (size.width / 2, size.height / 2), low, np.maximum(low, high)))


def _nearest(boxes: Array, marks: Array) -> Array:
    """The distance of each box to the next of the marks: a name should stand nearest to its own."""
    off = np.clip(marks, boxes[:, np.newaxis, :2], boxes[:, np.newaxis, 2:]) - marks
    return np.asarray(np.hypot(off[..., 0], off[..., 1]).min(axis=1, initial=np.inf))


def _overlaps(boxes: Array, others: Array, gap: float) -> Array:
    """The number of other boxes that each box comes nearer than a gap."""
    one, two = boxes[:, np.newaxis], others[np.newaxis]
    apart = (one[..., :2] >= two[..., 2:] + gap) | (two[..., :2] >= one[..., 2:] + gap)
    return np.asarray((~apart.any(axis=2)).sum(axis=1), dtype=np.float64)


def _through(boxes: Array, lines: Array) -> Flags:
    """True where a segment comes nearer to a box than a point does, (boxes, segments)."""
    low, high = boxes[:, np.newaxis, :2] - 1, boxes[:, np.newaxis, 2:] + 1
    start, end = lines[np.newaxis, :, :2], lines[np.newaxis, :, 2:]
    beside = (np.maximum(start, end) > low) & (np.minimum(start, end) < high)
    normal = (end - start)[..., ::-1] * (1, -1)
    offset = np.sum(normal * ((low + high) / 2 - start), axis=2)
    reach = np.sum(np.abs(normal) * (high - low) / 2, axis=2)
    return np.asarray(np.all(beside, axis=2) & (np.abs(offset) <= reach))


def _meetings(lines: Array, others: Array) -> Array:
    """The number of other segments that each segment crosses."""
    a, b = lines[:, np.newaxis, :2], lines[:, np.newaxis, 2:]
    c, d = others[np.newaxis, :, :2], others[np.newaxis, :, 2:]

    def side(p: Array, q: Array, r: Array) -> Array:
        return np.asarray(np.sign((q - p)[..., 0] * (r - p)[..., 1] - (q - p)[..., 1] * (r - p)[..., 0]))

    crossing = (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)
    return np.asarray(crossing.sum(axis=1), dtype=np.float64)
