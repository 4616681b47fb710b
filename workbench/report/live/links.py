"""Links: the marks and cells of a document whose sources are signals, scores and linear answers of some outcomes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from workbench.core import Step
from workbench.study.document.document import Bars, Document, Points, Series
from workbench.study.document.figure import Mark
from workbench.study.document.phrases import Measured, Missing, bare, raised, source_of
from workbench.study.document.plane_marks import Arrows
from workbench.study.document.source import Source
from workbench.study.study import Outcome

Signal: TypeAlias = str | tuple[str, int]  # "t", or "x" or "y" with a place among states or outputs
Axis: TypeAlias = Literal["x", "y"]
Run: TypeAlias = tuple[str, str, str]  # the scenario, the law and the digest of an outcome


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


Link: TypeAlias = Curve | LiveCell | LiveMark | LinearMark | LinearCell


def links(document: Document, outcomes: Sequence[Outcome]) -> list[Link]:
    """All that is live in a document of these outcomes: each mark that was made of one of them."""
    loops = {(o.case.scenario, o.case.law, o.digest): k for k, o in enumerate(outcomes)}
    found: list[Link] = [*curves(document, outcomes, loops), *cells(document, outcomes, loops)]
    return [*found, *marks(document, outcomes, loops), *linear_marks(document, loops), *linear_cells(document, loops)]


def curves(document: Document, outcomes: Sequence[Outcome], loops: Mapping[Run, int]) -> Iterator[Curve]:
    """Each series that shows a signal of an outcome over the time, or over another signal."""
    for figure in document.figures:
        for i, panel in enumerate(figure.panels):
            for j, series in enumerate(panel.series):
                if not isinstance(series, Series) or series.sources is None:
                    continue
                x, y = series.sources
                loop = _loop(y, loops)
                if loop is not None and y.rows is not None:
                    step = outcomes[loop].measurement.trajectories.step
                    ends = (_place(step, x), _place(step, y))
                    yield Curve(figure.name, i, j, loop, *ends, y.rows, (x.scale, y.scale))


def cells(document: Document, outcomes: Sequence[Outcome], loops: Mapping[Run, int]) -> Iterator[LiveCell]:
    """Each cell that shows a score of an outcome."""
    for table in document.tables:
        for i, row in enumerate(table.rows):
            for j, cell in enumerate(row):
                for place in _score(source_of(cell), outcomes, loops):
                    yield LiveCell(table.name, i, j, *place)


def marks(document: Document, outcomes: Sequence[Outcome], loops: Mapping[Run, int]) -> Iterator[LiveMark]:
    """Each end of a bar, and each point along an axis, that shows a score of an outcome."""
    for figure in document.figures:
        for i, panel in enumerate(figure.panels):
            for j, mark in enumerate(panel.series):
                if not isinstance(mark, Bars | Points):
                    continue
                for axis, index, source in _sources(mark):
                    for place in _score(source, outcomes, loops):
                        yield LiveMark(figure.name, i, j, index, axis, *place)


def linear_marks(document: Document, loops: Mapping[Run, int]) -> Iterator[LinearMark]:
    """Each series, all points of a mark, and all of its arrows, that show a linear answer of an outcome."""
    for figure in document.figures:
        for i, panel in enumerate(figure.panels):
            for j, mark in enumerate(panel.series):
                source = _linear_source(mark)
                if source is not None and (loop := _loop(source, loops)) is not None:
                    yield LinearMark(figure.name, i, j, loop, source.name, source.place, source.scale)


def linear_cells(document: Document, loops: Mapping[Run, int]) -> Iterator[LinearCell]:
    """Each cell that shows a number of the linear answers of an outcome."""
    for table in document.tables:
        for i, row in enumerate(table.rows):
            for j, cell in enumerate(row):
                source = source_of(cell)
                if source is None or source.kind != "linear" or (loop := _loop(source, loops)) is None:
                    continue
                shown = bare(cell)
                number = shown.value if isinstance(shown, Measured) else None
                words = shown.words if isinstance(shown, Missing) else ""
                about = source.name, source.place, source.label, raised(source.unit)
                yield LinearCell(table.name, i, j, loop, *about, number, words)


def _linear_source(mark: Mark) -> Source | None:
    """The source of the ordinates of a mark, if that is a linear answer."""
    source = None
    if isinstance(mark, Series) and mark.sources is not None:
        source = mark.sources[1]
    elif isinstance(mark, Points) and mark.sources:
        source = mark.sources[0][1]
    elif isinstance(mark, Arrows):
        source = mark.source
    return source if source is not None and source.kind == "linear" else None


def _sources(mark: Bars | Points) -> Iterator[tuple[Axis, int, Source | None]]:
    """The sources of the ends of bars, or of points along either axis, with their places."""
    if isinstance(mark, Bars):
        yield from (("x", index, source) for index, source in enumerate(mark.sources))
    else:
        yield from (("x", index, pair[0]) for index, pair in enumerate(mark.sources))
        yield from (("y", index, pair[1]) for index, pair in enumerate(mark.sources))


def _loop(source: Source, loops: Mapping[Run, int]) -> int | None:
    return loops.get((source.scenario, source.law, source.run))


def _score(
    source: Source | None, outcomes: Sequence[Outcome], loops: Mapping[Run, int]
) -> Iterator[tuple[int, int, int, float]]:
    """The loop, the metric, its number and the scale of a source, if it is a score of an outcome."""
    if source is None or source.kind != "metric" or (loop := _loop(source, loops)) is None:
        return
    metrics = [*outcomes[loop].measurement.names]
    yield loop, metrics.index(source.name), source.place, source.scale


def _place(step: Step, source: Source) -> Signal:
    """The place of a signal among the states or the outputs of a step; an output that is a state is that state."""
    if source.kind == "time":
        return "t"
    layout, kind = (step.states, "x") if source.name in step.states else (step.outputs, "y")
    entry, first = layout[source.name], layout.slice(source.name).start
    flat = np.arange(entry.size).reshape(entry.shape, order="F").ravel()[source.place]
    place = first + int(flat)
    if kind == "y":
        states = {step.rule.x[k].element_hash(): k for k in range(step.rule.x.numel())}
        own = states.get(step.rule.output[place].element_hash())
        return (kind, place) if own is None else ("x", own)
    return kind, place
