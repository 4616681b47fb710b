"""Modality: whether a sample is from a law of one mode, by a gap in it or by Hartigan's dip."""

from __future__ import annotations

import operator
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from workbench.study.uncertainty.designs import uniforms
from workbench.validation.words import Array, Integers

RESAMPLES = 2000
BESIDE = 10  # draws on each side of a gap that are held against it


def gap(values: Array) -> tuple[float, float]:
    """The probability that one mode has so wide a gap within the sample, at most, and the least value beyond it.

        P = N max ((s / (g + s))^9)    over the ten draws below the gap g and those above, which span s

    Away from its mode a density falls, so that a gap is no wider, in law, than the nine spacings that come after it:
    at most g / (g + s) has the law of that of ten equal ones. On one of its sides every gap has no mode; the factor N
    is for all gaps (Bonferroni).
    """
    x = np.sort(values)
    wide = np.diff(x)
    spans = x[BESIDE - 1 :] - x[: 1 - BESIDE]
    here, below, above = wide[BESIDE - 1 : 1 - BESIDE], spans[:-BESIDE], spans[BESIDE:]
    span = np.maximum(below, above)
    chances = np.where(here > 0, (span / np.where(here > 0, here + span, 1)) ** (BESIDE - 1), 1.0)
    at = int(np.argmin(chances))
    return min(1.0, len(x) * float(chances[at])), float(x[BESIDE + at])


def dip(values: Array) -> float:
    """The least distance of the sample's distribution to one that is convex up to a mode and concave beyond it.

        dip = min_U sup_x |F(x) - U(x)|

    by the greatest convex minorant and the least concave majorant of F, between ends that move inwards.

    References
    ----------
    Hartigan, Hartigan, "The dip test of unimodality", Annals of Statistics 13 (1985), section 3.
    """
    x, counts = np.unique(values, return_counts=True)
    above = np.cumsum(counts).astype(float)
    below = above - counts.astype(float)
    low, high, twice = 0, len(x) - 1, 1.0
    while low < high:
        part = slice(low, high + 1)
        minorant, convex = _hull(x[part], below[part], operator.le)
        majorant, concave = _hull(x[part], above[part], operator.ge)
        gap = majorant - minorant
        k = int(np.argmax(gap))
        if gap[k] <= twice:
            break
        first, last = int(convex[convex <= k][-1]), int(concave[concave >= k][0])
        left = (above[part] - minorant)[: first + 1].max()
        right = (majorant - below[part])[last:].max()
        twice = max(twice, float(left), float(right))
        if (first, last) == (0, high - low):
            break
        low, high = low + first, low + last
    return twice / (2 * len(values))


@lru_cache(maxsize=8)
def least_dip(runs: int, confidence: float, seed: int) -> float:
    """The dip that so many draws of a uniform law, of all with one mode the hardest to tell, stay below so surely."""
    dips = np.sort([dip(row) for row in uniforms(seed, 0, RESAMPLES, runs)])
    return float(dips[int(np.ceil(confidence * (RESAMPLES - 1)))])


def _hull(x: Array, y: Array, turns: Callable[[float, float], bool]) -> tuple[Array, Integers]:
    """The convex or concave hull of points in order, at each of them, and the places of its corners."""
    corners: list[int] = []
    xs, ys = x.tolist(), y.tolist()
    for i in range(len(xs)):
        while len(corners) > 1:
            a, b = corners[-2:]
            if not turns((ys[i] - ys[b]) * (xs[b] - xs[a]), (ys[b] - ys[a]) * (xs[i] - xs[b])):
                break
            corners.pop()
        corners.append(i)
    return np.interp(x, x[corners], y[corners]), np.array(corners)
