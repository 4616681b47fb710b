"""A figure as data: its panels, and their marks, as curves, bands, bars, points with names, cells and tiles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, TypeAlias

import numpy as np

from workbench.core.validation.refusals import Array, as_objects, describe, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.figure_checks import check_aspect, check_cut, check_sources, check_steps, check_width
from workbench.study.document.mark_fields import STYLES, Flags, Label, Spans, Style, store
from workbench.study.document.phrases_and_tables import Phrase, ReportTable, check_name
from workbench.study.document.plane_marks import Area, Arrows, Guides
from workbench.study.document.source import Source

__all__ = [
    "STYLES",
    "AbstractCurve",
    "Area",
    "Arrows",
    "Band",
    "Bars",
    "Figure",
    "Guides",
    "Label",
    "Mark",
    "Panel",
    "Points",
    "Series",
    "Spans",
    "Style",
    "Tiles",
]


class AbstractCurve:
    """A mark along an abscissa: `CURVES` names its fields for abscissa and ordinates, float arrays (N,)."""

    CURVES: ClassVar[tuple[str, ...]]

    @property
    def curves(self) -> tuple[Array, ...]:
        """The abscissa, then the ordinates."""
        return tuple(getattr(self, name) for name in self.CURVES)

    @property
    def spans(self) -> Spans:
        """The numbers along either axis."""
        return self.curves[:1], self.curves[1:]


@dataclass(frozen=True, eq=False)
@check_arguments
class Series(AbstractCurve):
    """A curve of points (N,): a NaN in `y` is a gap, as where a run has diverged.

    `style` 0 to 11 fixes its look, so that one law looks the same in all figures of a report; 'reference' (what is
    wanted), 'bound' (what is promised) and 'aid' (what helps to read) stand apart from all laws. `look` draws it as a
    line, as steps that hold each value until the next, as marks alone, or as dots, where marks are many. Series with
    the same label and style share one line of the legend; the label '' is left out of it. At most 600 points of a
    series are drawn, the extremes of each stretch among them; of dots those that show how they scatter. `sources` are
    the results that abscissa and ordinate show, as `curve` gives them; numbers of another origin have none.
    """

    CURVES = ("x", "y")
    label: Label
    x: Array
    y: Array
    style: Style = 0
    look: Literal["line", "steps", "marks", "dots"] = "line"
    sources: tuple[Source, Source] | None = None

    def __post_init__(self) -> None:
        store(self, self.CURVES, gaps=("y",))


@dataclass(frozen=True, eq=False)
@check_arguments
class Band(AbstractCurve):
    """The strip between two curves of points (N,), as between two quantiles of many runs."""

    CURVES = ("x", "low", "high")
    label: Label
    x: Array
    low: Array
    high: Array
    style: Style = 0

    def __post_init__(self) -> None:
        store(self, self.CURVES)


@dataclass(frozen=True, eq=False)
@check_arguments
class Bars:
    """Horizontal bars (N,) from `starts` to `ends` in the rows `places` of a panel that names its rows.

    The first row is 0, at the top; a place between two numbers lets several bars share a row. An end that is NaN has
    no bar. `low` and `high` are the ends of intervals: a NaN is unknown and not drawn, and an infinite end is drawn as
    an arrow at the edge of the panel. `shade` says how much of the colour fills a bar, from 0 to 1, and `thick` how
    much of a row it takes. `texts` are printed in the bars that have room. `sources` are the results that the ends
    show, None for one of another origin.
    """

    label: Label
    places: Array
    ends: Array
    starts: Array
    style: Style = 0
    shade: float = 1.0
    thick: float = 0.7
    low: Array | None = None
    high: Array | None = None
    texts: tuple[str, ...] = ()
    sources: tuple[Source | None, ...] = ()

    def __post_init__(self) -> None:
        store(self, ("places", "ends", "starts"), gaps=("ends",), intervals=("low", "high"))
        check_sources(self, len(self.spans[0][0]), self.sources)

    @property
    def spans(self) -> Spans:
        """The numbers along either axis."""
        ends = tuple(np.asarray(end) for end in (self.starts, self.ends, self.low, self.high))
        return ends, (self.places - self.thick / 2, self.places + self.thick / 2)


@dataclass(frozen=True, eq=False)
@check_arguments
class Points:
    """Marks at points (N,), each with its name beside it, and with intervals (`xlow` to `xhigh`), as in `Bars`.

    `sources` are the results that the abscissa and the ordinate of each point show, None for one of another origin. The
    `shape` of the marks is that of the style, unless they are poles (a cross), zeros (a ring) or `critical` (a plus).
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
    sources: tuple[tuple[Source | None, Source | None], ...] = ()
    shape: Literal["", "pole", "zero", "critical"] = ""

    def __post_init__(self) -> None:
        store(self, ("x", "y"), gaps=("x", "y"), intervals=("xlow", "xhigh", "ylow", "yhigh"))
        check_sources(self, len(self.spans[0][0]), self.sources)

    @property
    def spans(self) -> Spans:
        """The numbers along either axis."""
        across = tuple(np.asarray(part) for part in (self.x, self.xlow, self.xhigh))
        return across, tuple(np.asarray(part) for part in (self.y, self.ylow, self.yhigh))


@dataclass(frozen=True, eq=False)
@check_arguments
class Tiles:
    """Texts (r, c), each of some lines, in tiles of a panel that names its rows, as dark as their shades from 0 to 1.

    The first line of a text is large. A shade that is NaN leaves its tile white, and a tile without a text is not drawn
    unless it is shaded. A tile may be `has_frame`, have a `has_mark` corner, or be `has_hatch`, each True or False for
    all tiles or for each (r, c). `keys` are what the legend shows instead, small tiles each with a label.
    """

    label: Label
    texts: tuple[tuple[tuple[str, ...], ...], ...]
    shades: Array
    has_frame: Flags = False
    has_mark: Flags = False
    has_hatch: Flags = False
    keys: tuple[Tiles, ...] = ()

    style: ClassVar[Style] = 0

    def __post_init__(self) -> None:
        for name in ("has_frame", "has_mark", "has_hatch"):
            given = getattr(self, name)
            flags = as_objects(given)
            if flags.shape not in ((), self.shades.shape) or {type(one) for one in flags.flat} - {bool, np.bool_}:
                raise refusal(f"Tiles({name}=...)", f"True, False, or an array of shape {self.shades.shape}", given)
            object.__setattr__(self, name, np.broadcast_to(flags.astype(bool), self.shades.shape))

    @property
    def spans(self) -> Spans:
        """The numbers along either axis."""
        return _around(self.shades)

    @property
    def lines(self) -> int:
        """The number of lines of the longest text."""
        return max((len(text) for row in self.texts for text in row), default=0)


Mark: TypeAlias = Series | Band | Bars | Points | Tiles | Area | Arrows | Guides


def _around(cells: Array) -> Spans:
    """The ranges of both axes that cells (r, c) cover, one unit each, centred at 0, 1, ..."""
    rows, columns = np.shape(cells)
    return (np.array([-0.5, columns - 0.5]),), (np.array([-0.5, rows - 0.5]),)


@dataclass(frozen=True, eq=False)
@check_arguments
class Panel:
    """One pair of axes. Labels carry their units: 'tracking error [rad]'.

    `hlines` and `vlines` are thin lines across the axes. The series that stands first lies on top. An axis with names
    counts them: `xnames` are columns 0, 1, ... from the left, `ynames` rows 0, 1, ... from the top. Up to `xcut`, a
    number within `xlim`, the abscissa takes half of the width, the rest the other half; its label says so. `xsteps` and
    `ysteps` are the steps that the numbers at a linear axis may have, in rising order: (45, 90, 180) for degrees. A
    panel whose points have names is higher than one without, unless all are 'wide'; a 'tall' one is higher still, and
    so is one of 'equal' axes: a unit is as long across as upwards, and the shorter range is widened.

    Raises
    ------
    ValueError
        If there is nothing to draw, a logarithmic axis meets a number that has no logarithm, there is no place for
        `xcut`, the steps are none, or equal axes are not linear.
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
    xcut: float | None = None
    xsteps: tuple[float, ...] = ()
    ysteps: tuple[float, ...] = ()
    aspect: Literal["", "wide", "tall", "equal"] = ""

    def __post_init__(self) -> None:
        if not self.series:
            raise ValueError(f"`Panel({describe(self.ylabel)})` must have at least one series; got none.")
        for name, limits in (("xlim", self.xlim), ("ylim", self.ylim)):
            if limits is not None and not -np.inf < limits[0] < limits[1] < np.inf:
                raise ValueError(f"`Panel({name}=...)` must be (low, high), low < high; got {limits!r}.")
        check_cut(self.xcut, self.xlim, self.xscale)
        check_steps(self.xsteps, self.ysteps)
        check_aspect(self.aspect == "equal", (self.xscale, self.yscale), self.xcut)
        if self.xscale == "log":
            self._check_logarithms("xscale", (*(self.xlim or ()), *self.vlines), 0)
        if self.yscale == "log":
            self._check_logarithms("yscale", (*(self.ylim or ()), *self.hlines), 1)

    def _check_logarithms(self, name: str, lines: tuple[float, ...], axis: int) -> None:
        """Refuse limits, lines and marks along an axis that have no logarithm."""
        held = {"limits and lines": [np.array(lines)]}
        held |= {f"numbers, but the series {describe(mark.label)}": list(mark.spans[axis]) for mark in self.series}
        for what, arrays in held.items():
            least = min((float(np.nanmin(part)) for part in arrays if not np.isnan(part).all()), default=1.0)
            if least <= 0:
                raise ValueError(
                    f"`Panel({name}='log')` needs {what} > 0; got {least:g}. Draw an absolute value, or use 'linear'."
                )


@dataclass(frozen=True)
@check_arguments
class Figure:
    """One or more panels below a common legend, laid out row by row in a number of `columns`.

    With `lead` the first panel has the whole width, above the others; all have names of rows. `numbers` is a table for
    further use: it becomes a file, and is not printed. `width` is the share of the text's width that it takes, with
    letters of the same size. `title` names it in a list of pictures.
    """

    name: str
    caption: Phrase
    panels: tuple[Panel, ...]
    columns: int = 1
    numbers: ReportTable | None = None
    lead: bool = False
    width: float = 1.0
    title: str = ""

    def __post_init__(self) -> None:
        check_name("Figure", self.name)
        if not (self.panels and 1 <= self.columns <= 3):
            raise ValueError(
                f"`Figure('{self.name}')` must have at least one panel, in 1 to 3 columns, to fit a page; "
                f"got {len(self.panels)} panels and for the columns {describe(self.columns)}."
            )
        if self.lead and not all(panel.ynames for panel in self.panels):
            raise refusal(f"Figure('{self.name}', lead=...)", "False where a panel has no row names (`ynames`)", True)
        check_width(self.name, self.width)
