"""Schedule: which method and which step serve which part of the horizon, the same for all runs of a batch."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import cast

import numpy as np

from workbench.core import Step
from workbench.simulate.divergence import Divergence, find_divergence
from workbench.simulate.job import Job, Progress
from workbench.simulate.marches import arithmetic_of, march_of
from workbench.simulate.request import afford, rows_of, told
from workbench.simulate.trajectories import Trajectories
from workbench.validation.refusals import Array, Integers, finite, seconds, several, whole
from workbench.validation.signatures import answer, door
from workbench.validation.type_hints import KindError, fit_of

# (method, h) -> the step of length h [s] by that method, all with the same states and parameters.
Make = Callable[[str, float], Step]
A_STEP = fit_of(Step)
ROUNDING = 1e-12  # of a step's length, as its maker may have divided a period by a whole number


@dataclass(frozen=True)
@door
class Segment:
    """A method that divides each of a number of consecutive cells into `steps` steps.

    Raises
    ------
    ValueError
        If a number is no positive whole one.
    """

    method: str
    steps: int
    cells: int

    def __post_init__(self) -> None:
        whole("Segment(steps=...)", self.steps)
        whole("Segment(cells=...)", self.cells)


@dataclass(frozen=True)
@door
class Schedule:
    """Consecutive segments from time 0 on, made of cells of one length.

    Every segment so begins at a multiple of its step, which a step that knows its time by its number needs.

    Attributes
    ----------
    cell
        The length of a cell in s.

    Raises
    ------
    ValueError
        If there is no segment, or the cell or the horizon is no positive finite number.
    """

    cell: float
    segments: tuple[Segment, ...]

    def __post_init__(self) -> None:
        several("Schedule(segments=...)", self.segments, Segment, 1)
        seconds("Schedule(cell=...)", self.cell)
        finite("Schedule(cell=..., segments=...)", self.until, " of seconds in all")

    @property
    def cells(self) -> int:
        """The number of cells."""
        return sum(segment.cells for segment in self.segments)

    @property
    def until(self) -> float:
        """The horizon in s."""
        return self.cell * self.cells

    @door
    def h(self, segment: Segment) -> float:
        """The step of a segment, in s."""
        return self.cell / segment.steps

    @property
    def longest(self) -> float:
        """The longest step, in s."""
        return max(map(self.h, self.segments))

    @property
    def halved(self) -> Schedule:
        """The same methods at half of each step."""
        return replace(self, segments=tuple(replace(s, steps=2 * s.steps) for s in self.segments))

    @staticmethod
    @door
    def of(cell: float, choices: Sequence[tuple[str, int]]) -> Schedule:
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


def step_of(call: str, make: Make, method: str, h: float) -> Step:
    """The step that a user's function makes, or a refusal in the name of a call."""

    def fit(given: object) -> Step:
        step: Step = A_STEP(given)
        if abs(step.h - h) > ROUNDING * h:
            raise KindError("", f"one of {step.h:g} s for {h:g} s")
        return step

    must = "be a function of (method, h) that gives a `Step` of length h"
    return cast(Step, answer(f"{call}(make=...)", must, lambda: make(method, h), fit, refuses=True))


@door
def run(
    schedule: Schedule,
    make: Make,
    p: Array | None,
    x0: Array | None,
    every: int | None = None,
    progress: Progress | None = None,
    arithmetic: str | None = None,
) -> Trajectories:
    """Run B copies through a schedule, each with its own parameters p (B, np) from its own state x0 (B, nx).

    What a run gives depends on the schedule and on its own rows alone. The last step of the schedule is the
    step of the trajectories. Rows are checked, and what needs too much memory or time is refused, as
    `simulate` does.

    Parameters
    ----------
    every
        After how many cells a state is kept; without it only the first and the last are.
    progress, arithmetic
        As of `simulate`; the arithmetic is one for all segments.

    Raises
    ------
    ValueError
        If `every` is no divisor of the number of cells, rows are out of their bounds or of a wrong shape, the
        steps are noisy, or the runs would take too much memory or time.
    """
    tell, kept = told("run", progress), _spacing(schedule, every)
    kinds = dict.fromkeys((s.method, s.steps) for s in schedule.segments)
    steps = {(method, n): step_of("run", make, method, schedule.cell / n) for method, n in kinds}
    next(iter(steps.values())).flow.refuse_beyond("run(schedule=...)", schedule.until)
    p, x0 = _checked(schedule, steps, p, x0, schedule.cells // kept)
    x = np.full((len(x0), 1 + schedule.cells // kept, x0.shape[1]), np.nan)
    x[:, 0] = x0
    now, found = np.array(x0), Divergence(np.full(len(x0), np.nan), np.full(len(x0), -1))
    dearest = max(steps.values(), key=lambda step: step.operations)
    rounding = arithmetic_of(dearest, len(x0), arithmetic)
    for part in _parts(schedule, steps, kept):
        left = slice(None) if np.isnan(found.at).all() else np.flatnonzero(np.isnan(found.at))
        rows = _advance(part, left, now, p, found, tell, rounding)
        now[left] = rows[:, -1]
        if part.end % kept == 0:
            last = part.end // kept
            x[left, last - part.rows + 1 : last + 1] = rows[:, 1:]
    job = Job(part.step, p, kept * schedule.segments[-1].steps, 0, np.arange(len(x0)), arithmetic=rounding)
    return Trajectories(job, np.asarray(np.arange(x.shape[1]) * kept * schedule.cell), x, found)


def _spacing(schedule: Schedule, every: int | None) -> int:
    """After how many cells a state is kept."""
    kept = schedule.cells if every is None else whole("run(every=...)", every)
    if schedule.cells % kept:
        raise ValueError(
            f"`run(every=...)` must be a number of cells that divides the schedule's {schedule.cells}; got {every}."
        )
    return kept


def _checked(
    schedule: Schedule, steps: dict[tuple[str, int], Step], p: Array | None, x0: Array | None, kept: int
) -> tuple[Array, Array]:
    """One row a run of parameters and states, or a refusal of what `simulate` would refuse."""
    dearest = max(steps.values(), key=lambda step: step.operations)
    if len({(step.states.labels, step.parameters.labels) for step in steps.values()}) > 1:
        raise ValueError("`run(make=...)` must make steps of one equation; their states or parameters differ.")
    if dearest.noises:
        raise ValueError("`run(make=...)` must make steps without noise: `simulate` runs a noisy one, at one step.")
    rows = rows_of("run", dearest, p, x0)
    work = sum(s.steps * s.cells * steps[s.method, s.steps].operations for s in schedule.segments)
    # as many of the dearest steps as cost the same; what is kept is at hand twice, and two states a run beside it
    afford("run", dearest, rows[0], -(-work // dearest.operations), 2 * kept + 2)
    return rows


@dataclass(frozen=True, eq=False)
class _Part:
    """`rows` times `count` steps from number `first` on, up to the cell `end`: shares `low` to `high` of all work."""

    step: Step
    first: int
    count: int
    rows: int
    end: int
    low: float
    high: float


def _parts(schedule: Schedule, steps: dict[tuple[str, int], Step], kept: int) -> Iterator[_Part]:
    """The segments, cut such that states are kept between equal numbers of steps."""
    costs = [s.steps * steps[s.method, s.steps].operations for s in schedule.segments]
    total = sum(cost * s.cells for cost, s in zip(costs, schedule.segments, strict=True))
    done, spent = 0, 0
    for segment, cost in zip(schedule.segments, costs, strict=True):
        step, end, n = steps[segment.method, segment.steps], done + segment.cells, segment.steps
        while done < end:
            cells = min(end - done, kept - done % kept)
            rows = (end - done) // kept if cells == kept else 1
            stop, after = done + rows * cells, spent + cost * rows * cells
            yield _Part(step, done * n, cells * n, rows, stop, spent / total, after / total)
            done, spent = stop, after


def _advance(
    part: _Part, left: slice | Integers, x: Array, p: Array, found: Divergence, tell: Progress, arithmetic: str
) -> Array:
    """The runs `left` of the states x (B, nx) through a part of the schedule: (b, 1 + rows, nx)."""
    rows = np.repeat(x[left][:, np.newaxis], part.rows + 1, axis=1)
    if len(rows):
        keys = np.arange(len(x))[left]
        job = Job(part.step, p[left], part.count, 0, keys, part.first, arithmetic=arithmetic)
        engine = march_of(job)
        engine(job, rows, lambda share: tell(min(part.low + share * (part.high - part.low), part.high)))
        lost = find_divergence(job, rows, engine)
        found.at[left], found.state[left] = lost.at, lost.state
    tell(part.high)
    return rows


def march(step: Step, x: Array, p: Array, stride: int, arithmetic: str | None) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0], the states at time 0, with those every `stride` steps."""
    job = Job(step, p, stride, 0, np.arange(len(x)), arithmetic=arithmetic_of(step, len(x), arithmetic))
    march_of(job)(job, x, lambda share: None)
