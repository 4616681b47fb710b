"""The search for the largest integral gain: intervals of k, each with a bound from above, the best halved first.

A ki that one frequency forbids at both ends of an interval of k is forbidden all over the interval, as each forbidden
set is convex in (k, ki). So the highest ki that no frequency forbids at both ends bounds the interval from above.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array, Integers
from workbench.design.pid_design.gain_plane import ABOVE, GainPlane, Interval, free_tops

WIDE = 0.08  # the width of an interval of k, over the size of k, at which a bound that is nearly reached is enough
NEAR = 0.01  # how nearly, over the bound
NARROW = 1e-3  # the width at which the search ends in any case
KEPT = 0.99  # of the best ki: what a bound must reach for an interval to stay, as frequencies between add constraints
ROUNDS = 40
MOST = 400  # intervals at a time


@dataclass(frozen=True, eq=False)
class _Columns:
    """The forbidden intervals, the stable intervals and the highest free ki of some k."""

    k: Array
    low: Array
    high: Array
    stable: list[list[Interval]]
    top: Array

    @staticmethod
    def of(plane: GainPlane, k: Array) -> _Columns:
        low, high = plane.forbidden(k)
        stable = plane.stable_intervals(k)
        return _Columns(k, low, high, stable, _tops(plane, low, high, stable, stable, 1.0))

    def part(self, places: Integers) -> _Columns:
        return _Columns(
            self.k[places], self.low[places], self.high[places], [self.stable[i] for i in places], self.top[places]
        )

    def join(self, other: _Columns) -> _Columns:
        return _Columns(
            np.concatenate([self.k, other.k]),
            np.concatenate([self.low, other.low]),
            np.concatenate([self.high, other.high]),
            self.stable + other.stable,
            np.concatenate([self.top, other.top]),
        )


def _tops(
    plane: GainPlane,
    low: Array,
    high: Array,
    left: list[list[Interval]],
    right: list[list[Interval]],
    above: float = ABOVE,
) -> Array:
    """The highest ki that stabilises and that no interval of its row holds; -inf where nothing bounds it."""
    best = np.full(len(low), -np.inf)
    rows, starts, floors = [], [], []
    for i, (one, other) in enumerate(zip(left, right, strict=True)):
        for j in range(max(len(one), len(other))):
            pair = [part[j] for part in (one, other) if j < len(part)]
            rows.append(i)
            starts.append(above * max(top for _, top in pair))
            floors.append(min(bottom for bottom, _ in pair))
    if rows:
        tops = free_tops(low[rows], high[rows], np.array(starts), np.array(floors))
        np.maximum.at(best, rows, np.where(tops < 0.999 * plane.top, tops, -np.inf))
    return best


def highest_gains(plane: GainPlane, k: Array) -> tuple[Array, list[list[Interval]]]:
    """For each k the highest ki that stabilises within the limits, -inf for none, and the intervals that stabilise."""
    columns = _Columns.of(plane, k)
    return columns.top, columns.stable


def nodes(plane: GainPlane) -> Array:
    """Values of k, so dense that each k that meets the specification has a neighbour that stabilises."""
    margin = min(max(1.0 / M for M in (plane.Ms, plane.Mt) if np.isfinite(M)), 1.0)
    ratio = 1 + min(0.35 * margin, 0.3)
    size = np.abs(plane.g[1:])  # without the frequency that stands for zero
    least, most = float(size.min()), float(size.max())
    step = 0.5 * margin * least
    logs = np.arange(np.log(step / (ratio - 1)), np.log(2 * most), np.log(ratio))
    upper = np.exp(logs)
    inner = np.arange(0, upper[0], step)
    return np.concatenate([-upper[::-1], -inner[:0:-1], inner, upper])


def search(plane: GainPlane, k: Array, least: float = 0.0) -> list[tuple[float, float, float]]:
    """Places near which ki may be largest, as k, ki and a width in k, the best first, by the frequencies alone.

    Places whose ki is below `least` are left out.
    """
    columns = _Columns.of(plane, k)
    best = max(float(columns.top.max(initial=-np.inf)), least)
    left, right = columns.part(np.arange(len(k) - 1)), columns.part(np.arange(1, len(k)))
    done: list[tuple[float, float, float, float]] = []
    for _ in range(ROUNDS):
        low, high = np.maximum(left.low, right.low), np.minimum(left.high, right.high)
        bound = _tops(plane, low, high, left.stable, right.stable)
        width = (right.k - left.k) / np.maximum(np.abs(left.k), np.abs(right.k))
        reached = np.maximum(left.top, right.top)
        settled = (width <= NARROW) | ((width <= WIDE) & (reached >= (1 - NEAR) * bound))
        stay = bound >= KEPT * best if best > 0 else bound > 0
        ready = np.nonzero(stay & settled)[0]
        at = np.where(left.top >= right.top, left.k, right.k)[ready]
        done += zip(*(x.tolist() for x in (left.k[ready], right.k[ready], at, bound[ready])), strict=True)
        places = np.nonzero(stay & ~settled)[0]
        if not places.size:
            break
        places = np.sort(places[np.argsort(-bound[places])[:MOST]])
        middle = _Columns.of(plane, (left.k[places] + right.k[places]) / 2)
        best = max(best, float(middle.top.max()))
        left, right = left.part(places).join(middle), middle.join(right.part(places))
    return _groups([row for row in done if row[3] >= KEPT * best]) if best > 0 else []


def _groups(rows: list[tuple[float, float, float, float]]) -> list[tuple[float, float, float]]:
    """Neighbouring intervals as one: where its bound is largest, that bound, and its width."""
    groups: list[list[tuple[float, float, float, float]]] = []
    for row in sorted(rows):
        if groups and row[0] <= groups[-1][-1][1]:
            groups[-1].append(row)
        else:
            groups.append([row])
    found = []
    for group in groups:
        peak = max(group, key=lambda row: row[3])
        found.append((peak[2], peak[3], group[-1][1] - group[0][0]))
    return sorted(found, key=lambda row: -row[1])
