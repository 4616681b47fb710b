"""Do what is missing of the sweeps of a study, chunk by chunk, each on the disk before it is acknowledged."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from workbench.simulate.arithmetic import signature
from workbench.study.ledger.about import SweepAbout
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import Ledger, LedgerError
from workbench.study.prepared import Prepared
from workbench.study.sample import Sample


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
    def about(self) -> tuple[SweepAbout, ...]:
        """The sweeps as a ledger describes them."""
        names = ([task.name for task in self.tasks if task.sweep == i] for i in range(len(self.sweeps)))
        return tuple(map(about_of_sweep, self.sweeps, names))


def about_of_sweep(one: Prepared, chunks: Sequence[str]) -> SweepAbout:
    """A sweep whose chunks have these names, as a ledger describes it."""
    return SweepAbout(one.sweep.name, one.sweep.design.size, signature(one.arithmetic), tuple(chunks))


def in_arithmetic(sweeps: Sequence[Prepared], ledger: Ledger, asked: str | None) -> tuple[Prepared, ...]:
    """The sweeps in the arithmetic that is asked for, or else each in that of its chunks in a ledger.

    Raises
    ------
    LedgerError
        If the chunks of one are of another arithmetic: two do not mix.
    """
    said = ledger.about
    held = {sweep.name: sweep.arithmetic for sweep in said.sweeps} if said else {}
    return tuple(_in_arithmetic(one, held.get(one.sweep.name), ledger, asked) for one in sweeps)


def _in_arithmetic(one: Prepared, kept: str | None, ledger: Ledger, asked: str | None) -> Prepared:
    name = asked or (kept.partition(" ")[0] if kept else one.arithmetic)
    if kept is not None and kept != signature(name):
        raise LedgerError(
            f"The ledger in '{ledger.out}' holds runs of '{one.sweep.name}' in the arithmetic '{kept}', and this run "
            f"would compute in '{signature(name)}': two do not mix. Take the other one by `--arithmetic` or its own "
            "version, name another folder with `--out`, or begin anew with `--fresh`."
        )
    return replace(one, arithmetic=name)


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
    done = total - sum(task.last - task.first for task in missing.values())
    failed = sum(lost(ledger.read(task.name)) for task in plan.tasks if task.name not in missing)
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


def runs_of(chunk: Chunk) -> int:
    """How many runs a chunk has."""
    return int(np.size(chunk.arrays().get("diverged_at", ())))


def lost(chunk: Chunk) -> int:
    """How many runs of a chunk diverged."""
    return int(np.isfinite(chunk.arrays().get("diverged_at", np.nan)).sum())


def samples(plan: Plan, ledger: Ledger) -> tuple[Sample, ...]:
    """The runs of each sweep of a plan, when nothing of it is missing."""
    pairs = zip(plan.sweeps, plan.about, strict=True)
    return tuple(one.sample(map(ledger.read, about.chunks)) for one, about in pairs)
