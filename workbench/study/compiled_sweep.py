"""A sweep compiled: rows of parameters and initial states give chunks of numbers, and these make a sample."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import equations_of
from workbench.core.validation.refusals import Array, multiple
from workbench.engine.arithmetic import signature
from workbench.engine.factors import Space
from workbench.engine.job import Progress
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.engine.metrics.measured_run import MeasuredRun, arithmetic_for, points_of
from workbench.engine.metrics.score import MetricColumn
from workbench.engine.metrics.step_for_metrics import step_for
from workbench.engine.step_choice import StepChoice
from workbench.study.chosen_steps import choice_of
from workbench.study.chunk_format import ChunkFormat, accumulation_of
from workbench.study.ledger.chunk import Chunk, chunk_of
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.run_cost import RunCost
from workbench.study.sample import Sample
from workbench.study.uncertainty.designs import AbstractDesign, NominalPoint

CASES = "cases"  # the name of the sweep that each case is


@dataclass(frozen=True, eq=False)
class CompiledSweep:
    """A sweep whose factors are places in the rows of an equation, and whose step is known.

    Attributes
    ----------
    format
        The measured run, and the arrays that are computed of it.
    size
        The number of its runs; of a search, at most.
    choice
        That of the step by pilots, where the sweep names none.
    """

    sweep: Sweep
    format: ChunkFormat
    space: Space
    size: int
    choice: StepChoice | None = None

    @property
    def run(self) -> MeasuredRun:
        """The measured equation with its step, times, noise and arithmetic."""
        return self.format.run

    @property
    def equation(self) -> Ode | SampledSystem:
        """The equation that is run."""
        return self.run.measured_equation.equation

    @property
    def arithmetic(self) -> str:
        """The arithmetic of its runs."""
        return self.run.arithmetic

    @property
    def h(self) -> float:
        """The step in s."""
        return self.run.h

    @property
    def columns(self) -> tuple[MetricColumn, ...]:
        """The columns of its values."""
        return self.run.measured_equation.columns

    @cached_property
    def cost(self) -> RunCost:
        """The cost of each of its runs."""
        return RunCost.of(self.run, self.sweep.half_step_every)

    @property
    def runs_of_chunk(self) -> int:
        """The number of runs that are computed together, by the sweep or else by their cost."""
        return self.sweep.runs_of_chunk or self.cost.runs_of_chunk

    @cached_property
    def chunks(self) -> tuple[tuple[int, int], ...]:
        """The first run of each chunk and that behind its last: a larger design begins with the same ones."""
        return tuple(pairwise([*range(0, self.size, self.runs_of_chunk), self.size]))

    def at(self, design: AbstractDesign) -> CompiledSweep:
        """The sweep with the runs of another design."""
        return replace(self, sweep=replace(self.sweep, design=design), size=design.size)

    def under(self, seed: int) -> CompiledSweep:
        """The sweep under the noise of another seed."""
        if seed == self.run.seed:
            return self
        return replace(self, format=replace(self.format, run=replace(self.run, seed=seed)))

    def looked_at(self, name: str, size: int) -> CompiledSweep:
        """The sweep under another name, with `size` runs, each of which is repeated at half the step."""
        sweep, run = replace(self.sweep, name=name, half_step_every=1), replace(self.run, points=points_of(size))
        return replace(self, sweep=sweep, format=replace(self.format, run=run, half_step_every=1), size=size)

    def rows(self, first: int, last: int) -> tuple[Array, Array]:
        """The parameters (n, np) and the initial states (n, nx) of the runs first to last - 1."""
        p, x0 = map(np.ascontiguousarray, self.space.rows(self.sweep.design.points(first, last)))
        return p, x0

    def name(self, first: int, last: int) -> str:
        """The name of the chunk of some runs: sweep, runs, and a digest of all on which their numbers depend."""
        digest = hashlib.sha256(self.format.fingerprint.encode())
        p, x0 = self.rows(first, last)
        for part in (p, self.run.start(x0)):  # with the memories of metrics and of a computer
            digest.update(part.astype("<f8").tobytes())
        return f"{self.sweep.name}/{first}-{last}/{digest.hexdigest()[:16]}"

    def chunk(self, first: int, last: int, progress: Progress | None = None) -> Chunk:
        """The runs first to last - 1 as the kernel computed them."""
        arrays = self.format.arrays(first, *self.rows(first, last), progress or (lambda done: None))
        return chunk_of(self.name(first, last), arrays)

    def sample(self, chunks: Iterable[Chunk], first: int = 0, at_half: bool = False) -> Sample:
        """The runs of some chunks that follow one another from the run `first` on, with the values of their metrics.

        With `at_half` the values are those of h / 2, of the runs that were repeated there.
        """
        parts = [self.format.arrays_in(chunk) for chunk in chunks]
        arrays = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        last = first + len(arrays["diverged_at"])
        points, again = self.sweep.design.points(first, last), self.format.looked_at(first, last)
        p = self.space.rows(points)[0]
        return Sample(
            name=self.sweep.name,
            factors=tuple(factor.name for factor in self.sweep.factors),
            factor_values=self.space.values(points[again] if at_half else points),
            measurement=self.run.measurement(
                accumulation_of(arrays),
                p,
                again,
                at_half,
                tolerance=self.sweep.run.tolerance if self.choice or self.format.keeps else None,
                choice=self.choice,
                kept_runs=self.format.trajectories(first, p, arrays),
            ),
            seed=self.run.seed,
            fingerprint=self.format.fingerprint,
            design=self.sweep.design,
            arithmetic=signature(self.arithmetic),
        )


def compile_sweep(sweep: Sweep, arithmetic: str | None = None) -> CompiledSweep:
    """A sweep with its equation, in an arithmetic by its name, or else in the one that serves best here.

    A sweep that names no step is run at its points of least and largest coordinate along each axis, to choose one.
    """
    made = _compiled(sweep, equations_of(sweep.run.loop, sweep.name), arithmetic)
    multiple(f"Sweep({sweep.name!r}, run=Run(every=...))", made.run.every, made.run.step.h, "the step")
    again = made.runs_of_chunk // (sweep.half_step_every or made.runs_of_chunk)
    return replace(made, format=replace(made.format, run=replace(made.run, points=points_of(again))))


def compile_case(run: Run, equation: Ode | SampledSystem, arithmetic: str | None = None) -> CompiledSweep:
    """A case as a sweep of one row: metrics at the horizon, errors from h / 2, and its states kept."""
    made = _compiled(Sweep(CASES, run, (), NominalPoint(), half_step_every=1, runs_of_chunk=1), equation, arithmetic)
    measured = replace(made.run, every=run.every or made.run.step.h, spacing=run.until)
    return replace(made, format=replace(made.format, run=measured, keeps=True))


def _compiled(sweep: Sweep, equation: Ode | SampledSystem, arithmetic: str | None) -> CompiledSweep:
    run, space = sweep.run, Space(sweep.factors, equation.parameters, equation.states)
    measured = MeasuredEquation.of(equation, run.metrics, run.until)
    h, method, choice = run.h, "rk4", None
    if h is None:
        choice = _choice(sweep, measured, space)
        h, method = choice.h, choice.method
    rounding = arithmetic_for(measured.step(h, method), arithmetic)
    made = MeasuredRun(measured, h, run.until, run.sampling_interval, run.sampling_interval, run.seed, rounding, method)
    return CompiledSweep(
        sweep, ChunkFormat(made, sweep.half_step_every, sweep.common), space, sweep.design.size, choice
    )


def _choice(sweep: Sweep, measured: MeasuredEquation, space: Space) -> StepChoice:
    """The step at which the runs of least and largest coordinate along each axis keep the tolerance."""
    run, points = sweep.run, sweep.design.points()
    assert run.tolerance is not None
    ends = np.unique([points.argmin(axis=0), points.argmax(axis=0)]) if sweep.factors else [0]
    p, x0 = space.rows(points[ends])
    until, every, tolerance, seed = run.until, run.sampling_interval, run.tolerance, run.seed
    asked = (measured.equation, measured.metrics, p, x0, until, every, tolerance, seed)
    return choice_of(asked, lambda: step_for(measured, p, x0, until=until, every=every, tolerance=tolerance, seed=seed))
