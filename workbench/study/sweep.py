"""Sweep: many runs of one loop, each with its own values of some factors."""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from workbench.study.contract import Run
from workbench.study.document.phrases import check_name
from workbench.study.uncertainty.designs import AbstractDesign
from workbench.study.uncertainty.factors import Factor
from workbench.validation.refusals import Integers, whole
from workbench.validation.signatures import door

HALVED = 16
COUNTS = ("runs", "base", "trajectories")  # the names by which designs have the number that `--samples` sets
COLUMNS = ("run", "t [s]", "diverged at [s]")  # of a table of runs, beside factors and metrics


@dataclass(frozen=True, eq=False)
@door
class Sweep:
    """A run as often as a design says, each with its own values of some factors.

    Attributes
    ----------
    name
        Lower-case letters, digits and underscores: it becomes the name of a file.
    design
        A point of the unit cube a run, one coordinate a factor.
    run
        Its metrics are taken at each multiple of `every`. Without `h`, the runs with the least and the largest value of
        each factor choose one step for all.
    common
        True if all runs have the same noise; else it is each run's own.
    halved
        One run of so many, those whose number it divides, is run again at h / 2, for the error of the step; None for no
        run.
    runs_of_chunk
        The number of runs that are computed and kept together; by default as many as take a processor a second or two.

    Examples
    --------
    >>> ode = wb.open_loop(wb.DCMotor())
    >>> factor = wb.Factor("friction", ("b",), wb.Uniform(0.05, 0.2))
    >>> wb.Sweep("motor", wb.Run(ode, (wb.effort("omega"),), until=1.0), (factor,), wb.SobolDesign(1, 64)).name
    'motor'
    """

    name: str
    run: Run
    factors: tuple[Factor, ...]
    design: AbstractDesign
    common: bool = False
    halved: int | None = HALVED
    runs_of_chunk: int | None = None

    def __post_init__(self) -> None:
        check_name("Sweep", self.name)
        if self.design.dimensions != len(self.factors):
            raise ValueError(
                f"`Sweep({self.name!r}, design=...)` must have as many dimensions as there are factors, "
                f"{len(self.factors)}; got {self.design.dimensions}."
            )
        if taken := [factor.name for factor in self.factors if factor.name in COLUMNS]:
            raise ValueError(
                f"`Sweep({self.name!r}, factors=...)` needs another name for {taken}: tables have that column."
            )
        if not self.run.metrics:
            raise ValueError(f"`Sweep({self.name!r}, run=...)` needs a run with at least one metric; got none.")
        for name in ("halved", "runs_of_chunk"):
            if (count := getattr(self, name)) is not None:
                whole(f"Sweep({name}=...)", count)


def again(first: int, last: int, halved: int | None) -> Integers:
    """The numbers of those runs from first to last - 1 that are run again at half the step."""
    runs = np.arange(first, last)
    return runs[:0] if halved is None else runs[runs % halved == 0]


def count_of(sweep: Sweep) -> str | None:
    """The name by which the design of a sweep has its number of samples; None where it has none."""
    held: Any = fields(sweep.design) if is_dataclass(sweep.design) else ()
    counts = {field.name for field in held if isinstance(getattr(sweep.design, field.name), int)}
    return next((name for name in COUNTS if name in counts), None)  # the `base` of `OneAtATime` is a quantile


def resized(sweep: Sweep, count: int | None) -> Sweep:
    """The sweep with so many samples; one whose design has no number of them keeps its points."""
    name = None if count is None else count_of(sweep)
    return sweep if name is None else replace(sweep, design=replace(sweep.design, **{name: count}))  # type: ignore[type-var]
