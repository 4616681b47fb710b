"""What a loop, a factor and a design must say of themselves to be swept."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from workbench.core import Ode
from workbench.core.layout import Array


class Loop(Protocol):
    """Anything that can say its equations."""

    def ode(self, name: str = ...) -> Ode:
        """The loop as x' = f(t, x, p)."""


class Distribution(Protocol):
    """How a number is spread."""

    def quantile(self, u: Array) -> Array:
        """The values (n,) that are not exceeded with the probabilities u (n,)."""


class Factor(Protocol):
    """A number that is varied: one or several paths of a loop that move together."""

    @property
    def name(self) -> str:
        """How a report calls it."""

    @property
    def paths(self) -> Sequence[str]:
        """The parameters or initial states that take its value, each a single number."""

    @property
    def distribution(self) -> Distribution:
        """How it is spread."""


class Design(Protocol):
    """Points of the unit cube, one a run, each made from the seed and its own number alone."""

    @property
    def size(self) -> int:
        """How many runs."""

    def points(self, first: int, last: int) -> Array:
        """The points with the numbers first to last - 1, (last - first, d)."""
