"""Sweep: many runs of one loop over factors, cut into chunks that anyone can compute from their numbers alone."""

from __future__ import annotations

from dataclasses import dataclass

from workbench.core.numbers import multiple, positive
from workbench.core.sockets import require
from workbench.metrics import AbstractMetric
from workbench.study.cells import check_name, several
from workbench.study.contract import Loop
from workbench.study.factors import Factor
from workbench.study.sampling import AbstractDesign

HALVED = 16
COLUMNS = ("run", "t [s]", "diverged at [s]")  # of a table of runs, beside factors and metrics


@dataclass(frozen=True, eq=False)
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
        Of the noise, which is each run's own.
    halved
        One run of so many is run again at h / 2, for the error of the step: those whose number it divides.
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
    halved: int = HALVED
    runs_of_chunk: int | None = None

    def __post_init__(self) -> None:
        check_name("Sweep", self.name)
        object.__setattr__(self, "metrics", several("Sweep(metrics=...)", self.metrics, AbstractMetric, "metric"))
        object.__setattr__(self, "factors", several("Sweep(factors=...)", self.factors, Factor, "factor"))
        require(f"Sweep({self.name!r}, design=...)", self.design, AbstractDesign)
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
        for name in ("h", "until", *(() if self.every is None else ("every",))):
            positive(f"Sweep({name}=...)", getattr(self, name), " of seconds")
        every = self.until if self.every is None else self.every
        multiple("Sweep(every=...)", every, self.h, f"`h` of '{self.name}',")
        multiple("Sweep(until=...)", self.until, every, f"`every` of '{self.name}',")
        for name in ("halved", "runs_of_chunk"):
            whole(f"Sweep({name}=...)", getattr(self, name), optional=name == "runs_of_chunk")


def whole(call: str, value: object, optional: bool = False) -> None:
    """Refuse what is no positive whole number."""
    if optional and value is None:
        return
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError(f"`{call}` must be a positive whole number; got {value!r}.")
