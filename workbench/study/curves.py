"""What a figure shows, as data: panels of series and bands, checked before anyone draws them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from workbench.notation.formula import Formula
from workbench.study.cells import check_phrase, several

Label: TypeAlias = str | Formula | tuple[str | Formula, ...]
Style: TypeAlias = int | Literal["reference", "bound"]
Array: TypeAlias = np.ndarray[Any, np.dtype[np.float64]]

STYLES = 8


@dataclass(frozen=True, eq=False)
class Series:
    """A curve of points (N,): a NaN in `y` is a gap, as where a run has diverged.

    `style` 0 to 7 fixes its look, so that one law looks the same in all figures of a report; the
    styles 'reference' (what is wanted) and 'bound' (what is promised) stand apart from all laws.
    `look` draws it as a line, as steps that hold each value until the next (a sampled law), or as
    marks alone. Series with the same label and style share one line of the legend; the label '' is
    left out of it. At most 600 points of a series are drawn: extremes are kept, so that chattering
    stays visible as a band.
    """

    label: Label
    x: npt.ArrayLike
    y: npt.ArrayLike
    style: Style = 0
    look: Literal["line", "steps", "marks"] = "line"

    def __post_init__(self) -> None:
        check_phrase("Series(label)", self.label, label=True)
        _check_style(f"Series({self.label!r})", self.style)
        _store_curves(self, f"Series({self.label!r})", ("x", "y"), gaps=("y",))

    @property
    def curves(self) -> tuple[Array, ...]:
        """The abscissa, then the ordinates: float arrays (N,)."""
        return np.asarray(self.x, dtype=float), np.asarray(self.y, dtype=float)


@dataclass(frozen=True, eq=False)
class Band:
    """The strip between two curves of points (N,), as between two quantiles of many runs."""

    label: Label
    x: npt.ArrayLike
    low: npt.ArrayLike
    high: npt.ArrayLike
    style: Style = 0

    def __post_init__(self) -> None:
        check_phrase("Band(label)", self.label, label=True)
        _check_style(f"Band({self.label!r})", self.style)
        _store_curves(self, f"Band({self.label!r})", ("x", "low", "high"), gaps=())

    @property
    def curves(self) -> tuple[Array, ...]:
        """The abscissa, then the ordinates: float arrays (N,)."""
        return tuple(np.asarray(curve, dtype=float) for curve in (self.x, self.low, self.high))


@dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes. Labels carry their units: 'tracking error [rad]'.

    `hlines` and `vlines` are thin lines across the axes. The series that stands first lies on top.

    Raises
    ------
    ValueError
        If there is nothing to draw, or a logarithmic axis meets a number that has no logarithm.
    """

    ylabel: Label
    series: tuple[Series | Band, ...]
    xlabel: Label = "time [s]"
    xlim: tuple[float, float] | None = None
    ylim: tuple[float, float] | None = None
    xscale: Literal["linear", "log"] = "linear"
    yscale: Literal["linear", "log"] = "linear"
    title: Label = ""
    hlines: tuple[float, ...] = ()
    vlines: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name in ("ylabel", "xlabel", "title"):
            check_phrase(f"Panel({name}=...)", getattr(self, name), label=True)
        call = f"Panel({self.ylabel!r}, series=...)"
        object.__setattr__(self, "series", several(call, self.series, (Series, Band), "series"))
        if not self.series:
            raise ValueError(f"`Panel({self.ylabel!r})` must have at least one series; got none.")
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
        for series in self.series:
            x, *ys = series.curves
            self._check_scale("xscale", self.xscale, series, x)
            for y in ys:
                self._check_scale("yscale", self.yscale, series, y)

    def _check_scale(self, name: str, scale: str, series: Series | Band, numbers: Array) -> None:
        if scale not in ("linear", "log"):
            raise ValueError(f"`Panel({name}=...)` must be 'linear' or 'log'; got {scale!r}.")
        if scale == "log" and np.any(numbers <= 0):
            raise ValueError(
                f"`Panel({name}='log')` needs numbers > 0, which have a logarithm; the series "
                f"{series.label!r} has {np.nanmin(numbers):g}. Draw its absolute value, or use 'linear'."
            )


def _check_style(call: str, style: Style) -> None:
    if style not in (*range(STYLES), "reference", "bound"):
        raise ValueError(f"`{call}` takes a style of 0 to {STYLES - 1}, 'reference' or 'bound'; got {style!r}.")


def _store_curves(curve: Series | Band, call: str, names: tuple[str, ...], gaps: tuple[str, ...]) -> None:
    """Copy the named fields to read-only float arrays of one length, finite but for NaN in `gaps`."""
    shapes = set()
    for name in names:
        array = np.array(getattr(curve, name), dtype=float)
        shapes.add(array.shape)
        if np.isinf(array).any() or (name not in gaps and np.isnan(array).any()):
            rule = "finite, or NaN for a gap" if name in gaps else "finite"
            raise ValueError(f"`{call}` needs a {name} that is {rule}; got one that is not.")
        array.flags.writeable = False
        object.__setattr__(curve, name, array)
    if len(shapes) != 1 or any(len(shape) != 1 or shape == (0,) for shape in shapes):
        raise ValueError(f"`{call}` needs {' and '.join(names)} of one length N >= 1; got the shapes {sorted(shapes)}.")
