"""Checkpoints of tunings: each generation is kept in the ledger like the chunks of a sweep, and never run twice."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import inf
from time import monotonic

from workbench.engine.arithmetic import signature
from workbench.study.compiled_sweep import CompiledSweep
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import Ledger, RunCounter, Task, complete
from workbench.study.ledger.study_record import SweepRecord
from workbench.study.tuning.search import TuningSearch, tune
from workbench.study.tuning.tuning_result import TuningResult

SECONDS = 1.0  # between two records of how far the tunings are: each waits for the disk

# The names of the chunks of each sweep that are known, by its name.
Names = dict[str, list[str]]


def tune_in_ledger(
    searches: Sequence[TuningSearch],
    ledger: Ledger,
    execute: Callable[[Sequence[CompiledSweep], Sequence[Task]], Iterator[Chunk]],
    begin: Callable[[], Callable[[int, int, int], None]],
    acknowledge: Callable[[Chunk], None] = lambda chunk: None,
    describe: Callable[[tuple[SweepRecord, ...]], None] = lambda sweeps: None,
) -> tuple[dict[str, TuningResult], tuple[SweepRecord, ...]]:
    """The answer of each tuning, by its name, and its runs as a ledger describes them; none is run twice.

    A search asks for the same points again after it was stopped, and finds its generations by their names.
    """
    names: Names = {one.sweep.name: [] for search in searches for one in search.sweeps}
    counter = RunCounter(sum(_spared(search, names) for search in searches), begin)
    described = -inf

    def evaluate(sweeps: Sequence[CompiledSweep], first: int, last: int) -> list[Chunk]:
        nonlocal described
        tasks = [Task(i, first, last, one.name(first, last)) for i, one in enumerate(sweeps)]
        for one, task in zip(sweeps, tasks, strict=True):
            names[one.sweep.name].append(task.name)
        if monotonic() - described > SECONDS and any(task.name not in ledger for task in tasks):
            describe(about_of_searches(searches, names))
            described = monotonic()
        complete(tasks, ledger, lambda missing: execute(sweeps, missing), counter, acknowledge)
        return [ledger.read(task.name) for task in tasks]

    tuned = {}
    try:
        for search in searches:
            tuned[search.tuning.name] = tune(search, evaluate)
            counter.total -= _spared(search, names)
    finally:
        if described > -inf:
            describe(about_of_searches(searches, names))
    return tuned, about_of_searches(searches, names)


def _spared(search: TuningSearch, names: Names) -> int:
    """The number of runs that a tuning does not need, as searches settled or had few finalists."""
    return sum(one.size - _asked(names[one.sweep.name]) for one in search.sweeps)


def about_of_searches(searches: Sequence[TuningSearch], names: Names) -> tuple[SweepRecord, ...]:
    """The runs of tunings as a ledger describes them; a chunk not known yet has a placeholder as its name."""
    sweeps = []
    for search in searches:
        ended = bool(names[search.finals[0].sweep.name])  # the best are run again once all searches have ended
        for one in search.trials:
            known, size = names[one.sweep.name], search.tuning.population
            runs = _asked(known) if ended else one.size
            sweeps.append(_about(one, known, runs, size, search.tuning.settle is not None and not ended))
        for one in search.finals:
            known = names[one.sweep.name]
            size = _asked(known[:1]) or one.size // search.noises
            sweeps.append(_about(one, known, size * search.noises, size, not ended))
    return tuple(sweeps)


def _about(one: CompiledSweep, known: Sequence[str], runs: int, size: int, at_most: bool) -> SweepRecord:
    coming = (f"{one.sweep.name}/{i}-{i + size}/" for i in range(_asked(known), runs, size))
    return SweepRecord(one.sweep.name, runs, signature(one.arithmetic), (*known, *coming), at_most)


def _asked(names: Sequence[str]) -> int:
    """The number of runs in the chunks of these names, which follow one another."""
    return int(names[-1].split("/")[1].split("-")[1]) if names else 0
