"""Job: the runs and times that a march computes, and their division into pieces of time and lots of runs."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from workbench.core import StepMap
from workbench.core.validation.refusals import Array, Integers
from workbench.engine.kernel.noise import normals
from workbench.engine.kernel.plan import KernelPlan

# Told the share that is done, now and then.
Progress = Callable[[float], None]
# Fills x (B, 1 + kept, nx) behind x[:, 0] with the states every `stride` steps.
March = Callable[["Job", Array, Progress], None]

STEPS_AT_ONCE = 2_000  # the length of a table of time, which so stays in a cache
BLOCKS_OF_A_LOT = 64
STEPS_OF_A_STAGE = 8_000_000  # of all runs of a lot and 500 operations, between two looks at progress: half a second
NUMBERS_OF_A_STAGE = 1_000_000  # of kept states in a lot, which are turned run by run when it is done
LOOK = 0.5  # s between two looks at futures


@dataclass(frozen=True, eq=False)
class Job:
    """Runs of one step, from its step number `begin` on, with their states kept every `stride` steps."""

    step: StepMap
    p: Array  # (B, np)
    stride: int
    seed: int
    runs: Integers  # (B,), with the seed the keys of their noise
    begin: int = 0
    arithmetic: str = "fused"

    @property
    def plan(self) -> KernelPlan:
        """The plan of its kernel."""
        return KernelPlan.of_step(self.step, self.varied_parameters, self.has_switches)

    @cached_property
    def has_switches(self) -> bool:
        """True if some run may have a switch within a step."""
        segments = self.step.rule.segments
        return segments is not None and segments.can_occur(self.p)

    @property
    def fused_products(self) -> bool:
        """True if a product is rounded together with the sum that it is for."""
        return self.arithmetic == "fused"

    @cached_property
    def varied_parameters(self) -> tuple[int, ...]:
        """The parameters that have not the same bits in all runs."""
        bits = self.p.view(np.uint64)  # 0 and -0 are two numbers
        return tuple(int(i) for i in np.flatnonzero(bits.min(axis=0) != bits.max(axis=0)))

    def part(self, places: Integers, stride: int, begin: int) -> Job:
        """The job of some of the runs, from another step on."""
        return replace(self, p=self.p[places], runs=self.runs[places], stride=stride, begin=begin)

    def check(self, x: Array) -> None:
        """Refuse a job in which a march would read or write beyond the end of an array."""
        shapes = (self.p.shape, self.runs.shape, x.shape[:1], x.shape[2:])
        wanted = ((len(x), self.step.parameters.size), (len(x),), (len(x),), (self.step.states.size,))
        if shapes != wanted or self.p.dtype != float or x.dtype != float or self.runs.dtype != np.int64:
            raise ValueError(
                f"`march(job, x)` takes x (B, 1 + kept, {self.step.states.size}) and p (B, "
                f"{self.step.parameters.size}) of floats, and B keys; got {x.shape} of {x.dtype}, {self.p.shape} of "
                f"{self.p.dtype} and {self.runs.shape} of {self.runs.dtype}."
            )
        rows, last = self.step.recorded_numbers, self.begin + (x.shape[1] - 1) * self.stride
        if rows is not None and last > len(rows):
            raise ValueError(f"`march(job, x)` must end at step {len(rows)}, the last one recorded; got {last}.")

    @cached_property
    def record(self) -> Array:
        """The recorded numbers of the steps, (N, nd), row by row in memory."""
        rows = self.step.recorded_numbers
        return np.empty((0, 0)) if rows is None else np.ascontiguousarray(rows)

    def noise(self, steps: Integers) -> Array:
        """The normal numbers of some steps (N,), each by its number: (B, N, nw)."""
        return normals(self.seed, self.runs, steps, self.step.noises)


class JobPiece(NamedTuple):
    """Rows of x that share one table of time: `rows` of them from `row` on, `steps` steps each, from step `begin`.

    It goes on from the states in row `start`; `whole` says whether its last row is done, or left for the next piece.
    """

    rows: int
    steps: int
    begin: int
    row: int
    start: int
    whole: bool = True

    @property
    def length(self) -> int:
        """The number of its steps."""
        return self.rows * self.steps


def pieces(job: Job, kept_rows: int, most_rows: int = STEPS_AT_ONCE) -> Iterator[JobPiece]:
    """The job in pieces; a stride longer than a table is made of several, which leave their states in its row."""
    stride, begin = job.stride, job.begin
    if stride <= STEPS_AT_ONCE:
        most = min(STEPS_AT_ONCE // stride, most_rows)
        for row in range(0, kept_rows, most):
            yield JobPiece(min(most, kept_rows - row), stride, begin + row * stride, row + 1, row)
        return
    for row in range(kept_rows):
        for k in range(0, stride, STEPS_AT_ONCE):
            steps = min(STEPS_AT_ONCE, stride - k)
            yield JobPiece(1, steps, begin + row * stride + k, row + 1, row + (k > 0), k + steps == stride)


def stages(job: Job, kept_rows: int, runs: int) -> Iterator[list[JobPiece]]:
    """The pieces that lots of so many runs go through without a look at progress, and with room for their rows."""
    work = max(1, job.step.operations // 500)
    most_steps = STEPS_OF_A_STAGE // (runs * work)
    most_rows = max(1, NUMBERS_OF_A_STAGE // (runs * job.step.states.size))
    stage: list[JobPiece] = []
    steps = rows = 0
    for piece in pieces(job, kept_rows, most_rows):
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


T = TypeVar("T")
R = TypeVar("R")


class Map(Protocol):
    """A function as `map` is, which may work side by side."""

    def __call__(self, work: Callable[[T], R], lots: Iterable[T], /) -> Iterable[R]:
        """The results of the work for each lot, in their order."""


@contextmanager
def parallel_map(blocks: int) -> Iterator[Map]:
    """A `map` over so many blocks: by threads side by side, or the plain one for a single block."""
    if blocks == 1:
        yield map
        return
    pool = ThreadPoolExecutor(threads())
    try:
        yield pool.map
    finally:
        pool.shutdown(cancel_futures=True)


def wait_for_futures(futures: Collection[Future[T]]) -> set[Future[T]]:
    """Those that are done when all are, or one has failed; Windows tells of Ctrl-C only between two waits."""
    while True:
        done, rest = wait(futures, LOOK, FIRST_EXCEPTION)
        if not rest or any(future.exception() for future in done):
            return done


def threads() -> int:
    """The number of threads that march: the processors this process may use, or fewer if that was asked for."""
    affinity = getattr(os, "sched_getaffinity", None)
    return _thread_count.get() or (len(affinity(0)) if affinity else os.cpu_count() or 1)


def use_threads(count: int | None) -> None:
    """Let marches that begin in this thread, or in this context, take so many threads; None for all processors."""
    _thread_count.set(count)


def set_stop_check(check: Callable[[], None]) -> None:
    """Let marches that begin in this thread, or in this context, call a function now and then: its error ends them."""
    _token.set(check)


def stop_check() -> Callable[[], None]:
    """The function that a march calls now and then, by whose error it ends."""
    return _token.get()


def _go_on() -> None:
    """The token of a march that nobody ends."""


_thread_count: ContextVar[int | None] = ContextVar("threads", default=None)
_token: ContextVar[Callable[[], None]] = ContextVar("token", default=_go_on)
