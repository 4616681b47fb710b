"""The plane of the gains (k, ki): discs that a specification forbids, and intervals of ki that stabilise.

At a frequency the law k - i ki/omega + d, with d the derivative action, meets 1/|S| = |law + 1/G| |G|. So S forbids a
disc about -1/G - d, T another one, and both hold the centre -1/G - d, on which the closed loop has poles on the axis.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex
from workbench.design.pid_design.process import Process

BELOW = 1e-11  # a small positive ki moves 1/G + k downwards: by this share of it, so that a real 1/G is decided, too
ABOVE = 1.01  # a search starts this far above a stable interval, in what the discs forbid

Interval = tuple[float, float]


@dataclass(frozen=True, eq=False)
class GainPlane:
    """The inverse process g = 1/G and the derivative action d at some frequencies, and the peaks that are allowed."""

    process: Process
    omega: Array
    g: Complex
    d: Complex
    Ms: float
    Mt: float

    def forbidden(self, k: Array) -> tuple[Array, Array]:
        """The ends of the intervals of ki that each frequency forbids, (nk, nw) or (nk, 2 nw); (inf, -inf) for none."""
        K, parts = k[:, np.newaxis] + self.d.real, []
        if np.isfinite(self.Ms):
            parts.append(self._forbidden_by(K, self.g.imag, np.abs(self.g) ** 2 / self.Ms**2 - (K + self.g.real) ** 2))
        if np.isfinite(self.Mt):
            parts.append(self._forbidden_by_T(K))
        parts += [self._too_small(k, *pole) for pole in self.process.axis_poles]
        low, high = (np.concatenate(ends, axis=1) for ends in zip(*parts, strict=True))
        return low, high

    def _too_small(self, k: Array, omega: float, least: float) -> tuple[Array, Array]:
        """The gains that are too small at an undamped pole for its frequencies to show what they do."""
        at = np.array([omega])
        d = np.interp(at, self.omega, self.d.real) + 1j * np.interp(at, self.omega, self.d.imag)
        square = least**2 - (k[:, np.newaxis] + d.real) ** 2
        half = np.sqrt(np.maximum(square, 0))
        return (
            np.where(square > 0, omega * (d.imag - half), np.inf),
            np.where(square > 0, omega * (d.imag + half), -np.inf),
        )

    def _forbidden_by(self, K: Array, middle: Array, square: Array) -> tuple[Array, Array]:
        inside = square > 0
        half, centre = np.sqrt(np.where(inside, square, 0)), middle + self.d.imag
        return (
            np.where(inside, self.omega * (centre - half), np.inf),
            np.where(inside, self.omega * (centre + half), -np.inf),
        )

    def _forbidden_by_T(self, K: Array) -> tuple[Array, Array]:
        """Where |law| > Mt |law + g|: a quadratic in the integral action, whose small root is taken without loss."""
        square, b = self.Mt**2, self.g.imag
        lead = square - 1
        rest = square * ((K + self.g.real) ** 2 + b**2) - K**2
        turn = (square * b) ** 2 - lead * rest
        root = np.sqrt(np.maximum(turn, 0))
        with np.errstate(divide="ignore", invalid="ignore"):
            sum_ = square * b + np.copysign(root, b)
            first, second = rest / sum_, sum_ / lead if lead > 0 else np.copysign(np.inf, sum_)
        low, high = np.minimum(first, second), np.maximum(first, second)
        none = (turn <= 0) | ((lead == 0) & (b == 0))
        low, high = (np.where(none, end, self.omega * (x + self.d.imag)) for end, x in ((np.inf, low), (-np.inf, high)))
        return low, high

    def stable_intervals(self, k: Array) -> list[list[Interval]]:
        """The intervals of ki > 0 that stabilise, for each k, from the highest to the lowest."""
        centre = self._lowered
        above = k[:, np.newaxis] + centre.real > 0
        rows, places = np.nonzero(above[:, 1:] != above[:, :-1])
        first, last = centre[places], centre[places + 1]
        share = (-k[rows] - first.real) / (last.real - first.real)
        omega = self.omega[places] + share * (self.omega[places + 1] - self.omega[places])
        values = omega * (first.imag + share * (last.imag - first.imag))
        changes = np.where(above[rows, places + 1], -2, 2)  # Re g grows: a pair of poles goes to the left with ki
        order = np.lexsort((values, rows))
        order = order[values[order] > 0]
        crossings = list(zip(values[order].tolist(), changes[order].tolist(), strict=True))
        bounds = np.searchsorted(rows[order], np.arange(len(k) + 1)).tolist()
        return [
            _zero_intervals(count, crossings[bounds[i] : bounds[i + 1]], self.top)
            for i, count in enumerate(self._unstable_poles(k).tolist())
        ]

    def _unstable_poles(self, k: Array) -> Array:
        """The unstable poles of the closed loop for a small positive ki, by the argument of num (1/G + k + d)."""
        p, column = self.process, k[:, np.newaxis]
        turn = _turns(column + self._lowered, axis=1) + self._own_turns
        for i in self._leaps:  # 1/G goes through infinity, and its numerator not
            pair = slice(i, i + 2)
            turn[:, i] = _turns(self._den[pair] + (column + self.d[pair]) * self._num[pair], axis=1)[:, 0]
        at_rest = p.den[-1] + k * p.num[-1]
        first = np.angle((k + self._lowered[0]) * self._num[0] * np.where(at_rest < 0, -1, 1))
        last = np.angle((1 + (k + self.d[-1]) * self._end) / (1 + (k + self.d[-1]) / self.g[-1])) + self._den_turn_left
        count = np.round((len(p.den) - 1 - (turn.sum(axis=1) + first + last) / (np.pi / 2)) / 2)
        return np.asarray(np.maximum(count, 0) + (p.num[-1] * at_rest <= 0))

    @cached_property
    def top(self) -> float:
        """A ki that is beyond what these frequencies can judge."""
        return float((self.omega * np.abs(self.g + self.d)).max())

    @cached_property
    def _lowered(self) -> Complex:
        return np.asarray(self.g + self.d - 1j * BELOW * np.abs(self.g))

    @cached_property
    def _end(self) -> float:
        """The process at infinity, 0 with a delay, as its loop gain there is less than one."""
        return 0.0 if self.process.delay else self.process.gain_limit

    @cached_property
    def _den(self) -> Complex:
        return np.asarray(np.polyval(self.process.den, 1j * self.omega))

    @cached_property
    def _num(self) -> Complex:
        s = 1j * self.omega
        return np.asarray(np.polyval(self.process.num, s) * np.exp(-s * self.process.delay))

    @cached_property
    def _den_turn_left(self) -> float:
        """The turn of the denominator beyond the last frequency."""
        poles = self.process.roots[1]
        turns = np.pi / 2 - np.arctan2(self.omega[-1] - poles.imag, np.abs(poles.real))
        return float((turns * np.where(poles.real > 0, -1, 1)).sum())

    @cached_property
    def _own_turns(self) -> Array:
        return _turns(self._num)

    @cached_property
    def _leaps(self) -> list[int]:
        size = np.abs(self._num)
        found: list[int] = np.nonzero(np.abs(np.diff(self._num)) > np.maximum(size[1:], size[:-1]))[0].tolist()
        return found

    def slack(self, k: float, ki: float) -> Array:
        """1/|S| - 1/Ms and 1/|T| - 1/Mt at the frequencies, (2, nw); infinite where nothing is asked."""
        law = k - 1j * ki / self.omega + self.d
        distance = np.abs(law + self.g)
        rows = [distance / np.abs(self.g) - 1 / self.Ms, distance / np.abs(law) - 1 / self.Mt]
        return np.array(
            [
                row if np.isfinite(M) else np.full(len(law), np.inf)
                for row, M in zip(rows, (self.Ms, self.Mt), strict=True)
            ]
        )


def _turns(values: Complex, axis: int = 0) -> Array:
    """The change of the argument from each value to the next, along a straight line."""
    turn = np.diff(np.angle(values), axis=axis)
    return np.asarray(turn - 2 * np.pi * np.round(turn / (2 * np.pi)))


def _zero_intervals(count: float, crossings: list[tuple[float, int]], top: float) -> list[Interval]:
    """The intervals in which a count of poles that changes at crossings is zero, the highest first."""
    found, low = [], 0.0
    for value, change in [*crossings, (top, 0)]:
        if count == 0 and value > low:
            found.append((low, value))
        count, low = count + change, value
    return found[::-1]


def free_tops(low: Array, high: Array, start: Array, floor: Array) -> Array:
    """The highest number at or below each `start` that no interval (low, high] of its row holds; -inf below `floor`."""
    top, rows = start.copy(), np.arange(len(start))
    while rows.size:
        t = top[rows, np.newaxis]
        covering = (low[rows] < t) & (t <= high[rows])
        below = np.where(covering, low[rows], np.inf).min(axis=1)
        moved = np.isfinite(below) | (below == -np.inf)
        top[rows[moved]] = below[moved]
        rows = rows[moved & (below > floor[rows])]
    return np.where(top > floor, top, -np.inf)
