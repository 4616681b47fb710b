"""Saltelli's design on scrambled Sobol sequences: the runs behind variance-based indices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array, seed, whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine.distributions import MARGIN
from workbench.study.uncertainty.designs import AbstractDesign

SCRAMBLES = 4  # see SobolDesign
MOST_DIMENSIONS = 21_201 // 2  # of which SciPy has direction numbers, half for A and half for B


@dataclass(frozen=True)
@check_arguments
class SobolDesign(AbstractDesign):
    """A design of `base` pairs of points A and B, with points that take a single coordinate from the other one.

    A block of runs is A, then A with coordinate i from B for every i, then with `second_order` B with coordinate i
    from A for every i, then B (Saltelli). The pairs are four independently scrambled Sobol nets of base / 4 points in
    twice the dimensions (Owen): intervals come from the scatter of their four answers.

    Raises
    ------
    ValueError
        If there is no factor or there are too many, if `base` is not a power of two from 8 on, or if the seed is not a
        seed.

    References
    ----------
    Saltelli (2002), Computer Physics Communications 145.
    Owen (1998), Journal of Complexity 14.

    Examples
    --------
    >>> wb.SobolDesign(dimensions=3, base=256).size
    1280
    """

    dimensions: int
    base: int
    second_order: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        whole("SobolDesign(dimensions=...)", self.dimensions, 1, MOST_DIMENSIONS, " of factors")
        seed("SobolDesign(seed=...)", self.seed)
        # a scramble of one point has no variance
        base = whole("SobolDesign(base=...)", self.base, 2 * SCRAMBLES, round(0.25 / MARGIN), " of pairs of points")
        if base & (base - 1):
            below = 1 << base.bit_length() - 1
            raise ValueError(
                "`SobolDesign(base=...)` must be a power of two, or the points of a Sobol sequence are not balanced; "
                f"got {base}. The nearest are {below} and {2 * below}."
            )

    @property
    def block(self) -> int:
        """The number of runs of one pair of points."""
        return 2 + (2 if self.second_order else 1) * self.dimensions

    @property
    def size(self) -> int:
        """The number of runs."""
        return self.base * self.block

    def _rows(self, first: int, last: int) -> Array:
        d, begin = self.dimensions, first // self.block
        pairs = self._pairs(begin, -(-last // self.block))
        A, B = pairs[:, :d], pairs[:, d:]
        rows = np.repeat(A[:, np.newaxis], self.block, axis=1)
        rows[:, 1 + d :] = B[:, np.newaxis]
        for i in range(d):
            rows[:, 1 + i, i] = B[:, i]
            if self.second_order:
                rows[:, 1 + d + i, i] = A[:, i]
        return rows.reshape(-1, d)[first - begin * self.block : last - begin * self.block]

    def _pairs(self, first: int, last: int) -> Array:
        """The pairs first to last - 1, (last - first, 2 dimensions)."""
        each = self.base // SCRAMBLES
        parts = [np.empty((0, 2 * self.dimensions))]
        for scramble in range(first // each, -(-last // each)):
            begin, end = max(first - scramble * each, 0), min(last - scramble * each, each)
            parts.append(_net(2 * self.dimensions, self.seed, scramble, begin, end))
        return np.concatenate(parts)


def _net(dimensions: int, seed: int, scramble: int, first: int, last: int) -> Array:
    """Points first to last - 1 of a scrambled Sobol net, in the middles of its finest cells."""
    from scipy.stats import qmc  # costs half a second, and only those who draw

    sequence = qmc.Sobol(dimensions, rng=np.random.default_rng([seed, scramble]))
    if first:
        sequence.fast_forward(first)
        points = sequence.random(last - first)
    else:  # one point and then the others: SciPy warns of a beginning that is no power of two, as a chunk may be
        points = np.concatenate([sequence.random(1), sequence.random(last - 1)])
    return np.asarray(points + MARGIN)
