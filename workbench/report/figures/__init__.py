"""Figures in one style, readable in black and white, and the only door to matplotlib.

The room knows a figure's data and the looks of it; it knows nothing of studies. `figure_sheet` draws the figures of a
report with the pen and is to be read first; `runs` draws trajectories by matplotlib's axes, for a notebook.
"""

from __future__ import annotations

from workbench.study.document.document import Document


def drawings(document: Document) -> dict[str, str]:
    """The SVG text of each figure by its name."""
    from workbench.report.figures.figure_sheet import (
        draw_all,  # with matplotlib, which takes longer than all else to import
    )

    return draw_all(document.figures)


def curves_of(document: Document) -> dict[str, str]:
    """The points of the curves of each figure as CSV, by its name, where it has curves."""
    from workbench.report.figures.curves import curves_csv

    return {figure.name: text for figure in document.figures if (text := curves_csv(figure))}
