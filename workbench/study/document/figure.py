"""A figure as data: panels, each with its marks, its scales and its labels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from workbench.study.document.figure_marks import Label, Mark
from workbench.study.document.phrases import Phrase, Table, check_name
from workbench.validation.refusals import described
from workbench.validation.signatures import door


@dataclass(frozen=True, eq=False)
@door
class Panel:
    """One pair of axes. Labels carry their units: 'tracking error [rad]'.

    `hlines` and `vlines` are thin lines across the axes. The series that stands first lies on top. An axis with names
    counts them: `xnames` are columns 0, 1, ... from the left, `ynames` rows 0, 1, ... from the top.

    Raises
    ------
    ValueError
        If there is nothing to draw, or a logarithmic axis meets a number that has no logarithm.
    """

    ylabel: Label
    series: tuple[Mark, ...]
    xlabel: Label = "time [s]"
    xlim: tuple[float, float] | None = None
    ylim: tuple[float, float] | None = None
    xscale: Literal["linear", "log"] = "linear"
    yscale: Literal["linear", "log"] = "linear"
    title: Label = ""
    hlines: tuple[float, ...] = ()
    vlines: tuple[float, ...] = ()
    xnames: tuple[Label, ...] = ()
    ynames: tuple[Label, ...] = ()

    def __post_init__(self) -> None:
        if not self.series:
            raise ValueError(f"`Panel({described(self.ylabel)})` must have at least one series; got none.")
        for name, limits in (("xlim", self.xlim), ("ylim", self.ylim)):
            if limits is not None and not -np.inf < limits[0] < limits[1] < np.inf:
                raise ValueError(f"`Panel({name}=...)` must be (low, high), low < high; got {limits!r}.")
        if self.xscale == "log":
            self._check_logarithms("xscale", (*(self.xlim or ()), *self.vlines), 0)
        if self.yscale == "log":
            self._check_logarithms("yscale", (*(self.ylim or ()), *self.hlines), 1)

    def _check_logarithms(self, name: str, lines: tuple[float, ...], axis: int) -> None:
        """Refuse limits, lines and marks along an axis that have no logarithm."""
        held = {"limits and lines": [np.array(lines)]}
        held |= {f"numbers, but the series {described(mark.label)}": list(mark.spans[axis]) for mark in self.series}
        for what, arrays in held.items():
            least = min((float(np.nanmin(part)) for part in arrays if not np.isnan(part).all()), default=1.0)
            if least <= 0:
                raise ValueError(
                    f"`Panel({name}='log')` needs {what} > 0, which have a logarithm; got {least:g}. Draw an absolute "
                    "value, or use 'linear'."
                )


@dataclass(frozen=True)
@door
class Figure:
    """One or more panels below a common legend, laid out row by row in so many `columns`.

    With `lead` the first panel has the whole width, above the others. `numbers` are what the figure shows, for a reader
    who goes on with them: a table of its own file, not printed.
    """

    name: str
    caption: Phrase
    panels: tuple[Panel, ...]
    columns: int = 1
    numbers: Table | None = None
    lead: bool = False

    def __post_init__(self) -> None:
        check_name("Figure", self.name)
        if not (self.panels and 1 <= self.columns <= 3):
            raise ValueError(
                f"`Figure('{self.name}')` must have at least one panel, in 1 to 3 columns, to fit a page; "
                f"got {len(self.panels)} panels and for the columns {described(self.columns)}."
            )
