"""The results that a document prints: curves, points, marks and cells that carry a source, each with its place."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from workbench.study.document.document import Bars, Document, Points, Series
from workbench.study.document.figure import Mark
from workbench.study.document.phrases_and_tables import MissingCell, ValueWithError, bare, source_of, superscript_powers
from workbench.study.document.plane_marks import Arrows
from workbench.study.document.source import Source

Axis: TypeAlias = Literal["x", "y"]
Place: TypeAlias = tuple[str, int, int]  # of a mark: figure, panel, series; of a cell: table, row, column


@dataclass(frozen=True)
class PrintedCurve:
    """A series of a panel that shows one result over another, or over the time."""

    place: Place
    x: Source
    y: Source


@dataclass(frozen=True)
class PrintedNumber:
    """One end of a bar, or one point along an axis, that shows a result."""

    place: Place
    index: int
    axis: Axis
    source: Source


@dataclass(frozen=True)
class PrintedMark:
    """A series, all points of a mark, or all of its arrows, that show a result along the ordinate."""

    place: Place
    source: Source


@dataclass(frozen=True)
class PrintedCell:
    """A cell that shows a result: its number, or its words, and the unit as a page writes it."""

    place: Place
    source: Source
    number: float | None
    words: str
    unit: str


@dataclass(frozen=True)
class PrintedResults:
    """The results that a document prints, each kind in reading order."""

    curves: tuple[PrintedCurve, ...]
    numbers: tuple[PrintedNumber, ...]
    marks: tuple[PrintedMark, ...]
    cells: tuple[PrintedCell, ...]

    @staticmethod
    def of(document: Document) -> PrintedResults:
        """The results that the figures and tables of a document print."""
        marks = [*_marks(document)]
        return PrintedResults(
            tuple(curve for place, mark in marks for curve in _curves(place, mark)),
            tuple(number for place, mark in marks for number in _numbers(place, mark)),
            tuple(PrintedMark(place, source) for place, mark in marks if (source := _along_ordinate(mark))),
            tuple(_cells(document)),
        )


def _marks(document: Document) -> Iterator[tuple[Place, Mark]]:
    """The marks of all figures with their places."""
    for figure in document.figures:
        for i, panel in enumerate(figure.panels):
            for j, mark in enumerate(panel.series):
                yield (figure.name, i, j), mark


def _curves(place: Place, mark: Mark) -> Iterator[PrintedCurve]:
    """The curve that a mark is, if it is one with sources."""
    if isinstance(mark, Series) and mark.sources is not None:
        yield PrintedCurve(place, *mark.sources)


def _numbers(place: Place, mark: Mark) -> Iterator[PrintedNumber]:
    """The ends of bars with a source, or the points with one along either axis."""
    ends: tuple[tuple[Axis, Sequence[Source | None]], ...] = ()
    if isinstance(mark, Bars):
        ends = (("x", mark.sources),)
    elif isinstance(mark, Points):
        ends = (("x", [pair[0] for pair in mark.sources]), ("y", [pair[1] for pair in mark.sources]))
    for axis, sources in ends:
        for index, source in enumerate(sources):
            if source is not None:
                yield PrintedNumber(place, index, axis, source)


def _along_ordinate(mark: Mark) -> Source | None:
    """The source of the ordinates of a series, of the first of some points, or of arrows."""
    if isinstance(mark, Series) and mark.sources is not None:
        return mark.sources[1]
    if isinstance(mark, Points) and mark.sources:
        return mark.sources[0][1]
    return mark.source if isinstance(mark, Arrows) else None


def _cells(document: Document) -> Iterator[PrintedCell]:
    """The cells of all tables that have a source."""
    for table in document.tables:
        for i, row in enumerate(table.rows):
            for j, cell in enumerate(row):
                if (source := source_of(cell)) is None:
                    continue
                value = bare(cell)
                number = value.value if isinstance(value, ValueWithError) else None
                words = value.words if isinstance(value, MissingCell) else ""
                yield PrintedCell((table.name, i, j), source, number, words, superscript_powers(source.unit))
