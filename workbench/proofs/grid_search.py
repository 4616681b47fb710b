"""The least value of a function over a box, sought on a grid that is refined around its best point."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from workbench.validation.refusals import Array

# Grid points in all, and how often the grid is halved round its best point: 2^-40 of a cell is 1e-13 rad.
GRID, HALVINGS = 20_000, 40
# Beyond so many dimensions a grid has too many corners; then points of an even sequence take its place.
DIMENSIONS = 5


class Seen(NamedTuple):
    """The least value that was seen, where, and in how many samples."""

    value: float
    x: Array
    samples: int


def least_seen(function: Callable[[Array], Array], low: Array, high: Array) -> Seen:
    """The least of function (points (N, m) to values (N,)) over low <= x <= high, (m,) each.

    The middle is among the points, and up to five dimensions the corners and the quarters of the box too.
    """
    m = len(low)
    best, half = (low + high) / 2, (high - low) / 2
    value, samples = np.inf, 0
    for steps in _steps(m):
        x = np.clip(best + steps * half, low, high)
        values = function(x)
        samples += len(x)
        if values.min() < value:
            value, best = float(values.min()), x[values.argmin()]
    return Seen(value, best, samples)


def _steps(m: int) -> Iterator[Array]:
    if m == 0:
        yield np.zeros((1, 0))
        return
    points = max(int(GRID ** (1 / m)) // 4, 1) * 4 + 1
    if m <= DIMENSIONS:
        yield _lattice(np.linspace(-1, 1, points), m)
        near = _lattice(np.linspace(-2, 2, 5), m)
    else:
        yield np.vstack([np.zeros(m), 2 * sequence(GRID, m) - 1])
        near = np.vstack([np.zeros(m), 4 * sequence(GRID // 8, m) - 2])
    for level in range(HALVINGS):
        yield near / (points - 1) / 2.0**level


def _lattice(side: Array, m: int) -> Array:
    return np.stack(np.meshgrid(*[side] * m, indexing="ij"), axis=-1).reshape(-1, m)


def sequence(count: int, dimensions: int) -> Array:
    """Points (count, dimensions) spread evenly over the unit cube (the R sequence of M. Roberts, 2018)."""
    if dimensions == 0:
        return np.zeros((count, 0))
    root = 2.0
    for _ in range(60):  # a contraction: the positive root of root^(d+1) = root + 1 to the last digit
        root = (1 + root) ** (1 / (dimensions + 1))
    steps = root ** -np.arange(1.0, dimensions + 1)
    return np.asarray((0.5 + np.outer(np.arange(1, count + 1), steps)) % 1.0)
