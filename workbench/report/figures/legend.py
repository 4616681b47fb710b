"""What the lines of a figure are called: one legend for all of its panels."""

from __future__ import annotations

import re

from workbench.report.figures.labels import written
from workbench.report.figures.looks import WIDTH
from workbench.study.document.document import Figure, Mark, Tiles


def entries(figure: Figure) -> dict[str, Mark]:
    """Each name with the first series of that name; what is named by the title of its panel needs no line in it."""
    found: dict[str, Mark] = {}
    for panel in figure.panels:
        for series in panel.series:
            for mark in series.keys if isinstance(series, Tiles) and series.keys else (series,):
                if mark.label and mark.label != panel.title:
                    found.setdefault(written(mark.label), mark)
    return found


def across(names: dict[str, Mark]) -> int:
    """How many names stand side by side."""
    letters = [len(re.sub(r"[\\${}]", "", name)) for name in names]
    rows = -(-sum(0.065 * n + 0.5 for n in letters) // WIDTH)
    return -(-len(names) // int(rows))
