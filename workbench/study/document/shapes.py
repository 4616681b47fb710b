"""What a figure shows beside curves, as data: bars, points with names, maps of cells, and tiles with texts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import numpy as np

from workbench.study.document.curves import Band, Label, Series, Style, check_style, store
from workbench.validation.refusals import Array, described, positive, refusal, whole
from workbench.validation.signatures import door

Spans: TypeAlias = tuple[tuple[Array, ...], tuple[Array, ...]]


@dataclass(frozen=True, eq=False)
@door
class Bars:
    """Horizontal bars (N,) from `starts` to `ends` in the rows `places` of a panel that names its rows.

    The first row is 0, at the top; a place between two numbers lets several bars share a row. An end that is NaN has
    no bar. Of `low` and `high`, the ends of intervals, NaN is not known and draws nothing, and an infinite one is
    drawn as an arrow at the edge of the panel. `shade` says how much of the colour fills a bar, from 0 to 1, `thick`
    how much of a row it takes, and `texts` what is printed in each that has the room.
    """

    label: Label
    places: Array
    ends: Array
    starts: Array | float = 0.0
    style: Style = 0
    shade: float = 1.0
    thick: float = 0.7
    low: Array | None = None
    high: Array | None = None
    texts: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        call = f"Bars({described(self.label)})"
        check_style(call, self.style)
        if np.ndim(self.starts) == 0:
            object.__setattr__(self, "starts", np.full(self.places.shape, self.starts))
        store(self, call, ("places", "ends", "starts"), gaps=("ends",))
        _store_intervals(self, call, ("low", "high"))
        if not (0 <= self.shade <= 1 and 0 < self.thick <= 1):
            raise ValueError(
                f"`{call}` needs a shade from 0 to 1 and a thickness above 0 up to 1, parts of the colour and of the "
                f"row; got {self.shade!r} and {self.thick!r}."
            )
        if len(self.texts) not in (0, len(self.ends)):
            raise ValueError(f"`{call}` needs a text for each of its bars, or none; got {len(self.texts)}.")

    @property
    def spans(self) -> Spans:
        """All numbers along the abscissa, and all along the ordinate."""
        ends = tuple(np.asarray(end, dtype=float) for end in (self.starts, self.ends, self.low, self.high))
        return ends, (self.places - self.thick / 2, self.places + self.thick / 2)


@dataclass(frozen=True, eq=False)
@door
class Points:
    """Marks at points (N,), each with its name beside it, and with intervals across and upwards.

    The ends of intervals are as in `Bars`. Names are put where they cover neither each other nor a mark.
    """

    label: Label
    x: Array
    y: Array
    names: tuple[Label, ...] = ()
    style: Style = 0
    xlow: Array | None = None
    xhigh: Array | None = None
    ylow: Array | None = None
    yhigh: Array | None = None

    def __post_init__(self) -> None:
        call = f"Points({described(self.label)})"
        check_style(call, self.style)
        store(self, call, ("x", "y"), gaps=("x", "y"))
        _store_intervals(self, call, ("xlow", "xhigh", "ylow", "yhigh"))
        if len(self.names) not in (0, len(self.x)):
            raise ValueError(f"`{call}` needs a tuple of names, one for each of its points, or none.")

    @property
    def spans(self) -> Spans:
        """All numbers along the abscissa, and all along the ordinate."""
        across = tuple(np.asarray(part, dtype=float) for part in (self.x, self.xlow, self.xhigh))
        return across, tuple(np.asarray(part, dtype=float) for part in (self.y, self.ylow, self.yhigh))


@dataclass(frozen=True, eq=False)
@door
class HeatMap:
    """Numbers (r, c) printed in cells that are the darker the larger they are, in a panel that names both its sides.

    A NaN leaves its cell empty. A cell that is `faint`, as one whose interval holds zero, is printed in grey on white.
    `most` is the number of the darkest cell, without it the largest that is not faint.
    """

    values: Array
    faint: Any = False
    digits: int = 2
    most: float | None = None
    label: Label = ""
    style: Style = 0

    def __post_init__(self) -> None:
        values = self.values.copy()
        if values.ndim != 2 or not values.size or np.isinf(values).any():
            raise ValueError(
                f"`HeatMap(values)` must be numbers (r, c), finite or NaN for an empty cell; got the shape "
                f"{values.shape}."
            )
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "faint", _flags("HeatMap(faint=...)", self.faint, values.shape))
        whole("HeatMap(digits=...)", self.digits, 0, 17)
        if self.most is not None:
            positive("HeatMap(most=...)", self.most)
        check_style("HeatMap(style=...)", self.style)

    @property
    def spans(self) -> Spans:
        """All numbers along the abscissa, and all along the ordinate."""
        return _around(self.values)


@dataclass(frozen=True, eq=False)
@door
class Tiles:
    """Texts (r, c), each of some lines, in tiles of a panel that names its rows, as dark as their shades from 0 to 1.

    The first line of a text is large, the others are small. A shade that is NaN leaves its tile white, and a tile
    without a text is not drawn unless it is shaded. A tile may be `framed`, have a corner that is `marked`, be
    `hatched`, or all of it. `keys` are what the legend shows instead, small tiles each with a label.
    """

    label: Label
    texts: tuple[tuple[tuple[str, ...], ...], ...]
    shades: Array
    framed: Any = False
    marked: Any = False
    hatched: Any = False
    keys: tuple[Tiles, ...] = ()

    style: ClassVar[Style] = 0

    def __post_init__(self) -> None:
        call = f"Tiles({described(self.label)})"
        shades, shape = self.shades.copy(), (len(self.texts), len(self.texts[0]) if self.texts else 0)
        if 0 in shape or {len(row) for row in self.texts} != {shape[1]} or shades.shape != shape:
            raise ValueError(
                f"`{call}` needs rows of texts (r, c), all of one length, and a shade for each; got "
                f"{[len(row) for row in self.texts]} texts and shades {shades.shape}."
            )
        if not np.all(np.isnan(shades) | ((shades >= 0) & (shades <= 1))):
            raise ValueError(f"`{call}` needs shades from 0 to 1, parts of the scale, or NaN; got {shades.tolist()}.")
        shades.flags.writeable = False
        object.__setattr__(self, "shades", shades)
        for name in ("framed", "marked", "hatched"):
            object.__setattr__(self, name, _flags(f"Tiles({name}=...)", getattr(self, name), shape))

    @property
    def spans(self) -> Spans:
        """All numbers along the abscissa, and all along the ordinate."""
        return _around(self.shades)

    @property
    def lines(self) -> int:
        """How many lines the longest text has."""
        return max(len(text) for row in self.texts for text in row)


Mark: TypeAlias = Series | Band | Bars | Points | HeatMap | Tiles


def _around(cells: Array) -> Spans:
    """What cells (r, c) span, one unit each about 0, 1, ..."""
    rows, columns = np.shape(cells)
    return (np.array([-0.5, columns - 0.5]),), (np.array([-0.5, rows - 0.5]),)


def _flags(call: str, given: Any, shape: tuple[int, ...]) -> Any:
    """True or False for each cell."""
    try:
        return np.broadcast_to(np.asarray(given, dtype=bool), shape)
    except Exception:  # whatever an object says when it is asked for its truth
        raise refusal(call, "True or False, one for each cell or one for all", given) from None


def _store_intervals(mark: Bars | Points, call: str, names: tuple[str, ...]) -> None:
    """Copy the ends of intervals to read-only arrays as long as the mark; NaN where there are none."""
    points = mark.ends if isinstance(mark, Bars) else mark.x
    for name in names:
        given = getattr(mark, name)
        array = np.full(points.shape, np.nan) if given is None else given.copy()
        if array.shape != points.shape:
            raise ValueError(f"`{call}` needs a {name} for each of {len(points)}; got the shape {array.shape}.")
        array.flags.writeable = False
        object.__setattr__(mark, name, array)
