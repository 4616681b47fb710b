"""A figure drawn on a sheet: the legend, below it the panels, as large as the letters around them allow.

Matplotlib makes letters and lines, and says where the marks of a ruler are; its axes would take ten times as long.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from workbench.core.validation.refusals import Array
from workbench.report.figures.axes import draw_axes, draw_curves, draw_sample
from workbench.report.figures.curves import drawn_points
from workbench.report.figures.pen import Pen, Rectangle, extent, mathtext
from workbench.report.figures.plates import FigureSheet, plate_of
from workbench.report.figures.rulers import Ruler, Ticks, panel_heights, rulers, size_of
from workbench.report.figures.style import (
    LABEL,
    LEGEND_LETTERS,
    LETTERS,
    PAD,
    SMALL_LETTERS,
    TICK,
    TITLE,
    below,
    house_style,
    letter_of,
    said_on_axis,
    shares_abscissa,
)
from workbench.study.document.figure import Figure, Mark, Panel, Tiles

EDGE = 4.0  # points around each panel with all its letters
ROUNDS = 2  # of laying out: the numbers at a ruler depend on its length, which depends on those numbers


@dataclass(frozen=True)
class Pane:
    """A panel as it will be drawn: its thinned curves, its rulers, its title and its labels."""

    panel: Panel
    curves: tuple[tuple[Array, ...], ...]
    x: Ruler
    y: Ruler
    title: str
    xlabel: str
    ylabel: str


def draw(figure: Figure) -> str:
    """A figure as an SVG, the same bytes on every machine: letters are outlines, and ids begin with its name."""
    return draw_all([figure])[figure.name].svg


def draw_all(figures: Iterable[Figure]) -> dict[str, FigureSheet]:
    """Figures by their names, as `draw` makes them, each with its plate."""
    with house_style():
        return {figure.name: _draw(figure) for figure in figures}


def _draw(figure: Figure) -> FigureSheet:
    width, height = (72 * inches for inches in size_of(figure))
    pen = Pen(width, height)
    pen.area(*Rectangle(0.0, 0.0, width, height).corners, "#ffffff")
    head = _draw_legend(pen, figure, width, height)
    panes = [_pane(figure, i) for i in range(len(figure.panels))]
    placed = list(_placed(figure, panes, width, height - head))
    for i, (pane, box, ticks) in enumerate(placed):
        draw_axes(pen, box, i, (pane.x, ticks[0]), (pane.y, ticks[1]))
        draw_curves(pen, box, i, pane.panel, pane.curves, pane.x, pane.y)
        _write_labels(pen, pane, box, ticks)
    panels = ((pane.panel, box, pane.x, pane.y, ticks) for pane, box, ticks in placed)
    return FigureSheet(pen.svg_text(figure.name), plate_of(figure, width, height, panels))


def _pane(figure: Figure, i: int) -> Pane:
    panel = figure.panels[i]
    curves = tuple(drawn_points(mark, panel, figure) for mark in panel.series)
    return Pane(
        panel,
        curves,
        *rulers(figure, i, curves),
        f"{letter_of(figure, i)} {mathtext(panel.title)}".strip(),
        mathtext(said_on_axis(panel)) if below(figure, i) is None or not shares_abscissa(figure) else "",
        mathtext(panel.ylabel),
    )


def _placed(
    figure: Figure, panes: Sequence[Pane], width: float, height: float
) -> Iterator[tuple[Pane, Rectangle, tuple[Ticks, Ticks]]]:
    """Each pane with its box and the marks of its rulers: the one that leads stands above all others."""
    lead, others = panel_heights(figure) if figure.lead else (0.0, 1.0)
    foot = height * others / (lead + others)
    if figure.lead:
        for pane, box, ticks in _laid_out(panes[:1], 1, width, height - foot):
            yield pane, replace(box, bottom=box.bottom + foot), ticks
    if rest := panes[figure.lead :]:
        yield from _laid_out(rest, figure.columns, width, foot)


def _laid_out(
    panes: Sequence[Pane], columns: int, width: float, height: float
) -> list[tuple[Pane, Rectangle, tuple[Ticks, Ticks]]]:
    """Each pane with its box and the marks of its rulers, all boxes of one size."""
    rows, given = -(-len(panes) // columns), panes
    w, h = width / columns, height / rows
    for _ in range(ROUNDS):
        panes = [_even(pane, w, h) for pane in given]
        ticks = [(p.x.ticks(int(w / (3 * SMALL_LETTERS)), w), p.y.ticks(int(h / (2 * SMALL_LETTERS)))) for p in panes]
        held = list(zip(panes, ticks, strict=True))
        left = [max((_left(p, t[1]) for p, t in held[j::columns]), default=0.0) for j in range(columns)]
        right = [max((_right(p, t[0], w) for p, t in held[j::columns]), default=0.0) for j in range(columns)]
        above = [max(_above(p, t[1]) for p, t in held[i * columns : (i + 1) * columns]) for i in range(rows)]
        under = [max(_below(p, t[0]) for p, t in held[i * columns : (i + 1) * columns]) for i in range(rows)]
        w = max(1.0, (width - sum(left) - sum(right)) / columns)
        h = max(1.0, (height - sum(above) - sum(under)) / rows)
    placed = []
    for k, (pane, marks) in enumerate(held):
        if pane.panel.aspect == "equal":
            pane = _even(given[k], w, h)
            marks = pane.x.ticks(int(w / (3 * SMALL_LETTERS)), w), pane.y.ticks(int(h / (2 * SMALL_LETTERS)))
        i, j = divmod(k, columns)
        start = sum(left[: j + 1]) + sum(right[:j]) + j * w
        foot = sum(under[i:]) + sum(above[i + 1 :]) + (rows - 1 - i) * h
        placed.append((pane, Rectangle(start, foot, w, h), marks))
    return placed


def _even(pane: Pane, width: float, height: float) -> Pane:
    """A pane whose axes are equal with the shorter range widened to both sides, for a box of this size in points."""
    if pane.panel.aspect != "equal":
        return pane
    ranges = [(pane.x, width), (pane.y, height)]
    unit = max((ruler.high - ruler.low) / length for ruler, length in ranges)
    x, y = (_widened(ruler, unit * length) for ruler, length in ranges)
    return replace(pane, x=x, y=y)


def _widened(ruler: Ruler, reach: float) -> Ruler:
    middle = (ruler.low + ruler.high) / 2
    return replace(ruler, low=middle - reach / 2, high=middle + reach / 2)


def _left(pane: Pane, ticks: Ticks) -> float:
    label = LABEL + extent(pane.ylabel, LETTERS).height if pane.ylabel else 0.0
    return EDGE + label + ticks.width + PAD + TICK


def _right(pane: Pane, ticks: Ticks, width: float) -> float:
    """The length by which the last number stands out beyond the end of its ruler."""
    last = extent(ticks.numbers[-1], SMALL_LETTERS).width if ticks.numbers and not ticks.has_names else 0.0
    return EDGE + max(0.0, last / 2 - width * float(1 - pane.x.share(ticks.places[-1:]).sum()))


def _above(pane: Pane, ticks: Ticks) -> float:
    title = TITLE + extent(pane.title, LETTERS).ascent if pane.title else 0.0
    return EDGE + title + _lift(ticks)


def _lift(ticks: Ticks) -> float:
    """The height by which a title stands clear of the power of ten at the ordinate."""
    return 3 + extent(ticks.power, SMALL_LETTERS).ascent if ticks.power else 0.0


def _below(pane: Pane, ticks: Ticks) -> float:
    named = LABEL + extent(pane.xlabel or ticks.power, LETTERS).height if pane.xlabel or ticks.power else 0.0
    return TICK + PAD + ticks.depth + named + EDGE / 2


def _write_labels(pen: Pen, pane: Pane, box: Rectangle, ticks: tuple[Ticks, Ticks]) -> None:
    under, beside = extent(pane.xlabel, LETTERS), extent(pane.ylabel, LETTERS)
    foot = box.bottom - TICK - PAD - ticks[0].depth - LABEL - under.ascent
    pen.words(pane.xlabel, box.left + (box.width - under.width) / 2, foot, LETTERS)
    edge = box.left - TICK - PAD - ticks[1].width - LABEL - beside.descent
    pen.words(pane.ylabel, edge, box.bottom + (box.height - beside.width) / 2, LETTERS, upwards=True)
    pen.words(pane.title, box.left, box.bottom + box.height + TITLE + _lift(ticks[1]), LETTERS)


def _draw_legend(pen: Pen, figure: Figure, width: float, height: float) -> float:
    """The legend at the top of the sheet, row by row; returns its height in points."""
    names = _entries(figure)
    if not names:
        return 0.0
    size, columns = LEGEND_LETTERS, _across(names, width / 72)
    handle, gap, between = 2.8 * size, 0.5 * size, 1.3 * size
    widths = [max(extent(name, size).width for name in list(names)[j::columns]) for j in range(columns)]
    line = max(extent(name, size).height for name in names) + 0.5 * size
    start = (width - sum(widths) - columns * (handle + gap) - (columns - 1) * between) / 2
    for k, (name, series) in enumerate(names.items()):
        i, j = divmod(k, columns)
        x = start + sum(widths[:j]) + j * (handle + gap + between)
        y = height - 0.6 * size - i * line - extent(name, size).ascent
        draw_sample(pen, series, Rectangle(x, y, handle, 0.7 * size))
        pen.words(name, x + handle + gap, y, size)
    return 0.6 * size + -(-len(names) // columns) * line


def _entries(figure: Figure) -> dict[str, Mark]:
    """Each name with the first series of that name, but for names that the title of a panel has."""
    found: dict[str, Mark] = {}
    for panel in figure.panels:
        for series in panel.series:
            for mark in series.keys if isinstance(series, Tiles) and series.keys else (series,):
                if mark.label and mark.label != panel.title:
                    found.setdefault(mathtext(mark.label), mark)
    return found


def _across(names: dict[str, Mark], width: float) -> int:
    """The number of names side by side in the legend of a figure of a width in inches."""
    letters = [len(re.sub(r"[\\${}]", "", name)) for name in names]
    rows = -(-sum(0.065 * n + 0.5 for n in letters) // width)
    return -(-len(names) // int(rows))
