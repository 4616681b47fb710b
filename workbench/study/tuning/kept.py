"""The tunings of a study in its ledger: each generation is kept like the chunks of a sweep, and never done twice."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from time import monotonic

from workbench.study.ledger.about import SweepAbout
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.resume import State, Task, about_of_sweep, lost
from workbench.study.ledger.store import Ledger
from workbench.study.prepared import Prepared
from workbench.study.tuning.ready import Ready
from workbench.study.tuning.search import tune
from workbench.study.tuning.tuned import Tuned

SECONDS = 1.0  # between two records of how far the tunings are: each waits for the disk

# Computes some chunks of some sweeps.
Execute = Callable[[Sequence[Prepared], Sequence[Task]], Iterator[Chunk]]
# The names of the chunks of each sweep that are known, by its name.
Names = dict[str, list[str]]


def complete(
    tunings: Sequence[Ready],
    ledger: Ledger,
    execute: Execute,
    begin: Callable[[], Callable[[State], None]],
    acknowledge: Callable[[Chunk], None] = lambda chunk: None,
    describe: Callable[[tuple[SweepAbout, ...]], None] = lambda sweeps: None,
) -> tuple[dict[str, Tuned], tuple[SweepAbout, ...]]:
    """The answer of each tuning, by its name, and its runs as a ledger describes them; none is run twice.

    A search asks for the same points again after it was stopped, and finds its generations by their names.

    Parameters
    ----------
    begin
        Called once if something is to be computed; it gives what is told how far the tunings are.
    describe
        Told what the ledger should say: first, now and then, and when the tunings are done or stopped.
    """
    names: Names = {one.sweep.name: [] for made in tunings for one in _sweeps(made)}
    total, done, failed = sum(_spared(made, names) for made in tunings), 0, 0
    tell: Callable[[State], None] | None = None
    describe_seldom = _seldom(lambda: describe(about_of_tunings(tunings, names)))

    def evaluate(sweeps: Sequence[Prepared], first: int, last: int) -> list[Chunk]:
        nonlocal done, failed, tell
        tasks = _tasks(sweeps, first, last, names)
        missing = [task for task in tasks if task.name not in ledger]
        if missing:
            tell = tell or begin()
            tell(State(done, failed, total))
            describe_seldom()
            for chunk in execute(sweeps, missing):
                ledger.add(chunk)
                acknowledge(chunk)
        chunks = [ledger.read(task.name) for task in tasks]
        done, failed = done + len(sweeps) * (last - first), failed + sum(map(lost, chunks))
        return chunks

    found = {}
    try:
        for made in tunings:
            found[made.tuning.name] = tune(made, evaluate)
            total -= _spared(made, names)
    finally:
        if tell:
            describe(about_of_tunings(tunings, names))
    return found, about_of_tunings(tunings, names)


def _spared(made: Ready, names: Names) -> int:
    """How many runs a tuning did without, as its searches had settled or had few points to run again."""
    return sum(one.sweep.design.size - _asked(names[one.sweep.name]) for one in _sweeps(made))


def _tasks(sweeps: Sequence[Prepared], first: int, last: int, names: Names) -> list[Task]:
    """The same runs of each sweep; their names are known from now on."""
    tasks = [Task(i, first, last, one.name(first, last)) for i, one in enumerate(sweeps)]
    for one, task in zip(sweeps, tasks, strict=True):
        names[one.sweep.name].append(task.name)
    return tasks


def _seldom(call: Callable[[], None]) -> Callable[[], None]:
    """A call that does nothing while the last one is less than a second old."""
    last = -SECONDS

    def called() -> None:
        nonlocal last
        if monotonic() - last > SECONDS:
            call()
            last = monotonic()

    return called


def replayed(made: Ready, chunks: Mapping[str, Chunk]) -> Tuned:
    """What a tuning found whose chunks are all here, by their names.

    Raises
    ------
    KeyError
        If one is not.
    """

    def evaluate(sweeps: Sequence[Prepared], first: int, last: int) -> list[Chunk]:
        return [chunks[one.name(first, last)] for one in sweeps]

    return tune(made, evaluate)


def about_of_tunings(tunings: Sequence[Ready], names: Names) -> tuple[SweepAbout, ...]:
    """The runs of tunings as a ledger describes them; a chunk that nobody knows yet has a name that none has."""
    sweeps = []
    for made in tunings:
        searched = bool(names[made.halves[0].sweep.name])  # the best are run again once all searches have ended
        for one in made.trials:
            known, size = names[one.sweep.name], made.tuning.population
            runs = _asked(known) if searched else made.tuning.size
            sweeps.append(_about(one, known, runs, size, made.tuning.settle is not None and not searched))
        for one in made.halves:
            known = names[one.sweep.name]
            size = _asked(known[:1]) or one.sweep.design.size // made.noises
            sweeps.append(_about(one, known, size * made.noises, size, not searched))
    return tuple(sweeps)


def _about(one: Prepared, known: Sequence[str], runs: int, size: int, at_most: bool) -> SweepAbout:
    """A sweep of so many runs, as many in a chunk, of which some chunks are known."""
    coming = (f"{one.sweep.name}/{i}-{i + size}/" for i in range(_asked(known), runs, size))
    return replace(about_of_sweep(one, [*known, *coming]), runs=runs, at_most=at_most)


def _asked(names: Sequence[str]) -> int:
    """How many runs the chunks of these names have, which follow one another."""
    return int(names[-1].split("/")[1].split("-")[1]) if names else 0


def _sweeps(made: Ready) -> tuple[Prepared, ...]:
    return (*made.trials, *made.halves)
