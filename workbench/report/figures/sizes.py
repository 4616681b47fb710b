"""How large a figure is: as tall as its rows and their names need, if a page has the room."""

from __future__ import annotations

from workbench.report.figures.looks import WIDTH
from workbench.report.figures.rulers import row_names
from workbench.study.document.document import Figure
from workbench.study.document.panel import Panel
from workbench.study.document.shapes import Points, Tiles

ROW, LINE = 0.19, 0.125  # inches: the least of a named row, and of each line of its name
MOST, FEW = 0.3, 2.0  # inches: the most of a named row, and what few of them share
TILE, TILE_LINE = 0.06, 0.082  # inches: the edges of a tile, and each line of its text
AROUND = 0.6  # inches: what stands above and below rows
TALL = 7.6  # inches that a page has for a figure beside its caption


def size_of(figure: Figure) -> tuple[float, float]:
    """Width and height of a figure in inches."""
    if figure.lead:
        return WIDTH, min(sum(led(figure)) + 0.35, TALL)
    rows = -(-len(figure.panels) // figure.columns)
    height = {1: 2.4, 2: 2.0, 3: 1.8}[figure.columns] * (1 if rows == 1 else 0.86)
    if any(isinstance(mark, Points) for panel in figure.panels for mark in panel.series):
        height *= 1.4  # names need room
    named = [_rows_of(row_names(figure, panel), panel) for panel in figure.panels if panel.ynames]
    return WIDTH, min(rows * max(named, default=height) + 0.35, TALL)


def led(figure: Figure) -> tuple[float, float]:
    """The heights of the panel that leads and of all the others, in inches."""
    lead, *others = (_rows_of(row_names(figure, panel), panel) for panel in figure.panels)
    rows = -(-len(others) // figure.columns)
    return lead, rows * max(others, default=0.0)


def _rows_of(names: tuple[str, ...], panel: Panel) -> float:
    if lines := max((mark.lines for mark in panel.series if isinstance(mark, Tiles)), default=0):
        return AROUND + len(names) * (TILE + TILE_LINE * lines)
    lines = max(name.count("\n") + 1 for name in names)
    return AROUND + len(names) * max(ROW, LINE * lines, min(MOST, FEW / len(names)))
