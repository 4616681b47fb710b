"""Sweep: many runs of one loop over factors, cut into chunks that anyone can compute from their numbers alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.metrics import AbstractMetric
from workbench.study.cells import check_name
from workbench.study.contract import Loop, check_loop
from workbench.study.factors import Factor
from workbench.study.sampling import AbstractDesign
from workbench.validation.doors import door
from workbench.validation.words import Integers, multiple, seconds, seed, whole

HALVED = 16
COLUMNS = ("run", "t [s]", "diverged at [s]")  # of a table of runs, beside factors and metrics


@dataclass(frozen=True, eq=False)
@door
class Sweep:
    """Runs of one loop, whose factors take the values that a design says.

    Attributes
    ----------
    name
        Lower-case letters, digits and underscores: it becomes the name of a file.
    design
        A point of the unit cube a run, one coordinate a factor.
    h, until, every
        Step, horizon and distance of the times at which metrics are taken, in s, each a multiple of the one before
        it; without `every` they are taken at the horizon alone. Values are those at the step h.
    seed
        Of the noise.
    common
        Whether all runs have the same noise; else it is each run's own.
    halved
        One run of so many is run again at h / 2, for the error of the step: those whose number it divides. None for
        no run.
    runs_of_chunk
        How many runs are computed and kept together; without it about as many as take a second or two of one processor.
    """

    name: str
    loop: Loop
    metrics: tuple[AbstractMetric, ...]
    factors: tuple[Factor, ...]
    design: AbstractDesign
    h: float
    until: float
    every: float | None = None
    seed: int = 0
    common: bool = False
    halved: int | None = HALVED
    runs_of_chunk: int | None = None

    def __post_init__(self) -> None:
        check_name("Sweep", self.name)
        check_loop(f"Sweep({self.name!r}, loop=...)", self.loop)
        if self.design.dimensions != len(self.factors):
            raise ValueError(
                f"`Sweep({self.name!r}, design=...)` must have as many dimensions as there are factors, "
                f"{len(self.factors)}; got {self.design.dimensions}."
            )
        if taken := [factor.name for factor in self.factors if factor.name in COLUMNS]:
            raise ValueError(
                f"`Sweep({self.name!r}, factors=...)` needs another name for {taken}: tables have that column."
            )
        if not self.metrics:
            raise ValueError(f"`Sweep({self.name!r}, metrics=...)` needs at least one metric; got none.")
        check_times("Sweep", self.name, self.h, self.until, self.every)
        seed("Sweep(seed=...)", self.seed)
        for name in ("halved", "runs_of_chunk"):
            if (count := getattr(self, name)) is not None:
                whole(f"Sweep({name}=...)", count)


def again(first: int, last: int, halved: int | None) -> Integers:
    """The numbers of those runs from first to last - 1 that are run again at half the step."""
    runs = np.arange(first, last)
    return runs[:0] if halved is None else runs[runs % halved == 0]


def check_times(kind: str, name: str, h: float, until: float, every: float | None) -> None:
    """Refuse times in s that are none, or of which one does not divide the next."""
    for what, time in (("h", h), ("until", until), ("every", until if every is None else every)):
        seconds(f"{kind}({what}=...)", time)
    multiple(f"{kind}(every=...)", every or until, h, f"`h` of '{name}',")
    multiple(f"{kind}(until=...)", until, every or until, f"`every` of '{name}',")
