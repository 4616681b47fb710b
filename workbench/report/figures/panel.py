"""What a panel shows, drawn by the pen: its rulers with their marks and numbers, and its curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.report.figures.labels import NUMBER, extent
from workbench.report.figures.looks import LINES, MARKS, PAD, RULES, SMALL_LETTERS, TICK, layer_of, line_of
from workbench.report.figures.pen import Box, Pen
from workbench.report.figures.ruler import Ruler, Ticks
from workbench.study.curves import Array, Band, Panel, Series

GRID = {"color": RULES["grid.color"], "linewidth": RULES["grid.linewidth"]}
RULED = {"color": "#555555", "linewidth": 0.6}
AXIS = {"color": "#000000", "linewidth": RULES["axes.linewidth"]}
MARK = {"color": "#000000", "linewidth": RULES["xtick.major.width"]}
FINE = {"color": "#000000", "linewidth": RULES["xtick.minor.width"]}
DIGIT = 0.676 * SMALL_LETTERS  # the height of a digit


def draw_axes(pen: Pen, box: Box, x: tuple[Ruler, Ticks], y: tuple[Ruler, Ticks]) -> None:
    """The grid, the two axes, their marks, and the numbers at them."""
    across, up = _along(box, *x), _along(box, *y, upwards=True)
    left, right, bottom, top = box.left, box.left + box.width, box.bottom, box.bottom + box.height
    _strokes(pen, across[0], across[0], bottom, top, GRID)
    _strokes(pen, left, right, up[0], up[0], GRID)
    pen.line(np.array([left, left, right]), np.array([top, bottom, bottom]), AXIS)
    _strokes(pen, across[0], across[0], bottom - TICK, bottom, MARK)
    _strokes(pen, left - TICK, left, up[0], up[0], MARK)
    _strokes(pen, across[1], across[1], bottom - 2 * TICK / 3, bottom, FINE)
    _strokes(pen, left - 2 * TICK / 3, left, up[1], up[1], FINE)
    for at, number in zip(across[0], x[1].numbers, strict=True):
        width = extent(number, SMALL_LETTERS).width
        pen.words(number, at - width / 2, bottom - TICK - PAD - NUMBER.ascent, SMALL_LETTERS)
    for at, number in zip(up[0], y[1].numbers, strict=True):
        width = extent(number, SMALL_LETTERS).width
        pen.words(number, left - TICK - PAD - width, at - DIGIT / 2, SMALL_LETTERS)
    pen.words(y[1].power, left, top + 3, SMALL_LETTERS)
    power = extent(x[1].power, SMALL_LETTERS)
    pen.words(x[1].power, right - power.width, bottom - TICK - PAD - NUMBER.height - 3 - power.ascent, SMALL_LETTERS)


def _along(box: Box, ruler: Ruler, ticks: Ticks, upwards: bool = False) -> tuple[Array, Array]:
    """Where the marks and the fine marks of a ruler are, in points."""
    start, length = (box.bottom, box.height) if upwards else (box.left, box.width)
    return start + length * ruler.share(ticks.places), start + length * ruler.share(ticks.minor)


def _strokes(
    pen: Pen, x0: Array | float, x1: Array | float, y0: Array | float, y1: Array | float, look: dict[str, object]
) -> None:
    """Many strokes of one look, from (x0, y0) to (x1, y1)."""
    ends = np.broadcast_arrays(x0, x1, np.nan, y0, y1, np.nan)
    x, y = np.column_stack(ends[:3]).ravel(), np.column_stack(ends[3:]).ravel()
    if x.size:
        pen.line(x, y, look)


def draw_curves(pen: Pen, box: Box, panel: Panel, curves: Sequence[tuple[Array, ...]], x: Ruler, y: Ruler) -> None:
    """The thin lines across the panel, and its series in their layers."""

    def placed(across: Array, up: Array) -> tuple[Array, Array]:
        return box.left + box.width * x.share(across), box.bottom + box.height * y.share(up)

    for at in panel.hlines:
        pen.line(*placed(np.array([x.low, x.high]), np.array([at, at])), RULED, box)
    for at in panel.vlines:
        pen.line(*placed(np.array([at, at]), np.array([y.low, y.high])), RULED, box)
    layers = []
    for i, (series, curve) in enumerate(zip(panel.series, curves, strict=True)):
        layer = layer_of(i, panel) - (0.9 if isinstance(series, Band) else 0.0)
        layers.append((layer, i, series, [placed(curve[0], ordinate) for ordinate in curve[1:]], curve[1]))
    for _, _, series, lines, ordinates in sorted(layers, key=lambda held: held[:2]):
        if isinstance(series, Band):
            _draw_band(pen, series, lines, box)
        else:
            _draw_series(pen, series, lines[0], ordinates, box)


def _draw_series(pen: Pen, series: Series, line: tuple[Array, Array], ordinates: Array, box: Box) -> None:
    x, y = line
    if series.look == "marks":
        pen.marks(x, y, LINES[series.style] | MARKS, box)
        return
    if series.look == "steps":
        x, y = np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]
    pen.line(x, y, line_of(series, ordinates), box)


def _draw_band(pen: Pen, band: Band, lines: list[tuple[Array, Array]], box: Box) -> None:
    (x, low), (_, high) = lines
    look = LINES[band.style]
    pen.area(np.concatenate([x, x[::-1]]), np.concatenate([low, high[::-1]]), look["color"], 0.22, box)
    for edge in (low, high):
        pen.line(x, edge, look | {"linewidth": 0.5}, box)


def draw_sample(pen: Pen, series: Series | Band, box: Box) -> None:
    """How a series looks, for the legend."""
    ends, middle = np.array([box.left, box.left + box.width]), np.full(2, box.bottom + box.height / 2)
    look = LINES[series.style]
    if isinstance(series, Band):
        x, y = np.repeat(ends, 2), box.bottom + box.height * np.array([0.0, 1.0, 1.0, 0.0])
        pen.area(x, y, look["color"], 0.3)
    elif series.look == "marks":
        pen.marks(ends[:1] + box.width / 2, middle[:1], look | MARKS)
    else:
        pen.line(ends, middle, look)
