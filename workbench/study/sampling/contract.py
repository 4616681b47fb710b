"""What a design must say of itself, and the uniform numbers that its rows are made of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from workbench.core.layout import Array

# No random point comes nearer to a face of the cube, where a normal number would be infinite: the middle of the outer
# one of 2^30 cells, which is all that a Sobol sequence of 30 bits can tell apart.
MARGIN = 2.0**-31
MOST = 2**53  # beyond it whole numbers are no longer exact as doubles
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
    end = design.size if last is None else last
    if not (_is_whole(first) and _is_whole(end) and 0 <= first <= end <= design.size):
        raise ValueError(
            f"`points(first, last)` of this design must keep 0 <= first <= last <= {design.size}, its number of runs; "
            f"got {first!r} and {last!r}."
        )
    return int(first), int(end)


def whole(call: str, value: Any, least: int, of: str, most: int = MOST) -> int:
    """A whole number from `least` on, or a refusal; `of` says what it counts."""
    if not _is_whole(value) or not least <= value <= most:
        upper = f" and at most {most}" if most < MOST else ""
        raise ValueError(f"`{call}` must be a whole number of {of}, at least {least}{upper}; got {value!r}.")
    return int(value)


def seeded(call: str, value: Any) -> int:
    """A seed, or a refusal."""
    if not _is_whole(value) or not 0 <= value < 2**64:
        raise ValueError(f"`{call}` must be a whole number from 0 to 2^64 - 1, the key of a generator; got {value!r}.")
    return int(value)


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)
