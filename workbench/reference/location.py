"""Event location: the instant within a step at which a guard of the piece ends it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from workbench.reference.pieces import SAMPLES, Piece
from workbench.validation.refusals import Array

Flags = np.ndarray[Any, np.dtype[np.bool_]]
SHORTEST = 16 * float(np.finfo(float).eps)  # a step of this share of the horizon is an instant


class Found(NamedTuple):
    """The guard that is first to end a step, and when, to the accuracy of the step's interpolant."""

    t: float
    place: int


class Look(NamedTuple):
    """What a step has met: a guard, or none; or it is to be taken `again`, shorter. And which guards are armed now.

    A guard that is within rounding of its end has just been passed, and is armed once it is clear of it.
    """

    found: Found | None
    again: bool
    armed: Flags


def armed_at(piece: Piece | None, t: float, x: Array) -> Flags:
    """Which guards are clear of their ends."""
    if piece is None or not piece.guards:
        return np.zeros(0, dtype=bool)
    g = piece.watch(t, x)
    return np.asarray(g[:, 0] > _finite(g[:, 1]))


def look(piece: Piece, begin: float, end: float, between: Callable[[Any], Array], armed: Flags, horizon: float) -> Look:
    """What the step from `begin` to `end` has met, its states given by `between`, (nx, k) at k instants."""
    at = np.linspace(begin, end, SAMPLES + 1)
    states = between(at)
    rows = piece.samples(at[1:], states[:, 1:]).reshape(len(armed), SAMPLES, 4)
    rows = np.concatenate([piece.watch(begin, states[:, 0])[:, np.newaxis], rows], axis=1)
    found, after = [], armed.copy()
    for j in range(len(armed)):
        g, noise, slope = rows[j, :, 0], _finite(rows[j, :, 1]), rows[j, :, 2]
        first = 1
        while not after[j] and first <= SAMPLES:
            if g[first] < -noise[first]:  # it left its end and came back within the step, or went the wrong way
                if end - begin > SHORTEST * horizon:
                    return Look(None, True, armed)
                return Look(Found(begin, j), False, armed)
            after[j] = g[first] > noise[first]
            first += 1
        if after[j] and (t := _crossing(piece, j, at, g, slope, noise, first, between)) is not None:
            found.append(Found(t, j))
    return Look(min(found, default=None), False, after)


def _crossing(
    piece: Piece,
    j: int,
    at: Array,
    g: Array,
    slope: Array,
    noise: Array,
    first: int,
    between: Callable[[Any], Array],
) -> float | None:
    """The first zero of a guard behind sample `first` - 1, also one of two that lie between two samples."""

    def value(t: float, column: int = 0) -> float:
        return float(piece.watch(t, between(t))[j, column])

    for i in range(first, len(at)):
        low, last = g[i], at[i]
        dips = slope[i - 1] < 0 < slope[i] and value(at[i - 1], 2) < 0 < value(at[i], 2)  # one by one as side by side
        if g[i - 1] > 0 and g[i] > 0 and dips:
            last = brentq(value, at[i - 1], at[i], args=(2,))  # the lowest point of a dip
            low = value(last)
            if low >= -noise[i]:
                continue
        if low <= 0:
            inside = value(at[i - 1]) > 0 > value(last)
            return float(brentq(value, at[i - 1], last, xtol=1e-300)) if inside else float(at[i - 1])
    return None


def polished(piece: Piece, t: float, x: Array, index: int) -> tuple[float, Array]:
    """The instant and state moved onto the end of a guard, to rounding: Newton in time, each move one step of RK4."""
    reach = np.inf
    for _ in range(10):
        g, noise, slope, _ = piece.watch(t, x)[index]
        if abs(g) <= noise / 8 or slope == 0 or not np.isfinite(slope):
            break
        h = float(-g / slope)
        if not abs(h) < reach or t + h == t:
            break
        reach = abs(h)
        t, x = t + h, _rk4(piece, t, x, h)
    return t, x


def _rk4(piece: Piece, t: float, x: Array, h: float) -> Array:
    y = piece.with_companions(t, x)

    def f(t: float, y: Array) -> Array:
        return piece.field(t, y).ravel()

    a = f(t, y)
    b = f(t + h / 2, y + h / 2 * a)
    c = f(t + h / 2, y + h / 2 * b)
    d = f(t + h, y + h * c)
    return np.asarray((y + h / 6 * (a + 2 * b + 2 * c + d))[: len(x)])


def _finite(noise: Array) -> Array:
    return np.where(np.isfinite(noise), noise, 0.0)
