"""A panel drawn by the pen: its rulers with their marks and numbers, and its marks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.report.figures.boxes import draw_bars, draw_tiles, fill_box
from workbench.report.figures.pen import DIGIT, NUMBER, Pen, Rectangle, extent
from workbench.report.figures.plane import draw_area, draw_arrows, draw_guides
from workbench.report.figures.points import draw_points
from workbench.report.figures.rulers import Ruler, Ticks
from workbench.report.figures.style import (
    LINES,
    PAD,
    POINTED,
    POINTS_LOOK,
    SHAPES,
    SMALL_LETTERS,
    TICK,
    LineStyle,
    layer_of,
    line_of,
)
from workbench.study.document.figure import Area, Arrows, Band, Bars, Guides, Mark, Panel, Points, Series, Tiles

GRID: LineStyle = {"color": "#dddddd", "linewidth": 0.4}
RULE_STYLE: LineStyle = {"color": "#555555", "linewidth": 0.6}
CUT: LineStyle = {"color": "#777777", "linewidth": 0.5, "linestyle": (0, (3, 3))}
AXIS: LineStyle = {"color": "#000000", "linewidth": 0.5}
MARK = AXIS
FINE: LineStyle = {"color": "#000000", "linewidth": 0.4}
HALF = DIGIT * SMALL_LETTERS / 2  # of the height of a digit


def draw_axes(pen: Pen, box: Rectangle, i: int, x: tuple[Ruler, Ticks], y: tuple[Ruler, Ticks]) -> None:
    """The grid, the two axes, their marks, and the numbers at them, of panel i: what a ruler has in its own groups."""
    across, up = _along(box, *x), _along(box, *y, upwards=True)
    left, right, bottom, top = box.left, box.left + box.width, box.bottom, box.bottom + box.height
    none = np.zeros(0)  # a name has no mark and no line of the grid
    across, up = (none if x[1].has_names else across[0], across[1]), (none if y[1].has_names else up[0], up[1])
    with pen.group("ruler-x", i):
        _strokes(pen, across[0], across[0], bottom, top, GRID)
    with pen.group("ruler-y", i):
        _strokes(pen, left, right, up[0], up[0], GRID)
    if not x[1].has_names:
        pen.line(np.array([left, left, right]), np.array([top, bottom, bottom]), AXIS)
    if x[0].cut is not None:
        _draw_cut(pen, box)
    with pen.group("ruler-x", i):
        _strokes(pen, across[0], across[0], bottom - TICK, bottom, MARK)
        _strokes(pen, across[1], across[1], bottom - 2 * TICK / 3, bottom, FINE)
        _write_below(pen, box, *x)
        power = extent(x[1].power, SMALL_LETTERS)
        foot = bottom - TICK - PAD - NUMBER.height - 3 - power.ascent
        pen.words(x[1].power, right - power.width, foot, SMALL_LETTERS)
    with pen.group("ruler-y", i):
        _strokes(pen, left - TICK, left, up[0], up[0], MARK)
        _strokes(pen, left - 2 * TICK / 3, left, up[1], up[1], FINE)
        _write_beside(pen, box, *y)
        pen.words(y[1].power, left, top + 3, SMALL_LETTERS)


def _draw_cut(pen: Pen, box: Rectangle) -> None:
    """A dashed line, and two strokes across the axis, where the scale of a cut abscissa changes."""
    middle, half = box.left + box.width / 2, TICK * np.array([-0.6, 0.6])
    pen.line(np.array([middle, middle]), np.array([box.bottom, box.bottom + box.height]), CUT)
    for beside in (-1.0, 1.0):
        pen.line(middle + beside + half / 2, box.bottom + half, AXIS)


def _write_below(pen: Pen, box: Rectangle, ruler: Ruler, ticks: Ticks) -> None:
    """The numbers or names at an abscissa."""
    head = box.bottom - TICK - PAD
    for at, number in zip(_along(box, ruler, ticks)[0], ticks.numbers, strict=True):
        lines = number.split("\n")
        for k, line in enumerate(lines):
            width = extent(line, SMALL_LETTERS).width
            if ticks.upright:
                beside = at + HALF + (k - (len(lines) - 1) / 2) * NUMBER.height
                pen.words(line, beside, head - width, SMALL_LETTERS, upwards=True)
            else:
                pen.words(line, at - width / 2, head - NUMBER.ascent - k * NUMBER.height, SMALL_LETTERS)


def _write_beside(pen: Pen, box: Rectangle, ruler: Ruler, ticks: Ticks) -> None:
    """The numbers or names at an ordinate."""
    for at, number in zip(_along(box, ruler, ticks, upwards=True)[0], ticks.numbers, strict=True):
        lines = number.split("\n")
        for k, line in enumerate(lines):
            foot = at - HALF + ((len(lines) - 1) / 2 - k) * NUMBER.height
            pen.words(line, box.left - TICK - PAD - extent(line, SMALL_LETTERS).width, foot, SMALL_LETTERS)


def _along(box: Rectangle, ruler: Ruler, ticks: Ticks, upwards: bool = False) -> tuple[Array, Array]:
    """The places of the marks and the fine marks of a ruler, in points."""
    start, length = (box.bottom, box.height) if upwards else (box.left, box.width)
    return start + length * ruler.share(ticks.places), start + length * ruler.share(ticks.minor)


def _strokes(
    pen: Pen, x0: Array | float, x1: Array | float, y0: Array | float, y1: Array | float, look: LineStyle
) -> None:
    """Many strokes of one look, from (x0, y0) to (x1, y1)."""
    ends = np.broadcast_arrays(x0, x1, np.nan, y0, y1, np.nan)
    x, y = np.column_stack(ends[:3]).ravel(), np.column_stack(ends[3:]).ravel()
    if x.size:
        pen.line(x, y, look)


def draw_curves(
    pen: Pen, box: Rectangle, i: int, panel: Panel, curves: Sequence[tuple[Array, ...]], x: Ruler, y: Ruler
) -> None:
    """The thin lines across panel i, and its series in their layers, each curve in a group of its own."""
    across = [box.at(x.share([x.low, x.high]), y.share([at, at])) for at in panel.hlines]
    upright = [box.at(x.share([at, at]), y.share([y.low, y.high])) for at in panel.vlines]
    for name, ruled in (("hlines", across), ("vlines", upright)):
        if ruled:
            with pen.group(name, i):
                for line in ruled:
                    pen.line(*line, RULE_STYLE, box)
    drawn = [[box.at(x.share(curve[0]), y.share(ordinate)) for ordinate in curve[1:]] for curve in curves]
    for j in sorted(range(len(panel.series)), key=lambda j: (layer_of(j, panel), j)):
        lines = drawn[j]
        match panel.series[j]:
            case Band() as band:
                with pen.group("series", i, j):
                    _draw_band(pen, band, lines, box)
            case Series() as series:
                with pen.group("series", i, j):
                    _draw_series(pen, series, lines[0], curves[j][1], box)
            case Bars() as bars:
                with pen.group("marks", i, j):
                    draw_bars(pen, box, bars, x, y)
            case Points() as points:
                with pen.group("marks", i, j):
                    draw_points(pen, box, points, x, y, [*across, *upright, *(line for held in drawn for line in held)])
            case Tiles() as tiles:
                draw_tiles(pen, box, tiles, x, y)
            case Area() as area:
                with pen.group("series", i, j):
                    draw_area(pen, box, area, x, y)
            case Arrows() as arrows:
                with pen.group("marks", i, j):
                    draw_arrows(pen, box, arrows, x, y)
            case Guides() as guides:
                dots = [box.at(x.share(mark.x), y.share(mark.y)) for mark in panel.series if isinstance(mark, Points)]
                draw_guides(pen, box, (i, j), guides, x, y, [line for held in drawn for line in held], dots)


def _draw_series(pen: Pen, series: Series, line: tuple[Array, Array], ordinates: Array, box: Rectangle) -> None:
    x, y = line
    if series.look in POINTED:
        pen.marks(x, y, LINES[series.style] | POINTED[series.look], box)
        return
    if series.look == "steps":
        x, y = np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]
    pen.line(x, y, line_of(series, ordinates), box)


def _draw_band(pen: Pen, band: Band, lines: list[tuple[Array, Array]], box: Rectangle) -> None:
    (x, low), (_, high) = lines
    look = LINES[band.style]
    pen.area(np.concatenate([x, x[::-1]]), np.concatenate([low, high[::-1]]), look["color"], 0.22, box)
    for edge in (low, high):
        pen.line(x, edge, look | {"linewidth": 0.5}, box)


def draw_sample(pen: Pen, series: Mark, box: Rectangle) -> None:
    """A small sample of a series, for the legend."""
    look, (x, y) = LINES[series.style], box.at(np.array([0.0, 0.5, 1.0]), np.full(3, 0.5))
    if isinstance(series, Tiles):
        x_of, y_of = (Ruler.of_names(("",) * size) for size in np.shape(series.shades)[::-1])
        draw_tiles(pen, box, series, x_of, y_of)
    elif isinstance(series, Area):
        pen.area(*box.corners, look["color"], 0.3)
    elif isinstance(series, Band):
        pen.area(np.repeat(x[::2], 2), box.bottom + box.height * np.array([0.0, 1.0, 1.0, 0.0]), look["color"], 0.3)
    elif isinstance(series, Bars):
        fill_box(pen, *box.edges, series.style, series.shade)
    elif isinstance(series, Points):
        pen.marks(x[1:2], y[1:2], look | POINTS_LOOK | SHAPES[series.shape])
    elif isinstance(series, Series) and series.look in POINTED:
        pen.marks(x[1:2], y[1:2], look | POINTED[series.look])
    else:
        pen.line(x[::2], y[::2], look)
