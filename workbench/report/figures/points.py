"""The curves of a figure as numbers, for a reader who goes on with them."""

from __future__ import annotations

import csv
import io
from itertools import zip_longest

import numpy as np

from workbench.report.cleaning import cleaned
from workbench.report.figures.looks import letter_of, points_of
from workbench.report.tables import plain
from workbench.report.thinning import thinned, windowed
from workbench.study.document.curves import Array, Band, Series
from workbench.study.document.document import Figure
from workbench.study.export import spreadsheet_text


def curves_csv(figure: Figure) -> str:
    """The points of all lines and bands as they are drawn, with all their digits, a column each; empty without any.

    A column of an abscissa stands before those that share it. Heads say panel, curve and what is measured, with its
    unit, as the picture does. A gap is empty.
    """
    figure = cleaned(figure)
    columns: list[tuple[str, Array]] = []
    for i, panel in enumerate(figure.panels):
        place, abscissa = f"{letter_of(figure, i)} ".lstrip(), np.empty(0)
        for mark in panel.series:
            if not isinstance(mark, Series | Band):
                continue
            x, *ordinates = thinned(windowed(mark.curves, panel.xlim), points_of(figure))
            if not np.array_equal(x, abscissa):
                columns.append((f"{place}{plain(panel.xlabel)}", x))
                abscissa = x
            ends = (" (low)", " (high)") if isinstance(mark, Band) else ("",)
            name = f"{plain(mark.label)}: " if mark.label else ""
            columns += [(f"{place}{name}{plain(panel.ylabel)}{end}", y) for end, y in zip(ends, ordinates, strict=True)]
    if not columns:
        return ""
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow([spreadsheet_text(head) for head, _ in columns])
    texts = (["" if value != value else repr(value) for value in column.tolist()] for _, column in columns)
    writer.writerows(zip_longest(*texts, fillvalue=""))
    return out.getvalue()
