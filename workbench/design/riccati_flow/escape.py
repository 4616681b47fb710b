"""The time at which P leaves every bound, between two others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from workbench.validation.views import show

BISECTIONS = 60
LARGEST = 1e150  # of an entry of P, whose square is in the equation


@dataclass(frozen=True)
@show
class Escape:
    """P is finite at `after` and has had a pole by `before`, in s; infinite where it was not gone so far."""

    after: float
    before: float

    def later(self, start: float) -> Escape:
        """The same escape on a clock that showed `start` when this one showed zero."""
        return Escape(start + self.after, start + self.before)

    def joined(self, other: Escape) -> Escape:
        """What both say together."""
        return Escape(min(self.after, other.after), max(self.before, other.before))


def bracketed(escaped: Callable[[float], bool], start: float, length: float) -> Escape:
    """The escape that happens between `start` and `start + length`, by bisection of the length gone from `start`."""
    low, high = 0.0, length
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if not low < middle < high:
            break
        if escaped(middle):
            high = middle
        else:
            low = middle
    return Escape(start + low, start + high)
