"""The contract of a study: a loop, which gives its equations, the Run with its horizon and metrics, and the Sweep."""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass, replace
from typing import ClassVar

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import LOOP, Loop, is_loop
from workbench.core.validation.refusals import Integers, multiple, positive, refusal, seconds, seed, whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine.factors import Factor
from workbench.engine.metrics import AbstractMetric
from workbench.study.document.phrases_and_tables import check_name
from workbench.study.uncertainty.designs import AbstractDesign

TOLERANCE = 1e-3
HALF_STEP_EVERY = 16
COUNTS = ("runs", "base", "trajectories")  # the names by which designs have the number that `--samples` sets
COLUMNS = ("run", "t [s]", "diverged at [s]")  # of a table of runs, beside factors and metrics


@dataclass(frozen=True, eq=False)
@check_arguments
class Run:
    """A simulation of a loop from its initial state to a horizon, with the metrics to compute.

    A case names one run, a sweep varies its numbers, and a tuning searches for them.

    Attributes
    ----------
    loop
        Equations, an `Ode` or a `SampledSystem`, or an object that gives them by `ode(name)`, such as a `ClosedLoop`.
    metrics
        The metrics, such as `wb.rmse()`; each has one number per component of its signal.
    until, every
        The horizon and the time between stored states, in s, multiples of `h`. Without `every` a case stores each step,
        and a sweep or a tuning stores the final state only.
    h
        The step of the values in s; for a sampled loop the substep. The error of a value is twice its change when the
        step is halved. Without `h`, pilot runs choose one.
    tolerance
        The largest error of a value, relative to the value. If both `h` and `tolerance` are given, a larger error is a
        warning of the result. Without `h` the default tolerance is 0.001.
    seed
        The seed of the noise.

    Examples
    --------
    >>> run = wb.Run(wb.open_loop(wb.DCMotor()), (wb.effort("omega"),), until=1.0)
    >>> run.steps
    'steps for a tolerance of 0.001'
    """

    WAYS: ClassVar = dict.fromkeys(("ClosedLoop", "Ode", "SampledSystem"), "write `Run(loop, metrics, until)`")

    loop: Loop | Ode | SampledSystem
    metrics: tuple[AbstractMetric, ...]
    until: float
    every: float | None = None
    h: float | None = None
    tolerance: float | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        if not is_loop(self.loop):
            raise refusal("Run(loop=...)", LOOP, self.loop)
        for name in ("h", "until", "every"):
            if (span := getattr(self, name)) is not None:
                seconds(f"Run({name}=...)", span)
        if self.tolerance is not None:
            positive("Run(tolerance=...)", self.tolerance)
        elif self.h is None:
            object.__setattr__(self, "tolerance", TOLERANCE)
        seed("Run(seed=...)", self.seed)
        for name, part in (("every", "h"), ("until", "h"), ("until", "every")):
            if (span := getattr(self, name)) is not None and (unit := getattr(self, part)) is not None:
                multiple(f"Run({name}=...)", span, unit, f"`{part}`,")

    @property
    def sampling_interval(self) -> float:
        """The time between two values of the metrics in a sweep, in s."""
        return self.until if self.every is None else self.every

    @property
    def steps(self) -> str:
        """The step in words."""
        return f"steps for a tolerance of {self.tolerance:g}" if self.h is None else f"h = {self.h:g} s"


@dataclass(frozen=True, eq=False)
@check_arguments
class Sweep:
    """Many runs of one loop, with the values of its factors that a design gives for each run.

    Attributes
    ----------
    run
        The run. Its metrics are taken at each multiple of `every`. Without `h`, the runs with the least and the largest
        value of each factor choose one step for all.
    factors
        The numbers that differ from run to run, with their distributions.
    design
        One point of the unit cube for each run, with one coordinate for each factor.
    common
        True if all runs have the same noise; otherwise each run has its own noise.
    half_step_every
        Every run whose number is a multiple of this is repeated at h / 2, for the error of its values.
    runs_of_chunk
        The number of runs that are computed and stored together; by default as many as one processor computes in a
        second or two.
    least_samples
        The least number of samples that the tables of the study need, as `least_base` and `least_draws` give it. Fewer
        samples, by `--samples` or by the design, are refused before anything is computed.

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
    half_step_every: int | None = HALF_STEP_EVERY
    runs_of_chunk: int | None = None
    least_samples: int | None = None

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
        if self.factors and not self.run.metrics:
            raise ValueError(f"`Sweep({self.name!r}, run=...)` needs a run with at least one metric; got none.")
        for name in ("half_step_every", "runs_of_chunk", "least_samples"):
            if (count := getattr(self, name)) is not None:
                whole(f"Sweep({name}=...)", count)
        of = count_of(self)
        if (
            self.least_samples is not None
            and of is not None
            and (count := getattr(self.design, of)) < self.least_samples
        ):
            raise ValueError(
                f"`Sweep({self.name!r}, design=...)` needs at least {self.least_samples:,} samples, the `{of}` of its "
                f"design, for the tables that follow; got {count:,}: take more, in the design or by `--samples`."
            )


def half_step_runs(first: int, last: int, half_step_every: int | None) -> Integers:
    """The numbers of those runs from first to last - 1 that are run at half the step too."""
    runs = np.arange(first, last)
    return runs[:0] if half_step_every is None else runs[runs % half_step_every == 0]


def count_of(sweep: Sweep) -> str | None:
    """The name by which the design of a sweep has its number of samples; None where it has none."""
    design: object = sweep.design
    own = fields(design) if is_dataclass(design) else ()
    counts = {field.name for field in own if isinstance(getattr(design, field.name), int)}
    return next((name for name in COUNTS if name in counts), None)  # the `base` of `OneAtATime` is a quantile


def resize(sweep: Sweep, count: int | None) -> Sweep:
    """The sweep with so many samples; one whose design has no number of them keeps its points."""
    name = None if count is None else count_of(sweep)
    return sweep if name is None else replace(sweep, design=replace(sweep.design, **{name: count}))  # type: ignore[type-var]
