"""A sweep compiled: its equations and steps, the names of its chunks, the numbers in them, and their meaning."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from workbench.core import Ode, Sampled
from workbench.core.equations import equations_of
from workbench.core.fingerprints import fingerprint_of
from workbench.core.validation.refusals import Array, Integers, multiple
from workbench.engine import Trajectories
from workbench.engine.arithmetic import signature
from workbench.engine.batch import SECONDS_PER_OPERATION
from workbench.engine.divergence import Divergence
from workbench.engine.factors import Space
from workbench.engine.job import Progress
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.engine.metrics.measured_run import Accumulation, MeasuredRun, arithmetic_for, points_of
from workbench.engine.metrics.score import Column
from workbench.engine.metrics.step_for_metrics import step_for
from workbench.engine.step_choice import Choice
from workbench.study.chosen_steps import choice_of
from workbench.study.contract import Run, Sweep, again
from workbench.study.ledger.chunk import Chunk, chunk_of, plain
from workbench.study.ledger.store import FOLDER, LedgerError, file_of
from workbench.study.sample import Sample
from workbench.study.uncertainty.designs import AbstractDesign, Alone

SECONDS = 2.0  # of one processor, by the cautious estimate of the engine, that a chunk takes: in truth about a third
BYTES = 64 * 2**20  # of kept states that a chunk may hold
CASES = "cases"  # the name of the sweep that each case is
BLOCK = 256  # a chunk is a multiple of so many runs, where it has more: whole vectors for two threads, also at h / 2


@dataclass(frozen=True, eq=False)
class CompiledSweep:
    """A sweep with its measured equation at the step h, whose rows are runs and whose chunks are kept in a ledger."""

    sweep: Sweep
    run: MeasuredRun
    space: Space
    size: int  # of its runs; of a search, at most
    choice: Choice | None = None  # of the step by pilots
    keeps: bool = False  # the states of its runs too, as a case does

    @property
    def equation(self) -> Ode | Sampled:
        """The equation that is run."""
        return self.run.measured.equation

    @property
    def arithmetic(self) -> str:
        """The arithmetic of its runs."""
        return self.run.arithmetic

    @property
    def h(self) -> float:
        """The step in s."""
        return self.run.h

    @property
    def columns(self) -> tuple[Column, ...]:
        """The columns of its values."""
        return self.run.measured.columns

    @property
    def seconds_of_run(self) -> float:
        """The time that a run takes of one processor, by a cautious estimate."""
        steps = self.run.until / self.run.step.h
        return SECONDS_PER_OPERATION * steps * self.run.step.operations * (1 + 2 / (self.sweep.halved or np.inf))

    @property
    def bytes_of_run(self) -> int:
        """The memory of a run's kept states."""
        return 8 * self.run.step.states.size * (1 + round(self.run.until / self.run.every))

    @property
    def runs_of_chunk(self) -> int:
        """The number of runs that are computed together: the same on every machine."""
        if self.sweep.runs_of_chunk is not None:
            return self.sweep.runs_of_chunk
        most = max(1, min(int(SECONDS / self.seconds_of_run), BYTES // self.bytes_of_run))
        return most - most % BLOCK if most > BLOCK else most

    @cached_property
    def chunks(self) -> tuple[tuple[int, int], ...]:
        """The first run of each chunk and that behind its last: a larger design begins with the same ones."""
        return tuple(pairwise([*range(0, self.size, self.runs_of_chunk), self.size]))

    @cached_property
    def fingerprint(self) -> str:
        """The digest of equations, times, seed and arithmetic, on which a run depends besides its own row."""
        run, rule = self.run, self.run.step.rule
        parts = {
            "arithmetic": signature(run.arithmetic),
            "times": [float(time).hex() for time in (run.h, run.until, run.every, run.spacing)],
            "seed": [run.seed, self.sweep.common],
            "kept": [self.sweep.halved, self.keeps, run.points, run.measured.accumulators.size],
            "rates": rule.rate.numel(),
            "method": rule.method.name,
        }
        head = plain(parts)
        if rule.segment_parts is not None:
            head += fingerprint_of(b"", rule.segment_parts).encode()
        return fingerprint_of(head, rule.parts)

    def rows(self, first: int, last: int) -> tuple[Array, Array]:
        """The parameters (n, np) and the initial states (n, nx) of some runs."""
        p, x0 = map(np.ascontiguousarray, self.space.rows(self.sweep.design.points(first, last)))
        return p, x0

    def at(self, design: AbstractDesign) -> CompiledSweep:
        """The sweep with the runs of another design."""
        other = replace(self, sweep=replace(self.sweep, design=design), size=design.size)
        vars(other)["fingerprint"] = self.fingerprint  # which the runs do not change, and which takes a while
        return other

    def under(self, seed: int) -> CompiledSweep:
        """The sweep under the noise of another seed."""
        return self if seed == self.run.seed else replace(self, run=replace(self.run, seed=seed))

    def looked_at(self, name: str, size: int) -> CompiledSweep:
        """The sweep under another name, with so many runs, each of which is looked at."""
        sweep = replace(self.sweep, name=name, halved=1)
        return replace(self, sweep=sweep, run=replace(self.run, points=points_of(size)), size=size)

    def name(self, first: int, last: int) -> str:
        """The name of the chunk of some runs: sweep, runs, and a digest of all on which their numbers depend."""
        digest = hashlib.sha256(self.fingerprint.encode())
        p, x0 = self.rows(first, last)
        for part in (p, self.run.start(x0)):  # with the memories of metrics and of a computer
            digest.update(part.astype("<f8").tobytes())
        return f"{self.sweep.name}/{first}-{last}/{digest.hexdigest()[:16]}"

    def chunk(self, first: int, last: int, progress: Progress | None = None) -> Chunk:
        """The runs first to last - 1 as the kernel computed them: an `Accumulation`, and states where they are kept."""
        p, x0 = self.rows(first, last)
        runs = np.arange(first, last)
        keys = np.zeros_like(runs) if self.sweep.common else runs
        few = again(first, last, self.sweep.halved) - first
        found, trajectories = self.run.march(p, x0, keys, few, progress or (lambda done: None))
        arrays = {field.name: getattr(found, field.name) for field in fields(found)}
        if self.keeps:
            arrays |= {"x": trajectories.x, "diverged_in": trajectories.divergence.state}
        return chunk_of(self.name(first, last), arrays)

    def sample(self, chunks: Iterable[Chunk], first: int = 0, at_half: bool = False) -> Sample:
        """The runs of some chunks that follow one another from the run `first` on, with the values of their metrics.

        With `at_half` the values are those of h / 2, of the runs that were looked at.
        """
        parts = [self._arrays(chunk) for chunk in chunks]
        held = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        last = first + len(held["diverged_at"])
        points, few = self.sweep.design.points(first, last), again(first, last, self.sweep.halved) - first
        p = self.space.rows(points)[0]
        kept = self._trajectories(p, np.arange(first, last), held)
        found = Accumulation(**{field.name: held[field.name] for field in fields(Accumulation)})
        tolerance = self.sweep.run.tolerance if self.choice or self.keeps else None
        told: Any = {"tolerance": tolerance, "choice": self.choice, "kept": kept}
        return Sample(
            name=self.sweep.name,
            factors=tuple(factor.name for factor in self.sweep.factors),
            drawn=self.space.values(points[few] if at_half else points),
            measurement=self.run.measurement(found, p, few, at_half, **told),
            seed=self.run.seed,
            fingerprint=self.fingerprint,
            design=self.sweep.design,
            arithmetic=signature(self.arithmetic),
        )

    def _trajectories(self, p: Array, keys: Integers, held: Mapping[str, Array]) -> Trajectories | None:
        if not self.keeps:
            return None
        divergence = Divergence(held["diverged_at"], held["diverged_in"].astype(int))
        return self.run.trajectories(p, np.zeros_like(keys) if self.sweep.common else keys, held["x"], divergence)

    def _arrays(self, chunk: Chunk) -> dict[str, Array]:
        """The arrays of a chunk, where they have the shapes of those that were computed."""
        arrays = chunk.arrays()
        n, m = (np.size(arrays.get(name, ())) for name in ("diverged_at", "halved_diverged_at"))
        shapes = self.run.shapes(n, m)
        if self.keeps:
            shapes |= {"x": (n, 1 + round(self.run.until / self.run.every), self.run.step.states.size)}
            shapes |= {"diverged_in": (n,)}
        if {name: array.shape for name, array in arrays.items()} != shapes:
            raise LedgerError(
                f"The chunk '{chunk.name}' does not hold the runs of its name: remove its file "
                f"'{FOLDER}/{file_of(chunk.name)}', and the same command computes these runs again, and no others."
            )
        return arrays


def compile_sweep(sweep: Sweep, arithmetic: str | None = None) -> CompiledSweep:
    """A sweep with its equation, in an arithmetic by its name, or else in the one that serves best here.

    A sweep that names no step is run at its points of least and largest coordinate along each axis, to choose one.
    """
    made = _compiled(sweep, equations_of(sweep.run.loop, sweep.name), arithmetic)
    multiple(f"Sweep({sweep.name!r}, run=Run(every=...))", made.run.every, made.run.step.h, "the step")
    looked_at = made.runs_of_chunk // (sweep.halved or made.runs_of_chunk)
    return replace(made, run=replace(made.run, points=points_of(looked_at)))


def compile_case(run: Run, equation: Ode | Sampled, arithmetic: str | None = None) -> CompiledSweep:
    """A case as a sweep of one row: the metrics are taken at the horizon, the row is looked at, its states are kept."""
    sweep = Sweep(CASES, run, (), Alone(), halved=1, runs_of_chunk=1)
    made = _compiled(sweep, equation, arithmetic)
    every = made.run.step.h if run.every is None else run.every
    return replace(made, run=replace(made.run, every=every, spacing=run.until), keeps=True)


def _compiled(sweep: Sweep, equation: Ode | Sampled, arithmetic: str | None) -> CompiledSweep:
    run, space = sweep.run, Space(sweep.factors, equation.parameters, equation.states)
    measured, h, method, choice = MeasuredEquation.of(equation, run.metrics, run.until), run.h, "rk4", None
    if h is None:
        assert run.tolerance is not None
        points = sweep.design.points()
        ends = np.unique([points.argmin(axis=0), points.argmax(axis=0)]) if sweep.factors else [0]
        how: Any = {"until": run.until, "every": run.kept, "tolerance": run.tolerance, "seed": run.seed}
        p, x0 = space.rows(points[ends])
        asked = (equation, measured.metrics, p, x0, run.until, run.kept, run.tolerance, run.seed)
        choice = choice_of(asked, lambda: step_for(measured, p, x0, **how))
        h, method = choice.h, choice.method
    rounding = arithmetic_for(measured.step(h, method), arithmetic)
    made = MeasuredRun(measured, h, run.until, run.kept, run.kept, run.seed, rounding, method)
    return CompiledSweep(sweep, made, space, sweep.design.size, choice)
