"""Do what is missing of the sweeps of a study, chunk by chunk, each on the disk before it is acknowledged."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from workbench.study.chunk import Chunk
from workbench.study.prepared import Prepared
from workbench.study.sample import Sample, sample_of
from workbench.study.store import Ledger


class Task(NamedTuple):
    """A chunk to be computed: the number of its sweep, its first run and that behind its last, and its name."""

    sweep: int
    first: int
    last: int
    name: str


# Computes tasks in any order, some perhaps twice.
Execute = Callable[[Sequence[Task]], Iterator[Chunk]]


class State(NamedTuple):
    """How far a study is: runs done, among them those that diverged, and all of them."""

    done: int
    failed: int
    total: int


@dataclass(frozen=True, eq=False)
class Plan:
    """All chunks of some sweeps."""

    sweeps: tuple[Prepared, ...]
    tasks: tuple[Task, ...]

    @property
    def said(self) -> list[dict[str, Any]]:
        """What the ledger says of each sweep, enough to put its sample together."""
        names = ([task.name for task in self.tasks if task.sweep == i] for i in range(len(self.sweeps)))
        return list(map(said_of, self.sweeps, names))


def said_of(one: Prepared, chunks: Sequence[str]) -> dict[str, Any]:
    """What the ledger says of a sweep whose chunks have these names."""
    return {
        "name": one.sweep.name,
        "runs": one.sweep.design.size,
        "factors": [factor.name for factor in one.sweep.factors],
        "columns": one.columns,
        "every": one.every,
        "h": one.sweep.h,
        "seed": one.sweep.seed,
        "halved": one.sweep.halved,
        "fingerprint": one.fingerprint,
        "chunks": list(chunks),
    }


def planned(sweeps: Sequence[Prepared]) -> Plan:
    """The chunks of some sweeps, each with its name; whatever is wrong with the numbers of a run is refused here."""
    tasks = [Task(i, *ends, one.name(*ends)) for i, one in enumerate(sweeps) for ends in one.chunks]
    return Plan(tuple(sweeps), tuple(tasks))


def complete(
    plan: Plan,
    ledger: Ledger,
    execute: Execute,
    tell: Callable[[State], None] = lambda state: None,
    acknowledge: Callable[[Chunk], None] = lambda chunk: None,
) -> None:
    """Compute the chunks that the ledger does not hold; each is acknowledged once it is on the disk."""
    missing = {task.name: task for task in plan.tasks if task.name not in ledger}
    total = sum(one.sweep.design.size for one in plan.sweeps)
    done, failed = total - sum(task.last - task.first for task in missing.values()), 0
    tell(State(done, failed, total))
    for chunk in execute(tuple(missing.values())):
        task = missing.pop(chunk.name, None)
        if task is None:  # computed twice: the first of them is kept, as both have the same bits
            continue
        ledger.add(chunk)
        acknowledge(chunk)
        done, failed = done + task.last - task.first, failed + lost(chunk)
        tell(State(done, failed, total))
    if missing:
        raise ValueError(f"{len(missing)} chunks were asked for and never came, such as '{next(iter(missing))}'.")


def lost(chunk: Chunk) -> int:
    """How many runs of a chunk diverged."""
    return int(np.isfinite(chunk.arrays()["diverged_at"]).sum())


def samples(plan: Plan, ledger: Ledger) -> tuple[Sample, ...]:
    """What each sweep of a plan gave, when nothing of it is missing."""
    found = (sample_of(said, map(ledger.read, said["chunks"])) for said in plan.said)
    return tuple(replace(one, design=of.sweep.design) for one, of in zip(found, plan.sweeps, strict=True))


def samples_of(said: Iterable[dict[str, Any]], chunks: dict[str, Chunk]) -> tuple[Sample, ...]:
    """The same from what a ledger says and holds; sweeps of which a chunk is missing are left out."""
    whole = (one for one in said if all(name in chunks for name in one["chunks"]))
    return tuple(sample_of(one, [chunks[name] for name in one["chunks"]]) for one in whole)
