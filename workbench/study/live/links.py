"""Links: the curves, bars, points and cells of a document that are a signal or a score of a case, to the bit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, TypeAlias

import numpy as np

from workbench.notation import text
from workbench.notation.formula import Formula
from workbench.study.document.document import Bars, Document, Measured, Panel, Phrase, Points, Series, Table
from workbench.study.document.figure import Label
from workbench.study.document.phrases import bare, parts
from workbench.study.study import Outcome
from workbench.validation.refusals import Array

Signal: TypeAlias = str | tuple[str, int]  # "t", or "x" or "y" with a place among states or outputs
Axis: TypeAlias = Literal["x", "y"]
Place: TypeAlias = tuple[int, int, int]  # of a score: its outcome, its metric, and the number of that


@dataclass(frozen=True)
class Curve:
    """A series of a panel of a figure that shows signals of a loop in some of its kept rows."""

    figure: str
    panel: int
    series: int
    loop: int
    x: Signal
    y: Signal
    rows: tuple[int, int]


@dataclass(frozen=True)
class LiveCell:
    """A cell of a table that shows a number of a metric of a loop, with its error."""

    table: str
    row: int
    column: int
    loop: int
    metric: int
    number: int


@dataclass(frozen=True)
class LiveMark:
    """The end of a bar, or a point along one axis, of a panel that shows a number of a metric of a loop."""

    figure: str
    panel: int
    series: int
    index: int
    axis: Axis
    loop: int
    metric: int
    number: int


def links(document: Document, outcomes: Sequence[Outcome]) -> list[Curve | LiveCell | LiveMark]:
    """All that is live in a document of these outcomes."""
    return [*curves(document, outcomes), *cells(document, outcomes), *marks(document, outcomes)]


def curves(document: Document, outcomes: Sequence[Outcome]) -> Iterator[Curve]:
    """Each series that is a signal of an outcome over the time, or over another signal, of the one with its label."""
    held = [_Signals(outcome) for outcome in outcomes]
    for figure in document.figures:
        for i, panel in enumerate(figure.panels):
            for j, series in enumerate(panel.series):
                if not isinstance(series, Series):
                    continue
                found = ((k, one) for k, signals in enumerate(held) if (one := signals.find(series)))
                label = _plain(series.label)
                if best := min(found, key=lambda one: label not in _names(outcomes[one[0]]), default=None):
                    yield Curve(figure.name, i, j, best[0], *best[1])


def cells(document: Document, outcomes: Sequence[Outcome]) -> Iterator[LiveCell]:
    """Each cell that is a score of a metric of an outcome; where several have its bits, the one that its heads name."""
    held: dict[tuple[float, float], list[Place]] = {}
    for pair, place in _scores(outcomes):
        held.setdefault(pair, []).append(place)
    for table in document.tables:
        for i, row in enumerate(table.rows):
            for j, cell in enumerate(row):
                value = bare(cell)
                if isinstance(value, Measured):
                    found = held.get((value.value, value.error), [])
                    for place in _only(found, _heads(table, i, j), outcomes):
                        yield LiveCell(table.name, i, j, *place)


def marks(document: Document, outcomes: Sequence[Outcome]) -> Iterator[LiveMark]:
    """Each end of a bar and each number of a point that is a score of an outcome.

    Where several scores have its bits it is the one of the law that names the row or the point. A whole number, as 0,
    is a score only by such a name.
    """
    held: dict[float, list[Place]] = {}
    for (value, _), place in _scores(outcomes):
        held.setdefault(value, []).append(place)
    for figure in document.figures:
        for i, panel in enumerate(figure.panels):
            for j, mark in enumerate(panel.series):
                if not isinstance(mark, Bars | Points):
                    continue
                for index, axis, value, heads in _ends(mark, panel):
                    found = held.get(value, [])
                    if value.is_integer():
                        found = [one for one in found if heads & {*_names(outcomes[one[0]])}]
                    for place in _only(found, heads, outcomes):
                        yield LiveMark(figure.name, i, j, index, axis, *place)


def _ends(mark: Bars | Points, panel: Panel) -> Iterator[tuple[int, Axis, float, set[str]]]:
    """Each number of bars or points along an axis that has no names: its place, its axis, and the words beside it."""
    rows = mark.places if isinstance(mark, Bars) else mark.y
    across = mark.ends if isinstance(mark, Bars) else mark.x
    axes: list[tuple[Axis, Array, Label]] = [] if panel.xnames else [("x", across, panel.xlabel)]
    if isinstance(mark, Points) and not panel.ynames:
        axes.append(("y", mark.y, panel.ylabel))
    for axis, numbers, label in axes:
        for index, value in enumerate(numbers.tolist()):
            heads = {_plain(mark.label), _plain(label).split(" [")[0]}
            heads |= {_plain(name) for row, name in enumerate(panel.ynames) if abs(rows[index] - row) < 0.5}
            heads |= {_plain(mark.names[index])} if isinstance(mark, Points) and mark.names else set()
            yield index, axis, value, heads


def _scores(outcomes: Sequence[Outcome]) -> Iterator[tuple[tuple[float, float], Place]]:
    """Each number of each metric of each outcome: its value and its error, and its place."""
    for k, outcome in enumerate(outcomes):
        for m, score in enumerate(outcome.measurement.scores.values()):
            for number, pair in enumerate(zip(score.value[0].tolist(), score.error[0].tolist(), strict=True)):
                yield pair, (k, m, number)


def _only(found: Sequence[Place], heads: set[str], outcomes: Sequence[Outcome]) -> Sequence[Place]:
    """The one of some scores whose law, or else whose metric, is among the heads; none where several are left."""
    found = [one for one in found if heads & {*_names(outcomes[one[0]])}] or found
    found = [one for one in found if [*outcomes[one[0]].measurement.scores][one[1]] in heads] or found
    return found if len(found) == 1 else ()


def _heads(table: Table, row: int, column: int) -> set[str]:
    first: Any = bare(table.rows[row][0])
    return {_plain(first), _plain(table.columns[column].header)}


def _names(outcome: Outcome) -> tuple[str, str]:
    return outcome.case.law, outcome.label


def _plain(phrase: Phrase | Any) -> str:
    """A phrase of words and formulas as plain text."""
    said = (text.emit(part) if isinstance(part, Formula) else part for part in parts(phrase))
    return "".join(part for part in said if isinstance(part, str))


class _Signals:
    """The states and outputs of an outcome at its kept times, found by their bits within a window of time."""

    def __init__(self, outcome: Outcome) -> None:
        self.runs = outcome.measurement.trajectories
        self.t = self.runs.t
        self._windows: dict[tuple[int, int], dict[bytes, Signal]] = {}

    def find(self, series: Series) -> tuple[Signal, Signal, tuple[int, int]] | None:
        """The signals of the abscissa and the ordinate, and the rows; None if the series shows anything else."""
        count = len(series.x)
        first = int(np.searchsorted(self.t, series.x[0]))
        if not np.array_equal(self.t[first : first + count], series.x):
            first = 0  # a curve in the plane of two signals begins with the run
            if count != len(self.t):
                return None
        held = self._window(first, first + count)
        x, y = held.get(_bits(series.x)), held.get(_bits(series.y))
        return None if x is None or y is None or y == "t" else (x, y, (first, first + count))

    def _window(self, first: int, last: int) -> dict[bytes, Signal]:
        if (first, last) not in self._windows:
            found: dict[bytes, Signal] = {_bits(self.t[first:last]): "t"}
            for kind, columns in (("x", self.runs.x[0]), ("y", self._outputs)):
                for place, column in enumerate(columns[first:last].T):
                    found.setdefault(_bits(column), (kind, place))
            self._windows[first, last] = found
        return self._windows[first, last]

    @cached_property
    def _outputs(self) -> Array:
        """All outputs, (N, ny)."""
        columns = (values[0].reshape(len(self.t), -1, order="F") for values in self.runs.outputs.values())
        return np.hstack([np.empty((len(self.t), 0)), *columns])


def _bits(numbers: Array) -> bytes:
    """The bits of some numbers, all that are not finite as one gap."""
    return np.where(np.isfinite(numbers), numbers, np.nan).tobytes()
