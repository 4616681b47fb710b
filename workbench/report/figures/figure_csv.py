"""The marks of a figure as a table of numbers beside the picture, with what each of them shows."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from itertools import zip_longest

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.report.figures.curves import drawn_points
from workbench.report.figures.style import letter_of
from workbench.report.table_text import plain
from workbench.study.document.figure import Band, Bars, Figure, Label, Panel, Points, Series
from workbench.study.document.phrases_and_tables import head_of
from workbench.study.document.source import Source
from workbench.study.run_tables import spreadsheet_text

Sources = Sequence[Source | None]


def figure_csv(figure: Figure) -> str:
    """The points of lines and bands as they are drawn, and bars and points, with all digits; empty without any.

    A column of an abscissa stands before those that share it. The head of a curve that shows a result is its law,
    scenario, signal with unit, and run; beside bars and points stands what each of them shows. A gap is empty.
    """
    columns: list[tuple[str, list[str]]] = []
    for i, panel in enumerate(figure.panels):
        place, abscissa = f"{letter_of(figure, i)} ".lstrip(), np.empty(0)
        for mark in panel.series:
            if isinstance(mark, Series | Band):
                x, *ordinates = drawn_points(mark, panel, figure)
                over, *heads = _heads(mark, panel)
                if not np.array_equal(x, abscissa):
                    columns.append((f"{place}{over}", _texts(x)))
                    abscissa = x
                columns += [(f"{place}{head}", _texts(y)) for head, y in zip(heads, ordinates, strict=True)]
            elif isinstance(mark, Bars | Points):
                for head, numbers, shown in _axes(mark, panel):
                    columns += [(f"{place}{head}, of", shown), (f"{place}{head}", _texts(numbers))]
    if not columns:
        return ""
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow([spreadsheet_text(head) for head, _ in columns])
    writer.writerows(zip_longest(*(texts for _, texts in columns), fillvalue=""))
    return out.getvalue()


def _heads(mark: Series | Band, panel: Panel) -> tuple[str, ...]:
    """The heads of the abscissa and the ordinates: those of their sources, or else of their labels."""
    over = plain(panel.xlabel)
    if isinstance(mark, Series) and mark.sources is not None:
        x, y = mark.sources
        return (over if x.kind == "time" else head_of(x)), head_of(y)
    ends = (" (low)", " (high)") if isinstance(mark, Band) else ("",)
    return over, *(f"{_named(mark.label, panel.ylabel)}{end}" for end in ends)


def _named(label: Label, axis: Label) -> str:
    return f"{plain(label)}: {plain(axis)}" if label else plain(axis)


def _axes(mark: Bars | Points, panel: Panel) -> Iterator[tuple[str, Array, list[str]]]:
    """Each axis of numbers of bars or points: its head, the numbers, and what each of these shows."""
    if isinstance(mark, Bars):
        rows = np.clip(np.round(mark.places), 0, max(0, len(panel.ynames) - 1)).astype(int).tolist()
        names = [plain(panel.ynames[row]) if panel.ynames else "" for row in rows]
        yield _named(mark.label, panel.xlabel), mark.ends, _shown(names, mark.sources)
        return
    names = [plain(name) for name in mark.names] or [""] * len(mark.x)
    across, up = zip(*mark.sources, strict=True) if mark.sources else ((), ())
    if not panel.xnames:
        yield _named(mark.label, panel.xlabel), mark.x, _shown(names, across)
    if not panel.ynames:
        yield _named(mark.label, panel.ylabel), mark.y, _shown(names, up)


def _shown(names: Sequence[str], sources: Sources) -> list[str]:
    """The source of each mark in words, or else its name."""
    pairs = zip(names, sources or [None] * len(names), strict=True)
    return [spreadsheet_text(name if source is None else head_of(source)) for name, source in pairs]


def _texts(numbers: Array) -> list[str]:
    return ["" if value != value else repr(value) for value in numbers.tolist()]
