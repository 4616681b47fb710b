"""Links: the marks and cells of a document that show numbers of outcomes, each with the place of the loop that was run.

A mark or a cell carries its source: scenario, law and run, with the name and the place of a signal, of a metric or of a
linear answer. A link is that source, looked up among the outcomes of a study; one of another origin has none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

from workbench.study.document.document import Bars, Document, Points, Series
from workbench.study.document.figure import Mark
from workbench.study.document.phrases import Cell, Measured, Missing, bare, raised, source_of
from workbench.study.document.plane_marks import Arrows
from workbench.study.document.source import Source
from workbench.study.result_marks import flat_places
from workbench.study.study import Outcome

Signal: TypeAlias = Literal["t"] | tuple[Literal["x", "y"], int]  # the time, or a place among states or outputs
Axis: TypeAlias = Literal["x", "y"]
Place: TypeAlias = tuple[str, int, int]  # of a mark: figure, panel, series; of a cell: table, row, column


@dataclass(frozen=True)
class Curve:
    """A series of a panel of a figure that shows signals of a loop in some of its kept rows, times the scales."""

    figure: str
    panel: int
    series: int
    loop: int
    x: Signal
    y: Signal
    rows: tuple[int, int]
    scales: tuple[float, float]


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


def links_of(document: Document, outcomes: Sequence[Outcome]) -> Links:
    """The links of a document to outcomes, which are the loops by their places."""
    loops = _Loops(outcomes)
    marks, cells = [*_marks(document)], [*_cells(document)]
    return Links(
        tuple(link for place, mark in marks for link in _curves(place, mark, loops)),
        tuple(link for place, cell in cells for link in _live_cells(place, cell, loops)),
        tuple(link for place, mark in marks for link in _live_marks(place, mark, loops)),
        tuple(link for place, mark in marks for link in _linear_marks(place, mark, loops)),
        tuple(link for place, cell in cells for link in _linear_cells(place, cell, loops)),
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

    def linear(self, source: Source | None) -> Iterator[tuple[int, str, int]]:
        """The loop, the quantity and the channel of a source, if it is a linear answer of an outcome."""
        if source is not None and source.kind == "linear" and (loop := self.place(source)) is not None:
            yield loop, source.name, source.place

    def score(self, source: Source | None) -> Iterator[tuple[int, int, int, float]]:
        """The loop, the metric, its number and the scale of a source, if it is a score of an outcome."""
        if source is not None and source.kind == "metric" and (loop := self.place(source)) is not None:
            yield loop, self.outcomes[loop].measurement.names.index(source.name), source.place, source.scale

    def signal(self, loop: int, source: Source) -> Signal:
        """The place of a signal among the states or outputs of a loop; an output that is a state is that state."""
        if source.kind == "time":
            return "t"
        step = self.outcomes[loop].measurement.trajectories.step
        layout = step.states if source.name in step.states else step.outputs
        place = layout.slice(source.name).start + flat_places(layout[source.name])[source.place]
        if layout is step.states:
            return "x", place
        states = {step.rule.x[k].element_hash(): k for k in range(step.rule.x.numel())}
        own = states.get(step.rule.output[place].element_hash())
        return ("y", place) if own is None else ("x", own)


def _marks(document: Document) -> Iterator[tuple[Place, Mark]]:
    """The marks of all figures, with figure, panel and series."""
    for figure in document.figures:
        for i, panel in enumerate(figure.panels):
            for j, mark in enumerate(panel.series):
                yield (figure.name, i, j), mark


def _cells(document: Document) -> Iterator[tuple[Place, Cell]]:
    """The cells of all tables, with table, row and column."""
    for table in document.tables:
        for i, row in enumerate(table.rows):
            for j, cell in enumerate(row):
                yield (table.name, i, j), cell


def _curves(place: Place, mark: Mark, loops: _Loops) -> Iterator[Curve]:
    """The link of a series that shows a signal over the time, or over another signal."""
    if not isinstance(mark, Series) or mark.sources is None:
        return
    x, y = mark.sources
    if y.rows is not None and (loop := loops.place(y)) is not None:
        signals = loops.signal(loop, x), loops.signal(loop, y)
        yield Curve(*place, loop, *signals, y.rows, (x.scale, y.scale))


def _live_cells(place: Place, cell: Cell, loops: _Loops) -> Iterator[LiveCell]:
    """The link of a cell that shows a score."""
    for loop, metric, number, scale in loops.score(source_of(cell)):
        yield LiveCell(*place, loop, metric, number, scale)


def _live_marks(place: Place, mark: Mark, loops: _Loops) -> Iterator[LiveMark]:
    """The links of the ends of bars, or of points along either axis."""
    ends: tuple[tuple[Axis, Sequence[Source | None]], ...] = ()
    if isinstance(mark, Bars):
        ends = (("x", mark.sources),)
    elif isinstance(mark, Points):
        ends = (("x", [pair[0] for pair in mark.sources]), ("y", [pair[1] for pair in mark.sources]))
    for axis, sources in ends:
        for index, source in enumerate(sources):
            for loop, metric, number, scale in loops.score(source):
                yield LiveMark(*place, index, axis, loop, metric, number, scale)


def _linear_marks(place: Place, mark: Mark, loops: _Loops) -> Iterator[LinearMark]:
    """The link of a series, all points of a mark, or all of its arrows, by the source of the ordinates."""
    source = None
    if isinstance(mark, Series) and mark.sources is not None:
        source = mark.sources[1]
    elif isinstance(mark, Points) and mark.sources:
        source = mark.sources[0][1]
    elif isinstance(mark, Arrows):
        source = mark.source
    for answer in loops.linear(source):
        yield LinearMark(*place, *answer, 1.0 if source is None else source.scale)


def _linear_cells(place: Place, cell: Cell, loops: _Loops) -> Iterator[LinearCell]:
    """The link of a cell that shows a linear answer, with the number or the words that are printed there."""
    source, shown = source_of(cell), bare(cell)
    for answer in loops.linear(source):
        about = ("", "") if source is None else (source.label, raised(source.unit))
        number = shown.value if isinstance(shown, Measured) else None
        yield LinearCell(*place, *answer, *about, number, shown.words if isinstance(shown, Missing) else "")
