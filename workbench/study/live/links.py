"""Links: the curves and the cells of a document that are a signal or a score of a case, to the bit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from workbench.notation import text
from workbench.notation.formula import Formula
from workbench.study.document.document import Document, Measured, Phrase, Series, Table
from workbench.study.document.phrases import bare, parts
from workbench.study.study import Outcome
from workbench.validation.refusals import Array

Signal: TypeAlias = str | tuple[str, int]  # "t", or "x" or "y" with a place among states or outputs


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
    held: dict[tuple[float, float], list[tuple[int, int, int]]] = {}
    for k, outcome in enumerate(outcomes):
        for m, score in enumerate(outcome.measurement.scores.values()):
            for number, pair in enumerate(zip(score.value[0].tolist(), score.error[0].tolist(), strict=True)):
                held.setdefault(pair, []).append((k, m, number))
    for table in document.tables:
        for i, row in enumerate(table.rows):
            for j, cell in enumerate(row):
                value = bare(cell)
                if isinstance(value, Measured):
                    found, heads = held.get((value.value, value.error), []), _heads(table, i, j)
                    found = [one for one in found if heads & {*_names(outcomes[one[0]])}] or found
                    found = [one for one in found if [*outcomes[one[0]].measurement.scores][one[1]] in heads] or found
                    if len(found) == 1:
                        yield LiveCell(table.name, i, j, *found[0])


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
