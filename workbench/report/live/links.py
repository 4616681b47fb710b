"""Links: the results that a page prints, each with the place of the loop that was run for it.

What is printed carries its source: scenario, law and run, with the name and the place of a signal, of a metric or of a
linear answer. A link is that source, looked up among the outcomes of a study; one of another origin has none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from workbench.study.document.printed_results import (
    Axis,
    PrintedCell,
    PrintedCurve,
    PrintedMark,
    PrintedNumber,
    PrintedResults,
)
from workbench.study.document.source import Source
from workbench.study.result_marks import Signal, place_of_signal
from workbench.study.study import Outcome


@dataclass(frozen=True)
class Curve:
    """A series of a panel of a figure that shows signals of a loop in some of its kept rows, times the scales.

    Where `stages` is not 0 it shows so many numbers of the first of these rows, from the place of y on, at times that
    are `spacing` s apart.
    """

    figure: str
    panel: int
    series: int
    loop: int
    x: Signal
    y: Signal
    rows: tuple[int, int]
    scales: tuple[float, float]
    stages: int = 0
    spacing: float = 0.0


@dataclass(frozen=True)
class LiveCell:
    """A cell of a table that shows a number of a metric of a loop, with its error, times a scale."""

    table: str
    row: int
    column: int
    loop: int
    metric: int
    number: int
    scale: float


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
    scale: float


@dataclass(frozen=True)
class LinearMark:
    """A series, points or arrows of a panel that show a linear answer of a loop at a channel, times a scale."""

    figure: str
    panel: int
    series: int
    loop: int
    quantity: str
    channel: int
    scale: float


@dataclass(frozen=True)
class LinearCell:
    """A cell of a table that shows a number of the linear answers of a loop at a channel, or words."""

    table: str
    row: int
    column: int
    loop: int
    quantity: str
    channel: int
    label: str
    unit: str
    printed: float | None
    words: str


@dataclass(frozen=True)
class Links:
    """The links of a document by their kinds, each in reading order."""

    curves: tuple[Curve, ...]
    cells: tuple[LiveCell, ...]
    marks: tuple[LiveMark, ...]
    linear_marks: tuple[LinearMark, ...]
    linear_cells: tuple[LinearCell, ...]

    @property
    def moving_loops(self) -> set[int]:
        """The loops of which signals or metrics are shown."""
        return {one.loop for one in self.curves} | {one.loop for one in self.cells} | {one.loop for one in self.marks}

    @property
    def linear_loops(self) -> set[int]:
        """The loops of which linear answers are shown."""
        return {one.loop for one in self.linear_marks} | {one.loop for one in self.linear_cells}


def links_of(results: PrintedResults, outcomes: Sequence[Outcome]) -> Links:
    """The links of what a document prints to outcomes, which are the loops by their places."""
    loops = _Loops(outcomes)
    return Links(
        tuple(link for one in results.curves for link in _curve(one, loops)),
        tuple(link for one in results.cells for link in _live_cell(one, loops)),
        tuple(link for one in results.numbers for link in _live_mark(one, loops)),
        tuple(link for one in results.marks for link in _linear_mark(one, loops)),
        tuple(link for one in results.cells for link in _linear_cell(one, loops)),
    )


@dataclass(frozen=True, eq=False)
class _Loops:
    """Outcomes, found by the scenario, the law and the run of a source."""

    outcomes: Sequence[Outcome]

    @cached_property
    def _places(self) -> dict[tuple[str, str, str], int]:
        return {(one.case.scenario, one.case.law, one.digest): place for place, one in enumerate(self.outcomes)}

    def place(self, source: Source) -> int | None:
        """The place of the outcome of a source; None if it is not among them."""
        return self._places.get((source.scenario, source.law, source.run))

    def linear(self, source: Source) -> Iterator[tuple[int, str, int]]:
        """The loop, the quantity and the channel of a source, if it is a linear answer of an outcome."""
        if source.kind == "linear" and (loop := self.place(source)) is not None:
            yield loop, source.name, source.place

    def score(self, source: Source) -> Iterator[tuple[int, int, int, float]]:
        """The loop, the metric, its number and the scale of a source, if it is a score of an outcome."""
        if source.kind == "metric" and (loop := self.place(source)) is not None:
            yield loop, self.outcomes[loop].measurement.names.index(source.name), source.place, source.scale


def _curve(printed: PrintedCurve, loops: _Loops) -> Iterator[Curve]:
    """The link of a curve that shows a signal over the time, or over another signal."""
    x, y = printed.x, printed.y
    if y.rows is not None and (loop := loops.place(y)) is not None:
        outcome = loops.outcomes[loop]
        signals = place_of_signal(outcome, x), place_of_signal(outcome, y)
        yield Curve(*printed.place, loop, *signals, y.rows, (x.scale, y.scale), y.stages, y.spacing)


def _live_cell(printed: PrintedCell, loops: _Loops) -> Iterator[LiveCell]:
    """The link of a cell that shows a score."""
    for loop, metric, number, scale in loops.score(printed.source):
        yield LiveCell(*printed.place, loop, metric, number, scale)


def _live_mark(printed: PrintedNumber, loops: _Loops) -> Iterator[LiveMark]:
    """The link of the end of a bar, or of a point along an axis, that shows a score."""
    for loop, metric, number, scale in loops.score(printed.source):
        yield LiveMark(*printed.place, printed.index, printed.axis, loop, metric, number, scale)


def _linear_mark(printed: PrintedMark, loops: _Loops) -> Iterator[LinearMark]:
    """The link of a mark that shows a linear answer."""
    for answer in loops.linear(printed.source):
        yield LinearMark(*printed.place, *answer, printed.source.scale)


def _linear_cell(printed: PrintedCell, loops: _Loops) -> Iterator[LinearCell]:
    """The link of a cell that shows a linear answer, with the number or the words that are printed there."""
    for answer in loops.linear(printed.source):
        yield LinearCell(*printed.place, *answer, printed.source.label, printed.unit, printed.number, printed.words)
