"""Points that somebody else has chosen."""

from __future__ import annotations

from dataclasses import dataclass, field

from workbench.study.uncertainty.design import AbstractDesign, span
from workbench.validation.refusals import Array
from workbench.validation.signatures import door


@dataclass(frozen=True, eq=False)
@door
class Listed(AbstractDesign):
    """The points (N, d) of the unit cube as they are given.

    Raises
    ------
    ValueError
        If they are no such points, or none.
    """

    given: Array
    dimensions: int = field(init=False)

    def __post_init__(self) -> None:
        given = self.given.copy()
        if given.ndim != 2 or not given.size or not ((given >= 0) & (given <= 1)).all():
            beyond = " with points beyond it" if given.ndim == 2 and given.size else ""
            raise ValueError(
                f"`Listed(given)` must be at least one point (N, d) of the unit cube; got shape {given.shape}{beyond}."
            )
        object.__setattr__(self, "given", given)
        object.__setattr__(self, "dimensions", given.shape[1])

    @property
    def size(self) -> int:
        """How many runs."""
        return len(self.given)

    def points(self, first: int = 0, last: int | None = None) -> Array:
        """The points with the numbers first to last - 1."""
        begin, end = span(self, first, last)
        return self.given[begin:end]
