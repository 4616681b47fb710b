"""Morris's design: trajectories in which every factor moves once, by the same distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.study.uncertainty.design import AbstractDesign, span, uniforms
from workbench.validation.refusals import Array, seed, whole
from workbench.validation.signatures import door


@dataclass(frozen=True)
@door
class MorrisDesign(AbstractDesign):
    """`trajectories` random paths over a grid of p = `levels` levels an axis, each of dimensions + 1 points.

    From one point of a path to the next a single factor moves, up or down, by delta = p / (2 (p - 1)). Run
    k (dimensions + 1) + j is point j of path k. The levels include 0 and 1, so a factor must be bounded.

    Raises
    ------
    ValueError
        If there is no factor, less than two trajectories or an odd number of levels, or if the seed is none.

    References
    ----------
    Morris (1991), Factorial sampling plans for preliminary computational experiments, Technometrics 33.
    """

    dimensions: int
    trajectories: int
    levels: int = 4
    seed: int = 0

    def __post_init__(self) -> None:
        whole("MorrisDesign(dimensions=...)", self.dimensions, of=" of factors")
        whole("MorrisDesign(trajectories=...)", self.trajectories, 2, why="as an interval needs a scatter")
        whole("MorrisDesign(levels=...)", self.levels, 2)
        seed("MorrisDesign(seed=...)", self.seed)
        if self.levels % 2:
            raise ValueError(
                "`MorrisDesign(levels=...)` must be even, so that half of the levels can step up by half of them; got "
                f"{self.levels}."
            )

    @property
    def size(self) -> int:
        """How many runs."""
        return self.trajectories * (self.dimensions + 1)

    @property
    def delta(self) -> float:
        """How far a factor moves, in the unit cube."""
        return self.levels / (2 * (self.levels - 1))

    def points(self, first: int = 0, last: int | None = None) -> Array:
        """The points with the numbers first to last - 1."""
        first, last = span(self, first, last)
        d, length = self.dimensions, self.dimensions + 1
        begin, end = first // length, -(-last // length)
        drawn = uniforms(self.seed, begin, end, 3 * d).reshape(end - begin, 3, 1, d)
        lower = np.floor(drawn[:, 0] * (self.levels // 2)) / (self.levels - 1)
        rises = drawn[:, 1] < 0.5
        turn = np.argsort(np.argsort(drawn[:, 2], axis=-1), axis=-1)  # when each factor moves
        moved = turn < np.arange(length)[:, np.newaxis]
        rows = lower + self.delta * (moved == rises)
        # delta and the levels are rounded by themselves: the upmost level may end beyond 1
        rows = np.minimum(rows.reshape(-1, d), 1.0)
        return np.asarray(rows[first - begin * length : last - begin * length])
