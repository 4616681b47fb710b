"""The cost of sweeps and works before they start: time, memory and disk; those that need too much are refused."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, inf
from pathlib import Path

from workbench.engine.arithmetic import is_compiled
from workbench.engine.job import threads
from workbench.study.compiled_sweep import CompiledSweep
from workbench.study.run_options import StudyOptions
from workbench.study.study_works import GUESS, CompiledWork

PATIENCE = 3600.0  # s
MEMORY = 4 * 2**30  # bytes
COPIES = 8  # of all results, while a report is written: in two kinds of arrays, and as text, of 20 characters a number
ON_DISK = 6  # the ledger, and the text of the earlier report and of the new one
STATE_COPIES = 2  # copies of the states of cases, which pages draw: as read, and as arrays
CHUNKS = 4  # in memory at once: two that are marched, one that waits, one that is written
SECONDS_OF_CHUNK = 0.01  # beside its runs: it is named, written, and forced to the disk
SECONDS_OF_NUMBER = 2e-6  # of a table: it is drawn or measured, and written as text by one thread
# How many times longer a step takes where it is not compiled: NumPy makes a fused product of some fifty operations.
SLOWER = {"fused": 2500, "portable": 100, "casadi": 100}
BYTES_OF_ITEM = 10_000  # of a record on the disk
PROGRAM = 200 * 2**20  # bytes of the workbench itself


@dataclass(frozen=True)
class Cost:
    """The cost of runs and of items of works: s on so many threads, and bytes of memory and disk."""

    runs: int
    threads: int
    seconds: float
    memory: float
    disk: float
    items: int = 0
    guesses: int = 0  # items whose time nobody states

    def __str__(self) -> str:
        counts = {"runs": self.runs, "items of works": self.items}
        pieces = " and ".join(f"{count:,} {unit}" for unit, count in counts.items() if count) or "0 runs"
        guess = f", with a guess of {GUESS:g} s for each of {self.guesses:,} items" if self.guesses else ""
        most = "at most about" if self.runs else "about"
        return (
            f"{pieces}: {most} {_time(self.seconds)} on {self.threads} threads{guess}, "
            f"{_size(self.memory)} of memory, {_size(self.disk)} on the disk"
        )


def cost_of(sweeps: Sequence[CompiledSweep], workers: int | None = None, works: Sequence[CompiledWork] = ()) -> Cost:
    """A cautious estimate of all runs of some sweeps and items of works, as if none of them were done."""
    side = workers or threads()
    seconds = results = chunk = kept = 0.0
    for one in sweeps:
        times = len(one.run.times)
        values, factors = len(one.columns) * times, len(one.sweep.factors)
        cells = times * (3 + factors) + 2 * values  # of the table
        results += 8 * one.size * (factors + 1 + values * (1 + 1 / (one.sweep.half_step_every or inf)))
        seconds += one.size * (one.cost.seconds * _slower(one) / side + SECONDS_OF_NUMBER * cells)
        seconds += SECONDS_OF_CHUNK * ceil(one.size / one.runs_of_chunk)
        chunk = max(chunk, min(one.runs_of_chunk, one.size) * one.cost.bytes)
        kept += one.size * one.cost.bytes if one.format.keeps else 0
    for work in works:
        seconds += work.seconds_of_item * ceil(work.size / side) + SECONDS_OF_CHUNK * work.size
    runs, items = sum(one.size for one in sweeps), sum(work.size for work in works)
    guesses = sum(work.size for work in works if work.work.seconds is None)
    memory = PROGRAM + CHUNKS * chunk + COPIES * results + STATE_COPIES * kept
    return Cost(runs, side, seconds, memory, ON_DISK * results + kept + BYTES_OF_ITEM * items, items, guesses)


def afford(sweeps: Sequence[CompiledSweep], works: Sequence[CompiledWork], out: Path, order: StudyOptions) -> None:
    """Refuse sweeps and works that take too much time, memory or disk, unless the order is sure of them."""
    if not (order.yes or order.only_report):
        check(cost_of(sweeps, order.workers, works), out)


def slow(sweeps: Sequence[CompiledSweep]) -> Iterator[str]:
    """A sentence for each arithmetic of some sweeps that is not compiled here."""
    for name, times in {one.arithmetic: _slower(one) for one in sweeps}.items():
        if times > 1:
            yield f"The arithmetic '{name}' is not compiled here: the same bits take some {times:,} times longer."


def _slower(one: CompiledSweep) -> int:
    return 1 if is_compiled(one.run.step, one.arithmetic) else SLOWER[one.arithmetic]


def check(cost: Cost, out: Path) -> None:
    """Refuse sweeps that take more than an hour, 4 GB of memory, or half of the disk that is free."""
    place = next(path for path in (out.resolve(), *out.resolve().parents) if path.exists())
    free = shutil.disk_usage(place).free / 2
    limits = (
        (cost.seconds, PATIENCE, _time(PATIENCE), "time"),
        (cost.memory, MEMORY, _size(MEMORY), "memory"),
        (cost.disk, free, f"{_size(free)}, half of what is free", "disk"),
    )
    for needed, limit, said, what in limits:
        if needed > limit:
            raise ValueError(
                f"{cost}. That is more {what} than is taken without being asked for ({said}): "
                "take fewer samples with `--samples`, or say `--yes`."
            )


def _time(seconds: float) -> str:
    for unit, name in ((86400.0, "days"), (3600.0, "hours"), (60.0, "minutes")):
        if seconds >= 2 * unit:
            return f"{seconds / unit:,.0f} {name}"
    return f"{max(1, round(seconds))} s"


def _size(size: float) -> str:
    return f"{size / 2**30:,.1f} GB" if size >= 2**30 else f"{max(1, round(size / 2**20))} MB"
