"""Where the names of points go, so that they cover neither each other nor the points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from workbench.report.figures.labels import Extent
from workbench.report.figures.pen import Box
from workbench.study.curves import Array

Flags = np.ndarray[Any, np.dtype[np.bool_]]

GAP = 4.0  # points between a mark and its name
MARK = 3.0  # points: half of the room that a mark takes
EDGE = 1.5  # points between a name and the edge of the panel
FAR = 14.0  # points from a mark, beyond which a line leads from it to its name
TURNS = np.linspace(0, 2 * np.pi, 24, endpoint=False)
REACHES = np.array([0.0, 3.0, 7.0, 12.0, 18.0, 26.0, 36.0, 48.0, 64.0, 84.0, 108.0, 140.0, 180.0, 230.0, 290.0])


def placed(points: Array, sizes: Sequence[Extent], obstacles: Array, within: Box) -> Array:
    """The lower left corners (N, 2) of the names of points (N, 2), each as near to its point as there is room.

    The names of crowded points come first, as they have the least choice.

    Parameters
    ----------
    obstacles
        Segments (m, 4) from (x0, y0) to (x1, y1) that a name should not cross, if it can be helped.
    within
        What no name may leave.
    """
    apart = np.hypot(*(points[:, np.newaxis] - points).transpose(2, 0, 1))
    crowded = np.argsort(np.sort(apart, axis=1)[:, : min(6, len(points))].sum(axis=1), kind="stable")
    marks = np.column_stack([points - MARK, points + MARK])
    corners, taken, leaders = np.zeros((len(points), 2)), np.zeros((0, 4)), np.zeros((0, 4))
    for i in crowded:
        tried = _around(points[i], sizes[i], within)
        boxes = np.column_stack([tried, tried + (sizes[i].width, sizes[i].height)])
        ends = np.clip(points[i], boxes[:, :2], boxes[:, 2:])
        cost = np.hypot(*(ends - points[i]).T)
        cost += 1e4 * (_overlaps(boxes, taken, 1.0) + _overlaps(boxes, marks, 0.5))
        cost += 300 * _through(boxes, leaders).sum(axis=1) + 40 * _through(boxes, obstacles).sum(axis=1)
        lines = np.column_stack([np.broadcast_to(points[i], ends.shape), ends])
        cost += 200 * (_through(taken, lines).sum(axis=0) + _meetings(lines, leaders)) * (cost > FAR)
        best = int(cost.argmin())
        corners[i] = tried[best]
        taken = np.vstack([taken, boxes[best]])
        leaders = np.vstack([leaders, lines[best]])
    return corners


def _around(point: Array, size: Extent, within: Box) -> Array:
    """Lower left corners of a name around its point, nearer ones first, all of it within the panel."""
    turned = np.column_stack([np.cos(TURNS), np.sin(TURNS)])
    reach = turned * (size.width / 2 + GAP, size.height / 2 + GAP) + REACHES[:, None, None] * turned
    middle = point + reach.reshape(-1, 2)
    low = np.array([within.left, within.bottom]) + EDGE
    high = low + (within.width - size.width - 2 * EDGE, within.height - size.height - 2 * EDGE)
    return np.asarray(np.clip(middle - (size.width / 2, size.height / 2), low, np.maximum(low, high)))


def _overlaps(boxes: Array, others: Array, gap: float) -> Array:
    """How many of the other boxes each box comes nearer than a gap."""
    one, two = boxes[:, np.newaxis], others[np.newaxis]
    apart = (one[..., :2] >= two[..., 2:] + gap) | (two[..., :2] >= one[..., 2:] + gap)
    return np.asarray((~apart.any(axis=2)).sum(axis=1), dtype=np.float64)


def _through(boxes: Array, lines: Array) -> Flags:
    """Whether a segment comes nearer a box than a point, (boxes, segments), as seen at 25 places of each segment."""
    share = np.linspace(0, 1, 25)[:, np.newaxis]
    at = lines[:, np.newaxis, :2] * (1 - share) + lines[:, np.newaxis, 2:] * share
    inside: Flags = (at > boxes[:, None, None, :2] - 1) & (at < boxes[:, None, None, 2:] + 1)
    return np.asarray(np.any(np.all(inside, axis=3), axis=2))


def _meetings(lines: Array, others: Array) -> Array:
    """How many of the other segments each segment crosses."""
    a, b = lines[:, np.newaxis, :2], lines[:, np.newaxis, 2:]
    c, d = others[np.newaxis, :, :2], others[np.newaxis, :, 2:]

    def side(p: Array, q: Array, r: Array) -> Array:
        return np.asarray(np.sign((q - p)[..., 0] * (r - p)[..., 1] - (q - p)[..., 1] * (r - p)[..., 0]))

    crossing = (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)
    return np.asarray(crossing.sum(axis=1), dtype=np.float64)
