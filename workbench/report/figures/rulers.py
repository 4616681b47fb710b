"""The two rulers of a panel, with their ranges, marks and numbers; and the size of a figure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from matplotlib.ticker import Locator, LogFormatterSciNotation, LogLocator, MaxNLocator, ScalarFormatter

from workbench.core.validation.refusals import Array
from workbench.report.figures.pen import NUMBER, block_of, extent, fold_label, mathtext, plain_number
from workbench.report.figures.style import MAX_NAME_WIDTH, SMALL_LETTERS, WIDTH, below, column_of, shares_rows
from workbench.study.document.figure import Bars, Figure, Label, Mark, Panel, Points, Series, Tiles

PLAIN = (1e-3, 1e4)  # between these a short logarithmic ruler needs no powers of ten
COLUMNS = 8  # that a panel has the room for: the cells of fewer are no wider
BESIDE = 20.0  # points: the edges of a panel
UPRIGHT = 0.24  # of a figure's width: the longest line of a name below a column
ROW, LINE = 0.19, 0.125  # inches: the least of a named row, and of each line of its name
MOST, FEW = 0.3, 2.0  # inches: the most of a named row, and what few of them share
TILE, TILE_LINE = 0.06, 0.1  # inches: the edges of a tile, and each line of its text
AROUND = 0.6  # inches: what stands above and below rows
TALL = 7.6  # inches that a page has for a figure beside its caption
PLANE = {1: 4.4, 2: 3.0, 3: 2.2}  # inches, by columns: the height of a panel that is about as high as wide


@dataclass(frozen=True)
class Ticks:
    """Marks at their places with their numbers, and the power of ten that all numbers share.

    Where things are counted there are names instead, without marks, and `upright` where they are too wide.
    """

    places: tuple[float, ...]
    numbers: tuple[str, ...]
    minor: tuple[float, ...] = ()
    power: str = ""
    has_names: bool = False
    upright: bool = False

    @property
    def width(self) -> float:
        """The width of the widest number, in points."""
        return max((block_of(number, SMALL_LETTERS).width for number in self.numbers), default=0.0)

    @property
    def depth(self) -> float:
        """The room that the numbers take below an abscissa, in points."""
        if not self.has_names:
            return NUMBER.height
        if not any(self.numbers):  # as the names stand below another panel
            return 0.0
        return self.width if self.upright else max(block_of(name, SMALL_LETTERS).height for name in self.numbers)


@dataclass(frozen=True)
class Ruler:
    """The ruler of an axis from low to high, linear or logarithmic; for counts with marks at `whole` numbers alone.

    With `names` it has a place for each of them, 0, 1, ..., and no numbers. A `cut` ruler has its middle there. With
    `steps`, the least of these is that between its numbers for which there is room.
    """

    scale: Literal["linear", "log"]
    low: float
    high: float
    whole: bool = False
    names: tuple[str, ...] = ()
    cut: float | None = None
    steps: tuple[float, ...] = ()

    @staticmethod
    def of_names(names: Sequence[str], downwards: bool = False, least: int = 0) -> Ruler:
        """A ruler with a place for each name, from the left, or from the top down, with room for so many at least."""
        first, last = -0.5, max(len(names), least) - 0.5
        low, high = (last, first) if downwards else (first, last)
        return Ruler("linear", low, high, names=tuple(names))

    @staticmethod
    def around(
        scale: Literal["linear", "log"],
        limits: tuple[float, float] | None,
        values: Sequence[npt.ArrayLike],
        margin: float,
        cut: float | None = None,
        steps: tuple[float, ...] = (),
    ) -> Ruler:
        """A ruler within its limits, or else around all finite numbers that it holds, with a margin at both ends."""
        if limits is not None:
            return Ruler(scale, *limits, cut=cut, steps=steps)
        numbers = np.concatenate([np.ravel(np.asarray(part, dtype=float)) for part in values])
        numbers = numbers[np.isfinite(numbers)]
        low, high = (float(numbers.min()), float(numbers.max())) if numbers.size else (1.0, 10.0)
        if high - low <= 1e-15 * max(abs(low), abs(high)):  # nothing to measure: some room around the only number
            reach = 0.05 * abs(high) or 0.05
            low, high = (low / 10, 10 * high) if scale == "log" else (low - reach, high + reach)
        bare, whole = Ruler(scale, low, high), bool(numbers.size and (numbers == np.round(numbers)).all())
        return Ruler(scale, bare._inverse(-margin), bare._inverse(1 + margin), whole, steps=steps)

    def share(self, numbers: npt.ArrayLike) -> Array:
        """The places of numbers between low (0) and high (1)."""
        low, high, at = map(self.straight, (self.low, self.high, numbers))
        return np.asarray((at - low) / (high - low))

    def ticks(self, most: int, length: float = np.inf) -> Ticks:
        """Marks for as many numbers as there is room, at most 9; all names, on a ruler of a length in points."""
        if self.names:
            each = tuple(float(place) for place in range(len(self.names)))
            room = length / abs(self.high - self.low)
            wide = Ticks(each, self.names, has_names=True).width + 0.5 * SMALL_LETTERS > room
            return Ticks(each, self.names, has_names=True, upright=wide)
        if self.cut is not None:
            return self._cut_ticks(self.cut, most, length)
        formatter = LogFormatterSciNotation() if self.scale == "log" else ScalarFormatter(useMathText=True)
        formatter.create_dummy_axis(minpos=self.low)
        assert formatter.axis is not None  # the line above made it
        formatter.axis.set_view_interval(self.low, self.high)
        places = self._stepped(most) or self._within(_locator(self.scale, most, whole=self.whole))
        numbers = {
            place: plain_number(number) for place, number in zip(places, formatter.format_ticks(places), strict=True)
        }
        power = formatter.get_offset()
        fine = self._within(_locator("log", most, subs=range(2, 10))) if self.scale == "log" else []
        for place, number in zip(fine, formatter.format_ticks(fine), strict=True):
            if number:  # where a logarithmic ruler is short
                numbers[place] = number
        rest = tuple(place for place in fine if place not in numbers)
        if len(numbers) > len(places) and PLAIN[0] <= self.low < self.high <= PLAIN[1]:
            numbers = {place: f"{place:g}" for place in numbers}
        return Ticks(tuple(numbers), tuple(numbers.values()), rest, power)

    def _cut_ticks(self, cut: float, most: int, length: float) -> Ticks:
        """The marks of both parts; of the part behind the cut those whose numbers do not meet another."""
        near, far = (Ruler("linear", *ends).ticks(max(1, most // 2)) for ends in ((self.low, cut), (cut, self.high)))
        kept = dict(zip(near.places, near.numbers, strict=True))
        for place, number in zip(far.places, far.numbers, strict=True):
            reach = extent(number, SMALL_LETTERS).width + SMALL_LETTERS / 2
            if place > cut and float(self.share(place) - self.share(max(kept, default=self.low))) * length > reach:
                kept[place] = number
        return Ticks(tuple(kept), tuple(kept.values()))

    def _stepped(self, most: int) -> list[float]:
        """The multiples of the least of the steps for which there is room; none if all are too small or too large."""
        for step in self.steps:
            first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
            if last - first < min(most, 9):
                return [step * k for k in range(first, last + 1)] if last > first else []
        return []

    def slope(self, at: Array, rate: Array) -> Array:
        """The rate of the place, in shares of the length, of a number that changes at a rate."""
        length = float(self.straight(self.high) - self.straight(self.low))
        return np.asarray(rate / (at * math.log(10)) / length if self.scale == "log" else rate / length)

    def _within(self, locator: Locator) -> list[float]:
        found = np.asarray(locator.tick_values(self.low, self.high))
        share = self.share(found)
        return [float(place) for place in found[(share > -1e-9) & (share < 1 + 1e-9)]]

    def straight(self, numbers: npt.ArrayLike) -> Array:
        """Numbers in the unit in which the ruler is even."""
        at = np.log10(numbers) if self.scale == "log" else np.asarray(numbers, dtype=float)
        if self.cut is None:
            return at
        slope = (self.cut - self.low) / (self.high - self.cut)
        return np.asarray(np.where(at > self.cut, self.cut + slope * (at - self.cut), at))

    def _inverse(self, share: float) -> float:
        low, high = self.straight(self.low), self.straight(self.high)
        at = float(low + share * (high - low))
        return 10.0**at if self.scale == "log" else at


def _locator(scale: str, most: int, subs: Sequence[float] = (1.0,), whole: bool = False) -> Locator:
    most = max(1, min(most, 9))
    if scale == "log":
        return LogLocator(subs=subs, numticks=max(2, most))
    return MaxNLocator(nbins=most, steps=[1, 2, 2.5, 5, 10], integer=whole)


def rulers(figure: Figure, i: int, curves: Sequence[tuple[Array, ...]]) -> tuple[Ruler, Ruler]:
    """The rulers of panel i, whose curves have these points; names that stand beside another panel are left out."""
    panel = figure.panels[i]
    # the drawn points of curves, and all numbers of other marks
    held = [(c[:1], c[1:]) if c else mark.spans for c, mark in zip(curves, panel.series, strict=True)]
    margin = 0.05 if any(map(_has_margin, panel.series)) else 0.0
    if panel.xnames:
        least = 1 if any(isinstance(mark, Tiles) for mark in panel.series) else COLUMNS
        x = Ruler.of_names(_column_names(figure, i), least=least)
    else:
        across = [part for span, _ in held for part in span]
        x = Ruler.around(panel.xscale, panel.xlim, [*across, panel.vlines], margin, panel.xcut, panel.xsteps)
    if panel.ynames:
        beside = shares_rows(figure) and column_of(figure, i)
        y = Ruler.of_names(("",) * len(panel.ynames) if beside else row_names(figure, panel), downwards=True)
    else:
        upwards = [part for _, up in held for part in up]
        y = Ruler.around(panel.yscale, panel.ylim, [*upwards, panel.hlines], 0.05, steps=panel.ysteps)
    return x, y


def _has_margin(mark: Mark) -> bool:
    return isinstance(mark, Bars | Points) or (isinstance(mark, Series) and mark.look in ("marks", "dots"))


def row_names(figure: Figure, panel: Panel) -> tuple[str, ...]:
    """The names of a panel's rows, folded to the room that they may take."""
    share = MAX_NAME_WIDTH if shares_rows(figure) else MAX_NAME_WIDTH / figure.columns
    return tuple(_folded(label, share * figure.width) for label in panel.ynames)


def _column_names(figure: Figure, i: int) -> Sequence[str]:
    """The names of a panel's columns: side by side if their words have the room; of tiles on each panel.

    Columns of other marks that go on in the panel below have their names there alone.
    """
    panel, under = figure.panels[i], below(figure, i)
    tiled = any(isinstance(mark, Tiles) for mark in panel.series)
    if under is not None and str(under.xnames) == str(panel.xnames) and shares_rows(figure) and not tiled:
        return ("",) * len(panel.xnames)
    across = 1 if figure.lead and not i else figure.columns
    beside = max((block_of(name, SMALL_LETTERS).width for name in row_names(figure, panel)), default=0.0) + BESIDE
    room = (72 * WIDTH * figure.width - beside) / across / len(panel.xnames) - 0.75 * SMALL_LETTERS
    names = [mathtext(label) for label in panel.xnames]
    widest = max(extent(word, SMALL_LETTERS).width for name in names for word in name.split() or [""])
    if len(names) >= COLUMNS and widest <= room:
        return [fold_label(name, SMALL_LETTERS, room) for name in names]
    return [_folded(label, UPRIGHT * figure.width) for label in panel.xnames]


def _folded(label: Label, share: float) -> str:
    return fold_label(mathtext(label), SMALL_LETTERS, share * 72 * WIDTH)


def size_of(figure: Figure) -> tuple[float, float]:
    """Width and height of a figure in inches."""
    if figure.lead:
        return WIDTH * figure.width, min(sum(panel_heights(figure)) + 0.35, TALL)
    rows = -(-len(figure.panels) // figure.columns)
    height = {1: 2.4, 2: 2.0, 3: 1.8}[figure.columns] * {1: 1.0, 2: 0.86}.get(rows, 0.74)
    if any(panel.aspect in ("tall", "equal") for panel in figure.panels):
        height = PLANE[figure.columns] * math.sqrt(figure.width)  # a narrow one is lower, too
    elif any(isinstance(mark, Points) for panel in figure.panels if panel.aspect != "wide" for mark in panel.series):
        height *= 1.4  # names need room
    named = [_rows_of(row_names(figure, panel), panel) for panel in figure.panels if panel.ynames]
    return WIDTH * figure.width, min(rows * max(named, default=height) + 0.35, TALL)


def panel_heights(figure: Figure) -> tuple[float, float]:
    """The heights of the panel that leads and of all the others, in inches."""
    lead, *others = (_rows_of(row_names(figure, panel), panel) for panel in figure.panels)
    rows = -(-len(others) // figure.columns)
    return lead, rows * max(others, default=0.0)


def _rows_of(names: tuple[str, ...], panel: Panel) -> float:
    if lines := max((mark.lines for mark in panel.series if isinstance(mark, Tiles)), default=0):
        return AROUND + len(names) * (TILE + TILE_LINE * lines)
    lines = max(name.count("\n") + 1 for name in names)
    return AROUND + len(names) * max(ROW, LINE * lines, min(MOST, FEW / len(names)))
