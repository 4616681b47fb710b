"""Figures in one style, readable in black and white, and the only door to matplotlib.

`sheet.draw` makes the figures of a report; `axes.plot` draws them on matplotlib's own axes, for a notebook;
`runs.plot_runs` draws trajectories.
"""

from __future__ import annotations

from workbench.study.document.document import Document


def drawn(document: Document) -> dict[str, str]:
    """The SVG text of each figure by its name."""
    from workbench.report.figures.sheet import draw_all  # with matplotlib, which takes longer than all else to import

    return draw_all(document.figures)


def curves(document: Document) -> dict[str, str]:
    """The points of the curves of each figure as CSV, by its name, where it has curves."""
    from workbench.report.figures.points import curves_csv

    return {figure.name: text for figure in document.figures if (text := curves_csv(figure))}
