"""The least or greatest value of something over a box: what was seen, and what is proved of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.validation.refusals import Array


@dataclass(frozen=True, eq=False)
class Extreme:
    """The least or greatest value of something over a box.

    Attributes
    ----------
    value, x
        The extreme of what was seen, to rounding, and the point (k,) at which it was.
    reached
        What the extreme is proved to reach there: it is at most this if the least, at least this if the greatest.
    beyond
        What no value in the box lies beyond, proved; None where nothing was.
    boxes, samples
        How many boxes the proof has looked at, and how many points the search.
    why
        What kept the proof from its tolerance; empty where nothing did.
    """

    value: float
    x: Array
    reached: float
    beyond: float | None
    boxes: int
    samples: int
    why: str

    @property
    def complete(self) -> bool:
        """Whether seen and proved lie within the tolerance of each other."""
        return not self.why

    @property
    def digits(self) -> int:
        """How many decimal digits of the value are proved right, by the gap between seen and proved."""
        if self.beyond is None or not self.value:
            return 0
        gap = max(abs(self.value - self.beyond), 1e-16 * abs(self.value))
        return max(int(-np.log10(2 * gap / abs(self.value))), 0)


@dataclass(frozen=True, eq=False)
class Enclosure:
    """Both extremes of an expression over a box: low <= expression <= high is proved."""

    least: Extreme
    greatest: Extreme

    @property
    def low(self) -> float | None:
        """What no value lies below; None if nothing was proved."""
        return self.least.beyond

    @property
    def high(self) -> float | None:
        """What no value lies above; None if nothing was proved."""
        return self.greatest.beyond

    @property
    def complete(self) -> bool:
        """Whether both sides reach their tolerance."""
        return self.least.complete and self.greatest.complete
