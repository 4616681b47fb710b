"""Figures in one style, readable in black and white, and the only door to matplotlib.

`sheet.draw` makes the figures of a report; `axes.plot` draws them on matplotlib's own axes, for a notebook.
"""

from __future__ import annotations

from workbench.study.document import Document


def drawn(document: Document) -> dict[str, str]:
    """The SVG text of each figure by its name."""
    from workbench.report.figures.sheet import draw_all  # with matplotlib, which takes longer than all else to import

    return draw_all(document.figures)
