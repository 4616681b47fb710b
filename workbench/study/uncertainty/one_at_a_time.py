"""One factor at a time, all others held: the runs behind a tornado."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.study.uncertainty.design import AbstractDesign, span
from workbench.validation.refusals import Array, finite, refusal, whole
from workbench.validation.signatures import door


@dataclass(frozen=True)
@door
class OneAtATime(AbstractDesign):
    """The point where all factors have the quantile `base`, then each factor by itself at each of `levels`.

    Point 0 is the base, point 1 + i k + j has factor i at level j of k. It says nothing of interactions.

    Raises
    ------
    ValueError
        If there is no factor or no level, or if a level or the base is no quantile from 0 to 1, or levels repeat.
    """

    dimensions: int
    levels: tuple[float, ...] = (0.05, 0.95)
    base: float = 0.5

    def __post_init__(self) -> None:
        whole("OneAtATime(dimensions=...)", self.dimensions, of=" of factors")
        for name, quantiles in (("levels", self.levels), ("base", (self.base,))):
            for quantile in quantiles:
                finite(f"OneAtATime({name}=...)", quantile, ", a quantile", low=0, high=1)
        if not self.levels or len(set(self.levels)) < len(self.levels):
            raise refusal("OneAtATime(levels=...)", "different quantiles, at least one", self.levels)

    @property
    def size(self) -> int:
        """How many runs: the base, and each level of each factor."""
        return 1 + self.dimensions * len(self.levels)

    def points(self, first: int = 0, last: int | None = None) -> Array:
        """The points with the numbers first to last - 1."""
        first, last = span(self, first, last)
        rows = np.full((last - first, self.dimensions), self.base)
        moved = np.arange(max(first, 1), last)
        factor, level = np.divmod(moved - 1, len(self.levels))
        rows[moved - first, factor] = np.array(self.levels)[level]
        return rows
