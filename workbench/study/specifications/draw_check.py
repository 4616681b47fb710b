"""Specifications over draws of factors: the share of the draws that keep each limit.

The figures of all draws are computed on a grid. Draws near a limit, and some others, are computed again between proved
bounds; the nearness is taken from the differences that these show.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.core import Layout
from workbench.core.validation.notebook_display import table_to_html
from workbench.core.validation.refusals import Array, known_name, seed, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.switching_functions import Mask
from workbench.design.linear_loop import LinearLoop, LinearRows
from workbench.design.linear_loop.loop_linearization import linear_loop_about
from workbench.engine.factors import Factor, Space
from workbench.study.document.phrases_and_tables import ReportTable, TableColumn
from workbench.study.specifications.limits import FigureLimit
from workbench.study.specifications.loop_systems import LoopSystems
from workbench.study.specifications.point_figures import LoopFigure, point_figure
from workbench.study.specifications.row_figures import RowGrid, row_figures
from workbench.study.uncertainty.designs import MonteCarlo
from workbench.study.uncertainty.quantiles import Share, share

CALL = "Specification.check_draws"
MOST_DRAWS = 100_000
LOOKED_AT, GUARD = 8, 4.0  # draws by each limit that are proved first; multiples of the grid's error that are near
FLAGS = {"holds": 1.0, "fails": 0.0, "undecided": np.nan}
ALL = "all limits"


@dataclass(frozen=True, eq=False)
class DrawnFigures:
    """The figures (N,) of one limit at N draws, NaN without one, and whether each keeps it: 1, 0, or NaN if open.

    A draw at which the loop is not stable keeps no limit. `is_proved` (N,) is True for the draws whose figure has
    proved bounds; the others come from a grid, and `grid_error` is the largest difference of the two that was seen, in
    the unit of the figure. `confidence` is that of the interval of the share.
    """

    limit: FigureLimit
    values: Array
    flags: Array
    is_proved: Mask
    grid_error: float
    confidence: float

    @property
    def share(self) -> Share:
        """The share of all draws that keep the limit, with the interval of Clopper and Pearson (1934)."""
        return share(self.flags, self.confidence)


@dataclass(frozen=True, eq=False)
class DrawVerdicts:
    """A specification at N independent draws of factors, in the order of its limits.

    Attributes
    ----------
    figures
        The figures of each limit.
    draws
        The values (N,) of each number that is drawn, by its path.
    unstable
        The number of draws at which the loop is not stable.
    reasons
        The reason why a draw has no answer, by its number.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.linear_loop(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)))
    >>> factor = wb.Factor("R", ("plant.R",), wb.Uniform(0.9, 1.1))
    >>> wb.Specification(damping=0.5).check_draws(loop, (factor,), draws=20).share.runs
    20
    """

    figures: tuple[DrawnFigures, ...]
    draws: Mapping[str, Array]
    unstable: int
    reasons: Mapping[int, str]

    def __iter__(self) -> Iterator[DrawnFigures]:
        return iter(self.figures)

    def __getitem__(self, name: str) -> DrawnFigures:
        names = [one.limit.kind.name for one in self.figures]
        return self.figures[names.index(known_name(name, names, "limits of this specification"))]

    def __len__(self) -> int:
        return len(self.figures[0].flags)

    @property
    def share(self) -> Share:
        """The share of all draws that keep every limit, with its interval."""
        flags = np.stack([one.flags for one in self.figures])
        every = np.where((flags == 0).any(axis=0), 0.0, np.where(np.isnan(flags).any(axis=0), np.nan, 1.0))
        return share(every, self.figures[0].confidence)

    @check_arguments
    def draw(self, number: int) -> dict[str, float]:
        """The numbers of one draw, as `linear_loop(loop, values=...)` takes them."""
        at = whole("DrawVerdicts.draw(number)", number, 0, len(self) - 1)
        return {name: float(column[at]) for name, column in self.draws.items()}

    @check_arguments
    def worst(self, name: str) -> int:
        """The number of the draw whose figure is farthest beyond a limit, or nearest to it; an unstable one first."""
        one = self[name]
        lost = np.isnan(one.values)
        room = np.minimum(one.values - one.limit.low, one.limit.high - one.values)
        return int(np.argmin(np.where(lost, np.where(one.flags == 0, -np.inf, np.inf), room)))

    @property
    def rows(self) -> tuple[tuple[str, str, str], ...]:
        """Each limit and all of them together: the share of the draws that keep it, and its interval, in words."""
        pairs = [(one.limit.words, one.share) for one in self.figures]
        return tuple((words, *_in_words(one)) for words, one in (*pairs, (ALL, self.share)))

    @check_arguments
    def table(self, name: str = "shares", caption: str = "") -> ReportTable:
        """The shares as a table, a block of a section of a report."""
        level = f"{100 * self.figures[0].confidence:g} %"
        heads = TableColumn("limit"), TableColumn("kept by", align="right"), TableColumn(f"{level} interval")
        usual = f"The share of {len(self):,} draws that keep each limit. Draws near a limit have proved figures."
        return ReportTable(name, caption or usual, heads, self.rows)

    def __str__(self) -> str:
        lines = [
            f"{words}: kept by {value} of {len(self):,} draws, {interval}." for words, value, interval in self.rows
        ]
        if self.unstable:
            lines.append(f"The loop is not stable at {self.unstable:,} draws, which keep no limit.")
        if self.reasons:
            lines.append(f"{len(self.reasons):,} draws have no answer: {next(iter(self.reasons.values()))}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<{len(self):,} draws of a specification with {len(self.figures)} limits>"

    def _repr_html_(self) -> str:
        return table_to_html(f"{len(self):,} draws", ("limit", "kept by", "interval"), self.rows)


def check_draws(
    systems: LoopSystems,
    limits: Sequence[FigureLimit],
    factors: tuple[Factor, ...],
    draws: int,
    seed_number: int,
    confidence: float,
) -> DrawVerdicts:
    """The figures of a linear loop at random draws of factors of its parameters, each about a rest state of its own."""
    linear = systems.loop
    assert isinstance(linear, LinearLoop)
    count = whole(f"{CALL}(draws=...)", draws, 1, MOST_DRAWS, " of draws")
    layout = _with_defaults(linear.parameters, linear.p0)
    space = Space(factors, layout)
    p = space.rows(MonteCarlo(len(factors), count, seed(f"{CALL}(seed=...)", seed_number)).points())[0]
    drawn = {layout.labels[i]: p[:, i] for i in sorted({int(i) for own in space.places for i in own})}
    task = _Task(systems, linear.rows(drawn), limits, {}, {})
    every = []
    for i, limit in enumerate(limits):
        values, flags, is_proved, error = task.judge(i)
        every.append(DrawnFigures(limit, values, flags, is_proved, error, confidence))
    reasons = dict(sorted((dict(task.rows.reasons) | task.reasons).items()))
    return DrawVerdicts(tuple(every), drawn, int(task.unstable.sum()), reasons)


@dataclass(frozen=True, eq=False)
class _Task:
    """Draws of a loop as rows; loops about single draws, and reasons why one has no figure, are added when needed."""

    systems: LoopSystems
    rows: LinearRows
    limits: Sequence[FigureLimit]
    loops: dict[int, LoopSystems]
    reasons: dict[int, str]

    def judge(self, place: int) -> tuple[Array, Array, Mask, float]:
        """Figures (N,), flags (N,) and what is proved (N,) of one limit, and the error of its grid that was seen."""
        limit, seen = self.limits[place], ~(self.rows.flagged_rows | self.unstable)
        values, flags = self.estimates.get(limit.kind.name, np.full(len(seen), np.nan)), np.full(len(seen), np.nan)
        flags[self.unstable] = 0.0
        room = np.minimum(values - limit.low, limit.high - values)
        known = seen & np.isfinite(values)
        flags[known] = room[known] >= 0
        nearest = np.argsort(np.where(known, np.abs(room), np.inf), kind="stable")
        ask = (seen & ~known) | np.isin(np.arange(len(seen)), [*nearest[:LOOKED_AT], *nearest[-LOOKED_AT:]]) & seen
        is_proved, error = np.zeros(len(seen), dtype=bool), 0.0
        figures = values.copy()
        while (new := ask & ~is_proved).any():
            for k in np.flatnonzero(new).tolist():
                figures[k], flags[k] = self._proved(k, limit)
            is_proved |= new
            error = float(np.nanmax(np.abs(figures - values), where=known & is_proved, initial=0.0))
            ask = is_proved | (known & (np.abs(room) <= GUARD * error))
        return figures, flags, is_proved, error

    @cached_property
    def unstable(self) -> Mask:
        """(N,), True where the loop has an answer and is not stable."""
        if self.grid is None:
            sound = np.flatnonzero(~self.rows.flagged_rows).tolist()
            return np.isin(np.arange(len(self.rows)), [k for k in sound if not self._loop(k).stable])
        return ~self.rows.stable & ~self.rows.flagged_rows

    @cached_property
    def grid(self) -> RowGrid | None:
        """The frequencies of the estimates; None for a loop with a delay, whose draws are looked at one by one."""
        loop = self.systems.loop
        assert isinstance(loop, LinearLoop)
        return None if loop.models.delays.any() else RowGrid.of(loop, self.systems.answer)

    @cached_property
    def estimates(self) -> Mapping[str, Array]:
        """The figures (N,) on the grid, by name."""
        loop = self.systems.loop
        assert isinstance(loop, LinearLoop)
        names = [limit.kind.name for limit in self.limits]
        return {} if self.grid is None else row_figures(self.rows, names, self.grid, loop)

    def _loop(self, k: int) -> LoopSystems:
        if k not in self.loops:
            point = replace(self.rows.point, x=self.rows.x[k], p=self.rows.p[k])
            self.loops[k] = LoopSystems(linear_loop_about(point), self.systems.answer)
        return self.loops[k]

    def _proved(self, k: int, limit: FigureLimit) -> tuple[float, float]:
        """The figure at a draw and its flag; without a figure the reason is noted."""
        own = self._loop(k)
        figure = LoopFigure(None, why=own.unstable_words) if not own.stable else point_figure(limit.kind.name, own)
        if figure.value is None:
            self.reasons.setdefault(k, figure.why)
            return np.nan, np.nan
        return figure.value.value, FLAGS[limit.judge(figure.value)]


def _with_defaults(layout: Layout, p: Array) -> Layout:
    """The layout with the parameters (np,) of a point as its defaults, of which factors may be shares."""
    values = layout.unpack(p[np.newaxis])
    return Layout(tuple(replace(entry, default=values[entry.name][0]) for entry in layout.entries))


def _in_words(one: Share) -> tuple[str, str]:
    value = "an unknown share" if np.isnan(one.value) else f"{100 * one.value:.1f} %"
    return value, f"{100 * one.low:.1f} to {100 * one.high:.1f} %"
