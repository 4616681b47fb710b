"""Marks of a plane, as that of complex numbers: regions, arrows, and the lines of a grid with their names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from workbench.core.validation.refusals import Array, describe
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.mark_fields import Label, Spans, Style, store
from workbench.study.document.source import Source


@dataclass(frozen=True, eq=False)
@check_arguments
class Area:
    """A filled region within the polygon of the points (N,), as a disk that a curve must not enter.

    It does not stretch the axes of its panel.
    """

    label: Label
    x: Array
    y: Array
    style: Style = "reference"

    def __post_init__(self) -> None:
        store(self, ("x", "y"))

    @property
    def spans(self) -> Spans:
        """No numbers along either axis."""
        return (), ()


@dataclass(frozen=True, eq=False)
@check_arguments
class Arrows:
    """Arrows at the points (N,) along the directions (u, v), as the axes of the panel show them.

    All have the same `length` in points, and begin at their points; those of the length 0 are heads alone, with their
    middle at the point. One whose direction is zero or NaN is not drawn. `source` is the result along which they stand.
    """

    label: Label
    x: Array
    y: Array
    u: Array
    v: Array
    style: Style = 0
    length: float = 0.0
    source: Source | None = None

    def __post_init__(self) -> None:
        store(self, ("x", "y", "u", "v"), gaps=("x", "y", "u", "v"))
        if not 0 <= self.length < np.inf:
            raise ValueError(f"`Arrows(length=...)` must be zero or more points; got {self.length!r}.")

    @property
    def spans(self) -> Spans:
        """The numbers along either axis."""
        return (self.x,), (self.y,)


@dataclass(frozen=True, eq=False)
@check_arguments
class Guides:
    """Thin grey lines behind all other marks, each with its name where there is room on it, preferably at its end.

    Of each line `lines` has the abscissae and the ordinates, arrays (N,) with N >= 2, NaN for a gap. They do not
    stretch the axes of the panel. The name '' is none.
    """

    lines: tuple[tuple[Array, Array], ...]
    names: tuple[Label, ...] = ()

    label: ClassVar[Label] = ""
    style: ClassVar[Style] = "aid"

    def __post_init__(self) -> None:
        if self.names and len(self.names) != len(self.lines):
            raise ValueError(
                f"`Guides(names=...)` must have a name for each of {len(self.lines)} lines, or be left out; got "
                f"{len(self.names)}."
            )
        for x, y in self.lines:
            if x.ndim != 1 or x.shape != y.shape or x.size < 2 or np.isinf(x).any() or np.isinf(y).any():
                raise ValueError(
                    "`Guides(lines=...)` must be pairs of arrays (N,) of one length N >= 2, finite or NaN for a gap; "
                    f"got {describe(x)} and {describe(y)}."
                )

    @property
    def spans(self) -> Spans:
        """No numbers along either axis."""
        return (), ()
