"""Schedule: which method and which step serve which part of the horizon, the same for all runs of a batch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from workbench.core import Step
from workbench.core.numbers import Array
from workbench.simulate.batch import march_of
from workbench.simulate.divergence import Divergence, find_divergence
from workbench.simulate.job import Job
from workbench.simulate.trajectories import Trajectories

# (method, h) -> the step of length h [s] by that method, all with the same states and parameters.
Make = Callable[[str, float], Step]


@dataclass(frozen=True)
class Segment:
    """A method that divides each of a number of consecutive cells into `steps` steps."""

    method: str
    steps: int
    cells: int


@dataclass(frozen=True)
class Schedule:
    """Consecutive segments from time 0 on, made of cells of one length.

    Every segment so begins at a multiple of its step, which a step that knows its time by its number needs.

    Attributes
    ----------
    cell
        The length of a cell in s.
    """

    cell: float
    segments: tuple[Segment, ...]

    @property
    def cells(self) -> int:
        """The number of cells."""
        return sum(segment.cells for segment in self.segments)

    @property
    def until(self) -> float:
        """The horizon in s."""
        return self.cell * self.cells

    def h(self, segment: Segment) -> float:
        """The step of a segment, in s."""
        return self.cell / segment.steps

    @property
    def halved(self) -> Schedule:
        """The same methods at half of each step."""
        return replace(self, segments=tuple(replace(s, steps=2 * s.steps) for s in self.segments))

    @staticmethod
    def of(cell: float, choices: list[tuple[str, int]]) -> Schedule:
        """The schedule of one (method, steps) a cell, equal neighbours as one segment."""
        return Schedule(cell, tuple(Segment(*choice, len(list(same))) for choice, same in groupby(choices)))

    def __str__(self) -> str:
        """One line a segment: its time, method and step."""
        lines, begin = [], 0
        for segment in self.segments:
            end = begin + segment.cells
            span = f"{begin * self.cell:g} to {end * self.cell:g} s"
            lines.append(f"{span}: {segment.method}, {1000 * self.h(segment):g} ms")
            begin = end
        return "\n".join(lines)


def run(schedule: Schedule, make: Make, p: Array, x0: Array, every: int | None = None) -> Trajectories:
    """Run B copies through a schedule, each with its own parameters p (B, np) from its own state x0 (B, nx).

    What a run gives depends on the schedule and on its own rows alone. The last step of the schedule is the
    step of the trajectories.

    Parameters
    ----------
    every
        After how many cells a state is kept; without it only the first and the last are.

    Raises
    ------
    ValueError
        If `every` is no divisor of the number of cells.
    """
    kept = every or schedule.cells
    if kept < 1 or schedule.cells % kept:
        raise ValueError(
            f"`run(every=...)` must be a number of cells that divides the schedule's {schedule.cells}; got {every}."
        )
    x = np.full((len(x0), 1 + schedule.cells // kept, x0.shape[1]), np.nan)
    x[:, 0] = x0
    now, found = np.array(x0), Divergence(np.full(len(x0), np.nan), np.full(len(x0), -1))
    done = 0
    for segment in schedule.segments:
        step, end = make(segment.method, schedule.h(segment)), done + segment.cells
        while done < end:
            stop = min(end, done - done % kept + kept)
            _advance(step, now, p, found, done * segment.steps, (stop - done) * segment.steps)
            done = stop
            if done % kept == 0:
                x[:, done // kept] = now
    job = Job(step, p, kept * segment.steps, 0, np.arange(len(x0)))
    return Trajectories(job, np.asarray(np.arange(x.shape[1]) * kept * schedule.cell), x, found)


def _advance(step: Step, x: Array, p: Array, found: Divergence, first: int, count: int) -> None:
    """Put the states x (B, nx) of the runs that did not diverge before `count` steps ahead, from number `first` on."""
    left = np.isnan(found.at)
    chosen = slice(None) if left.all() else np.flatnonzero(left)
    rows = np.stack([x[chosen]] * 2, axis=1)
    if len(rows):
        job = Job(step, p[chosen], count, 0, np.arange(len(x))[chosen], first)
        engine = march_of(job)
        engine(job, rows, lambda share: None)
        lost = find_divergence(job, rows, engine)
        x[chosen], found.at[chosen], found.state[chosen] = rows[:, 1], lost.at, lost.state


def march(step: Step, x: Array, p: Array, stride: int) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0], the states at time 0, with those every `stride` steps."""
    job = Job(step, p, stride, 0, np.arange(len(x)))
    march_of(job)(job, x, lambda share: None)
