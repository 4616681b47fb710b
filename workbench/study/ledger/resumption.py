"""Resumption: the chunks that a ledger lacks, computed, and each on the disk before it is acknowledged."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import Ledger

# Told the runs that are done, those among them that diverged, and all of them.
Tell = Callable[[int, int, int], None]


class Task(NamedTuple):
    """A chunk to be computed: the number of its sweep, its first run and that behind its last, and its name."""

    sweep: int
    first: int
    last: int
    name: str


class Counter:
    """The counter of runs done, of those that diverged, and of all; `begin` makes the function that is told."""

    def __init__(self, total: int = 0, begin: Callable[[], Tell] = lambda: lambda done, failed, total: None) -> None:
        self.done, self.failed, self.total = 0, 0, total
        self._begin = begin
        self._tell: Tell | None = None

    def add(self, chunk: Chunk) -> None:
        """Count the runs of a chunk."""
        self.done, self.failed = self.done + runs_of(chunk), self.failed + lost(chunk)

    def tell(self) -> None:
        """Tell how far the runs are."""
        self._tell = self._tell or self._begin()
        self._tell(self.done, self.failed, self.total)


def complete(
    tasks: Sequence[Task],
    ledger: Ledger,
    execute: Callable[[Sequence[Task]], Iterator[Chunk]],
    counter: Counter | None = None,
    acknowledge: Callable[[Chunk], None] = lambda chunk: None,
) -> None:
    """Compute the tasks that the ledger lacks, in any order; a chunk is acknowledged once it is on the disk."""
    counter = counter or Counter()
    missing = {task.name: task for task in tasks if task.name not in ledger}
    for task in tasks:
        if task.name in ledger:
            counter.add(ledger.read(task.name))
    if not missing:
        return
    counter.tell()
    for chunk in execute(tuple(missing.values())):
        if missing.pop(chunk.name, None) is None:  # computed twice: the first is kept, as both have the same bits
            continue
        ledger.write_durably(chunk)
        acknowledge(chunk)
        counter.add(chunk)
        counter.tell()
    if missing:
        raise ValueError(f"{len(missing)} chunks were asked for and never came, such as '{next(iter(missing))}'.")


def runs_of(chunk: Chunk) -> int:
    """The number of runs in a chunk."""
    return int(np.size(chunk.arrays().get("diverged_at", ())))


def lost(chunk: Chunk) -> int:
    """The number of runs in a chunk that diverged."""
    return int(np.isfinite(chunk.arrays().get("diverged_at", np.nan)).sum())
