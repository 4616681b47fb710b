"""Job: what a march is asked for, and the pieces that it is cut into."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from workbench.core import Step
from workbench.simulate.kernel.merging import Merged
from workbench.simulate.kernel.noise import normals
from workbench.simulate.kernel.plan import Plan, planned
from workbench.validation.refusals import Array, Integers

# Told the share that is done, now and then.
Progress = Callable[[float], None]
# Fills x (B, 1 + kept, nx) behind x[:, 0] with the states every `stride` steps.
March = Callable[["Job", Array, Progress], None]

STEPS_AT_ONCE = 2_000  # the length of a table of time, which so stays in a cache
BLOCKS_OF_A_LOT = 64
STEPS_OF_A_STAGE = 8_000_000  # of all runs of a lot and 500 operations, between two looks at progress: half a second
PAIRS = 2  # runs that leave every second lane of the narrowest vector to a step of twice the length
NUMBERS_OF_A_STAGE = 1_000_000  # of kept states in a lot, which are turned run by run when it is done


class Alike(NamedTuple):
    """Several steps that are run by one graph.

    Attributes
    ----------
    varied
        The parameters of the graph that vary.
    places
        Where the states of each step are among those of the graph.
    which
        Of which step each run is, (B,).
    """

    merged: Merged
    varied: tuple[int, ...]
    places: tuple[Integers, ...]
    which: Integers


@dataclass(frozen=True, eq=False)
class Job:
    """Runs of one step, from its step number `begin` on, with their states kept every `stride` steps.

    Attributes
    ----------
    p
        (B, np).
    seed, runs
        The keys of their noise: a whole number, and one for each run, (B,).
    paired
        Whether every second run takes steps of twice the length, of which the stride is a whole number.
    ahead
        How many steps are still to come when it is done: the longer, the better its code should be.
    alike
        For runs that share their march with those of other steps: how; p may have zeros at its end.
    arithmetic
        How the operations are rounded: 'fused', 'portable' or 'casadi'.
    """

    step: Step
    p: Array
    stride: int
    seed: int
    runs: Integers
    begin: int = 0
    paired: bool = False
    alike: Alike | None = None
    ahead: int = 0
    arithmetic: str = "fused"

    @property
    def plan(self) -> Plan:
        """The plan of its kernel."""
        if self.alike is None:
            return Plan.of_step(self.step, self.varied)
        return planned(self.alike.merged.graph, self.alike.varied)

    @property
    def rows(self) -> Array:
        """The parameters of its kernel, a row a run."""
        return self.p if self.alike is None else self.alike.merged.rows(self.p, self.alike.which)

    @property
    def size(self) -> int:
        """How many states its kernel has."""
        return self.step.states.size if self.alike is None else len(self.alike.merged.graph.results)

    @property
    def places(self) -> Integers:
        """Where the states of its step are among them, where all runs are of one step."""
        return np.arange(self.size) if self.alike is None else self.alike.places[self.alike.which[0]]

    @property
    def fused(self) -> bool:
        """Whether a product is rounded together with the sum that it is for."""
        return self.arithmetic == "fused"

    @cached_property
    def varied(self) -> tuple[int, ...]:
        """The parameters that are not the same in all runs."""
        return differing(self.p)

    def part(self, chosen: Integers, stride: int, begin: int) -> Job:
        """Some of the runs, from another step on."""
        alike = self.alike and self.alike._replace(which=self.alike.which[chosen])
        return replace(self, p=self.p[chosen], runs=self.runs[chosen], stride=stride, begin=begin, alike=alike)

    def check(self, x: Array) -> None:
        """Refuse what a march would read or fill beyond its ends."""
        shapes = (self.p.shape, self.runs.shape, x.shape[:1], x.shape[2:])
        size = self.step.parameters.size if self.alike is None else self.p.shape[1]
        states = self.size if self.alike is not None and x.shape[2] == self.size else self.step.states.size
        wanted = ((len(x), size), (len(x),), (len(x),), (states,))
        if shapes != wanted or self.p.dtype != float or x.dtype != float or self.runs.dtype != np.int64:
            raise ValueError(
                f"`march(job, x)` takes x (B, 1 + kept, {self.step.states.size}) and p (B, "
                f"{self.step.parameters.size}) of floats, and B keys; got {x.shape} of {x.dtype}, {self.p.shape} of "
                f"{self.p.dtype} and {self.runs.shape} of {self.runs.dtype}."
            )

    def noise(self, steps: Integers) -> Array:
        """The normal numbers of some steps (N,), each by its number: (B, N, nw)."""
        return normals(self.seed, self.runs, steps, self.step.noises)


def differing(rows: Array) -> tuple[int, ...]:
    """The columns in which not all rows (B, n) have the same bits."""
    bits = rows.view(np.uint64)  # 0 and -0 are two numbers
    return tuple(int(i) for i in np.flatnonzero((bits != bits[:1]).any(axis=0)))


class Piece(NamedTuple):
    """What one table of time serves: `rows` rows of x from `row` on, `steps` steps each, from the step `begin`.

    It goes on from the states in row `start`: those before its first, or those that a piece before it left there;
    `whole` says whether its last row is done, or left for the next piece.
    """

    rows: int
    steps: int
    begin: int
    row: int
    start: int
    whole: bool = True

    @property
    def length(self) -> int:
        """How many steps it has."""
        return self.rows * self.steps


def pieces(job: Job, kept: int, most_rows: int = STEPS_AT_ONCE) -> Iterator[Piece]:
    """The job in pieces; a stride longer than a table is made of several, which leave their states in its row."""
    stride, begin = job.stride, job.begin
    if stride <= STEPS_AT_ONCE:
        most = min(STEPS_AT_ONCE // stride, most_rows)
        for row in range(0, kept, most):
            yield Piece(min(most, kept - row), stride, begin + row * stride, row + 1, row)
        return
    for row in range(kept):
        for k in range(0, stride, STEPS_AT_ONCE):
            steps = min(STEPS_AT_ONCE, stride - k)
            yield Piece(1, steps, begin + row * stride + k, row + 1, row + (k > 0), k + steps == stride)


def stages(job: Job, kept: int, runs: int) -> Iterator[list[Piece]]:
    """The pieces that lots of so many runs go through without a look at progress, and with room for their rows."""
    work = max(1, job.step.operations // 500)
    most_steps = STEPS_OF_A_STAGE // (runs * work)
    most_rows = max(1, NUMBERS_OF_A_STAGE // (runs * job.step.states.size))
    stage: list[Piece] = []
    steps = rows = 0
    for piece in pieces(job, kept, most_rows):
        steps, rows = steps + piece.length, rows + piece.rows
        if stage and (steps > most_steps or rows > most_rows):
            yield stage
            stage, steps, rows = [], piece.length, piece.rows
        stage.append(piece)
    yield stage


def lots(job: Job, width: int) -> list[slice]:
    """The runs in lots of whole blocks, enough of them for all threads."""
    blocks = -(-len(job.p) // width)
    size = width * min(BLOCKS_OF_A_LOT, -(-blocks // threads()))
    return [slice(first, first + size) for first in range(0, len(job.p), size)]


@contextmanager
def crew(blocks: int) -> Iterator[Callable[..., Iterable[Any]]]:
    """What calls a function for each lot of the blocks: threads side by side, or nobody else for a single block."""
    if blocks == 1:
        yield map
        return
    pool = ThreadPoolExecutor(threads())
    try:
        yield pool.map
    finally:
        pool.shutdown(cancel_futures=True)


def threads() -> int:
    """How many threads march: one for each processor this process may use, or fewer if that was asked for."""
    affinity = getattr(os, "sched_getaffinity", None)
    return _asked.get() or (len(affinity(0)) if affinity else os.cpu_count() or 1)


def use_threads(count: int | None) -> None:
    """Let marches that begin in this thread, or in this context, take so many threads; None for all processors."""
    _asked.set(count)


_asked: ContextVar[int | None] = ContextVar("threads", default=None)
