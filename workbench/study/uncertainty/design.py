"""What a design must say of itself, and the uniform numbers that its rows are made of."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from workbench.validation.refusals import Array, whole

# No random point comes nearer to a face of the cube, where a normal number would be infinite: the middle of the outer
# one of 2^30 cells, which is all that a Sobol sequence of 30 bits can tell apart.
MARGIN = 2.0**-31
WORDS = 4  # that one counter of Philox gives


class AbstractDesign(ABC):
    """`size` points in the unit cube of `dimensions` factors, one a run."""

    dimensions: int

    @property
    @abstractmethod
    def size(self) -> int:
        """How many runs."""

    @abstractmethod
    def points(self, first: int = 0, last: int | None = None) -> Array:
        """The points with the numbers first to last - 1, (last - first, dimensions); all of them if not told.

        Raises
        ------
        ValueError
            If 0 <= first <= last <= size does not hold.
        """


def uniforms(seed: int, first: int, last: int, width: int) -> Array:
    """Rows first to last - 1 of uniform numbers within the cube, (last - first, width), from seed and row number."""
    counters = -(-width // WORDS)
    bits = np.random.Philox(key=seed)
    bits.advance(first * counters)
    rows = np.random.Generator(bits).random((last - first, WORDS * counters))
    return np.clip(rows[:, :width], MARGIN, 1 - MARGIN)


def span(design: AbstractDesign, first: int, last: int | None) -> tuple[int, int]:
    """The numbers of the first point and of the one after the last, or a refusal."""
    begin = whole("points(first=...)", first, 0, design.size)
    return begin, design.size if last is None else whole("points(last=...)", last, begin, design.size)
