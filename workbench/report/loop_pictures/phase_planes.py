"""Phase planes: a vector field of two states, the lines on which one of them rests, equilibria, and runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from workbench.core.validation.refusals import Array, Integers, numbers, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.figure import STYLES, Arrows, Figure, Label, Mark, Panel, Points, Series
from workbench.study.document.frequency_curves import add_remarks
from workbench.study.document.phrases_and_tables import Phrase, ReportTable, TableColumn

Point: TypeAlias = tuple[float, float]
ARROWS = 17  # along each axis
POINTS = 500  # of a drawn run
LENGTH = 9.0  # points
HEADS = (0.15, 0.5)  # of the length of a run: the places of its arrowheads


@dataclass(frozen=True, eq=False)
@check_arguments
class VectorField:
    """The rates u and v (ny, nx) of two states at the abscissae x (nx,) and the ordinates y (ny,) of a grid."""

    x: Array
    y: Array
    u: Array
    v: Array

    def __post_init__(self) -> None:
        for name in ("x", "y"):
            grid = numbers(f"VectorField({name}=...)", getattr(self, name), 1)
            if len(grid) < 2 or not np.isfinite(grid).all() or (grid[1:] <= grid[:-1]).any():
                raise refusal(f"VectorField({name}=...)", "two or more finite numbers in rising order", grid)
        shape = len(self.y), len(self.x)
        for name in ("u", "v"):
            rates = numbers(f"VectorField({name}=...)", getattr(self, name), 2)
            if rates.shape != shape or np.isinf(rates).any():
                raise refusal(f"VectorField({name}=...)", f"an array {shape} of finite rates, or NaN", rates)


@dataclass(frozen=True, eq=False)
@check_arguments
class EquilibriumMark:
    """An equilibrium at (x, y), with its kind in words: 'stable focus'."""

    x: float
    y: float
    kind: str = ""


@dataclass(frozen=True, eq=False)
@check_arguments
class PhaseCurve:
    """A run through the plane: the states x (N,) and y (N,), in the order of time."""

    label: Label
    x: Array
    y: Array

    def __post_init__(self) -> None:
        if self.x.shape != self.y.shape or self.x.ndim != 1 or len(self.x) < 2 or not np.isfinite(self.x).all():
            raise refusal("PhaseCurve(x, y)", "two arrays (N,) of one length N >= 2, x finite", self.x)


@check_arguments
def phase_figure(
    name: str,
    caption: Phrase,
    field: VectorField,
    xlabel: Label,
    ylabel: Label,
    equilibria: Sequence[EquilibriumMark] = (),
    runs: Sequence[PhaseCurve] = (),
    nullclines: tuple[Label, Label] = ("x' = 0", "y' = 0"),
) -> Figure:
    """A vector field as arrows of one length, its nullclines, equilibria with their kinds, and runs with arrowheads.

    Nullclines are found on the straight lines between the points of the grid.

    Raises
    ------
    ValueError
        If a rate at every point of the grid is not known.

    Examples
    --------
    >>> from workbench.report.loop_pictures import PhaseCurve, EquilibriumMark, VectorField, phase_figure
    >>> grid = np.array([-1.0, 0.0, 1.0])
    >>> field = VectorField(grid, grid, *np.meshgrid(grid, grid))
    >>> rests, runs = [EquilibriumMark(0.0, 0.0, "saddle")], [PhaseCurve("run", grid, grid)]
    >>> phase_figure("plane", "A saddle", field, "x", "y", rests, runs).name
    'plane'
    """
    if np.isnan(field.u).all() or np.isnan(field.v).all():
        raise refusal("phase_figure(field=...)", "rates, of which some are known", field)
    marks: list[Mark] = []
    for k, run in enumerate(_thinned(one, field) for one in runs):
        marks.append(Series(run.label, run.x, run.y, k % STYLES))
        marks += _heads(run, field, k % STYLES)
    for label, rates, style in ((nullclines[0], field.u, 7), (nullclines[1], field.v, 8)):
        x, y = zero_lines(field.x, field.y, rates)
        if x.size:
            marks.append(Series(label, x, y, style))
    marks.append(_arrows(field))
    if equilibria:
        x, y = (np.array([getattr(one, axis) for one in equilibria]) for axis in "xy")
        marks.append(Points("equilibria", x, y, tuple(one.kind for one in equilibria), 6, shape="zero"))
    limits = [(float(grid[0]), float(grid[-1])) for grid in (field.x, field.y)]
    panel = Panel(ylabel, tuple(marks), xlabel, limits[0], limits[1], aspect="tall")
    return Figure(name, add_remarks(caption, []), (panel,), 1, _table(name, caption, field, xlabel, ylabel))


def _table(name: str, caption: Phrase, field: VectorField, xlabel: Label, ylabel: Label) -> ReportTable:
    """The rates as rows."""
    rows = tuple(
        (float(x), float(y), *(None if np.isnan(rate[i, j]) else float(rate[i, j]) for rate in (field.u, field.v)))
        for i, y in enumerate(field.y)
        for j, x in enumerate(field.x)
    )
    across, up = (label if isinstance(label, tuple) else (label,) for label in (xlabel, ylabel))
    heads = (TableColumn(xlabel), TableColumn(ylabel), TableColumn((*across, ", rate")), TableColumn((*up, ", rate")))
    return ReportTable(name, caption, heads, rows)


def _arrows(field: VectorField) -> Arrows:
    """Arrows at points spread over the grid."""
    columns, rows = (_spread(len(grid)) for grid in (field.x, field.y))
    x, y = np.meshgrid(field.x[columns], field.y[rows])
    u, v = (rate[np.ix_(rows, columns)] for rate in (field.u, field.v))
    return Arrows("", x.ravel(), y.ravel(), u.ravel(), v.ravel(), "aid", LENGTH)


def _spread(count: int) -> Integers:
    """Places at even steps along an axis of the grid, as far from its first as from its last."""
    step = -(-count // ARROWS)
    return np.arange((count - 1) % step // 2, count, step)


def _thinned(run: PhaseCurve, field: VectorField) -> PhaseCurve:
    """A run with points at even lengths in shares of the axes, where it has many more."""
    if len(run.x) <= POINTS:
        return run
    steps = np.hypot(np.diff(run.x) / np.ptp(field.x), np.diff(run.y) / np.ptp(field.y))
    length = np.concatenate([[0.0], np.cumsum(np.nan_to_num(steps) + 1e-12)])
    kept = np.unique(np.minimum(np.searchsorted(length, np.linspace(0, length[-1], POINTS)), len(run.x) - 1))
    return PhaseCurve(run.label, run.x[kept], run.y[kept])


def _heads(run: PhaseCurve, field: VectorField, style: int) -> list[Mark]:
    """Arrowheads on a run, at even lengths in shares of the axes."""
    wide, high = float(np.ptp(field.x)), float(np.ptp(field.y))
    steps = np.nan_to_num(np.hypot(np.diff(run.x) / wide, np.diff(run.y) / high))
    length = np.concatenate([[0.0], np.cumsum(steps)])
    if length[-1] < 0.1:
        return []
    places = np.array([max(1, int(np.searchsorted(length, share * length[-1]))) for share in HEADS])
    u, v = run.x[places] - run.x[places - 1], run.y[places] - run.y[places - 1]
    return [Arrows("", run.x[places], run.y[places], u, v, style)]


def zero_lines(x: Array, y: Array, rates: Array) -> tuple[Array, Array]:
    """The lines on which rates (ny, nx) over a grid are zero, as points with a NaN behind each line.

    Each cell is cut into two triangles, in which a rate is linear, so that a line has a stroke in each that it crosses;
    strokes with a common end are joined.
    """
    strokes: list[list[Point]] = []
    for i, j in np.ndindex(len(y) - 1, len(x) - 1):
        places = (i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)
        corners = [(float(x[b]), float(y[a]), float(rates[a, b])) for a, b in places]
        for triangle in ((0, 1, 2), (0, 2, 3)):
            ends = _cuts([corners[k] for k in triangle])
            if len(ends) == 2 and ends[0] != ends[1]:
                strokes.append(ends)
    lines = _chains(strokes)
    points = [point for line in lines for point in (*line, (line[-1][0], np.nan))]
    return (np.array([at for at, _ in points]), np.array([up for _, up in points]))


def _cuts(corners: Sequence[tuple[float, float, float]]) -> list[Point]:
    """The points on the sides of a triangle at which a linear rate is zero, the same for a side from either end."""
    found = []
    for one, other in zip(corners, (*corners[1:], corners[0]), strict=True):
        (x0, y0, a), (x1, y1, b) = sorted((one, other))
        if (a < 0) != (b < 0) and np.isfinite(a + b):
            share = a / (a - b)
            found.append((float(x0 + share * (x1 - x0)), float(y0 + share * (y1 - y0))))
    return found


def _chains(strokes: Sequence[list[Point]]) -> list[list[Point]]:
    """The strokes joined at common ends to lines, open ones first, then those that close."""
    beside: dict[Point, list[int]] = {}
    for k, stroke in enumerate(strokes):
        for end in stroke:
            beside.setdefault(end, []).append(k)
    left = dict.fromkeys(range(len(strokes)))
    starts = [end for end, held in beside.items() if len(held) == 1]
    lines: list[list[Point]] = []
    for start in (*starts, *(stroke[0] for stroke in strokes)):
        line = [start]
        while (place := next((k for k in beside[line[-1]] if k in left), None)) is not None:
            del left[place]
            first, last = strokes[place]
            line.append(last if first == line[-1] else first)
        if len(line) > 1:
            lines.append(line)
    return lines
