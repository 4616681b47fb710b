"""What one pair of axes shows, as data: its marks, its scales, and what is written around it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from workbench.study.document.curves import Label
from workbench.study.document.shapes import Bars, HeatMap, Mark, Tiles
from workbench.validation.refusals import Array, described
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
        If there is nothing to draw, a logarithmic axis meets a number that has no logarithm, or names do not fit
        what is drawn along them.
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
        for name in ("xlim", "ylim"):
            limits = getattr(self, name)
            if limits is not None and not -np.inf < limits[0] < limits[1] < np.inf:
                raise ValueError(f"`Panel({name}=...)` must be (low, high), low < high; got {limits!r}.")
        for name, lines in (("x", self.vlines), ("y", self.hlines)):
            least = min((*(getattr(self, f"{name}lim") or ()), *lines), default=1.0)
            if getattr(self, f"{name}scale") == "log" and least <= 0:
                raise ValueError(
                    f"`Panel({name}scale='log')` needs limits and lines > 0, which have a logarithm; got {least:g}."
                )
        for name, scale, lim, which in (("x", self.xscale, self.xlim, 0), ("y", self.yscale, self.ylim, 1)):
            for mark in self.series:
                self._check_scale(f"{name}scale", scale, mark, mark.spans[which])
            self._check_names(name, scale, lim, [mark.spans[which] for mark in self.series])
        if any(isinstance(mark, Bars | HeatMap | Tiles) for mark in self.series) and not self.ynames:
            raise ValueError(
                f"`Panel({described(self.ylabel)}, series=...)` holds bars or cells, which stand in rows: name these "
                "by `ynames=`."
            )

    def _check_scale(self, name: str, scale: str, mark: Mark, spans: tuple[Array, ...]) -> None:
        least = min((float(np.nanmin(span)) for span in spans if not np.isnan(span).all()), default=1.0)
        if scale == "log" and least <= 0:
            raise ValueError(
                f"`Panel({name}='log')` needs numbers > 0, which have a logarithm; the series "
                f"{described(mark.label)} has {least:g}. Draw its absolute value, or use 'linear'."
            )

    def _check_names(self, name: str, scale: str, lim: object, spans: list[tuple[Array, ...]]) -> None:
        names = getattr(self, f"{name}names")
        if not names:
            return
        if scale != "linear" or lim is not None:
            raise ValueError(f"`Panel({name}names=...)` counts its names: it takes no {name}scale and no {name}lim.")
        numbers = np.concatenate([np.ravel(part) for held in spans for part in held])
        if numbers.size and not (np.nanmin(numbers) >= -0.5 and np.nanmax(numbers) <= len(names) - 0.5):
            raise ValueError(
                f"`Panel({name}names=...)` has {len(names)} names, for the places 0 to {len(names) - 1}; what is drawn "
                f"runs from {np.nanmin(numbers):g} to {np.nanmax(numbers):g}."
            )
