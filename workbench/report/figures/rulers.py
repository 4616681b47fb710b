"""The two rulers of a panel: around all that it shows, or with the names of its columns and rows."""

from __future__ import annotations

from collections.abc import Sequence

from workbench.report.figures.labels import block_of, extent, folded, written
from workbench.report.figures.looks import NAMED, SMALL_LETTERS, WIDTH, below, column_of, shares_rows
from workbench.report.figures.ruler import Ruler
from workbench.study.document.curves import Array, Label, Series
from workbench.study.document.document import Figure
from workbench.study.document.panel import Panel
from workbench.study.document.shapes import Bars, Points, Spans, Tiles

COLUMNS = 8  # that a panel has the room for: the cells of fewer are no wider
BESIDE = 20.0  # points: the edges of a panel
UPRIGHT = 0.24  # of a figure's width: the longest line of a name below a column


def rulers(figure: Figure, i: int, curves: Sequence[tuple[Array, ...]]) -> tuple[Ruler, Ruler]:
    """Those of panel i, whose curves have these points; names that stand beside another panel are left out."""
    panel = figure.panels[i]
    held = [_held(curve, mark.spans) for curve, mark in zip(curves, panel.series, strict=True)]
    margin = 0.05 if any(_has_margin(mark) for mark in panel.series) else 0.0
    if panel.xnames:
        least = 1 if any(isinstance(mark, Tiles) for mark in panel.series) else COLUMNS
        x = Ruler.of_names(_column_names(figure, i), least=least)
    else:
        x = Ruler.around(
            panel.xscale, panel.xlim, [*(part for across, _ in held for part in across), panel.vlines], margin
        )
    if panel.ynames:
        beside = shares_rows(figure) and column_of(figure, i)
        y = Ruler.of_names(("",) * len(panel.ynames) if beside else row_names(figure, panel), downwards=True)
    else:
        y = Ruler.around(panel.yscale, panel.ylim, [*(part for _, up in held for part in up), panel.hlines], 0.05)
    return x, y


def row_names(figure: Figure, panel: Panel) -> tuple[str, ...]:
    """The names of a panel's rows, folded to the room that they may take."""
    share = NAMED if shares_rows(figure) else NAMED / figure.columns
    return tuple(_folded(label, share) for label in panel.ynames)


def _column_names(figure: Figure, i: int) -> Sequence[str]:
    """The names of a panel's columns: side by side if their words have the room, and once where columns go on below."""
    panel, under = figure.panels[i], below(figure, i)
    if under is not None and str(under.xnames) == str(panel.xnames) and shares_rows(figure):
        return ("",) * len(panel.xnames)
    across = 1 if figure.lead and not i else figure.columns
    beside = max((block_of(name, SMALL_LETTERS).width for name in row_names(figure, panel)), default=0.0) + BESIDE
    room = (72 * WIDTH - beside) / across / len(panel.xnames) - 0.75 * SMALL_LETTERS
    names = [written(label) for label in panel.xnames]
    widest = max(extent(word, SMALL_LETTERS).width for name in names for word in name.split() or [""])
    if len(names) >= COLUMNS and widest <= room:
        return [folded(name, SMALL_LETTERS, room) for name in names]
    return [_folded(label, UPRIGHT) for label in panel.xnames]


def _held(curve: tuple[Array, ...], spans: Spans) -> Spans:
    """What the rulers must hold: the points that are drawn of a curve, all of what is no curve."""
    return (curve[:1], curve[1:]) if curve else spans


def _has_margin(mark: object) -> bool:
    return isinstance(mark, Bars | Points) or (isinstance(mark, Series) and mark.look == "marks")


def _folded(label: Label, share: float) -> str:
    return folded(written(label), SMALL_LETTERS, share * 72 * WIDTH)
