"""Figures in one style, readable in black and white, and the only door to matplotlib.

The room knows a figure's data and the looks of it; it knows nothing of studies. `figure_sheet` draws the figures of a
report with the pen and is to be read first; `runs` draws trajectories by matplotlib's axes, for a notebook.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from workbench.report.table_text import to_csv
from workbench.study.document.document import Document

if TYPE_CHECKING:
    from workbench.report.figures.plates import FigureSheet


def sheets(document: Document) -> dict[str, FigureSheet]:
    """Each figure by its name: its SVG text, and the plate from which a script draws its curves again."""
    from workbench.report.figures.figure_sheet import (
        draw_all,  # with matplotlib, which takes longer than all else to import
    )

    return draw_all(document.figures)


def drawings(document: Document) -> dict[str, str]:
    """The SVG text of each figure by its name."""
    return {name: sheet.svg for name, sheet in sheets(document).items()}


def numbers_of(document: Document) -> dict[str, str]:
    """The numbers of each figure as CSV, by its name: its own table, or those of its curves, bars and points."""
    from workbench.report.figures.figure_csv import figure_csv

    texts = {f.name: figure_csv(f) if f.numbers is None else to_csv(f.numbers) for f in document.figures}
    return {name: text for name, text in texts.items() if text}
