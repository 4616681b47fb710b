"""A sweep compiled: its equations and steps, the names of its chunks, the numbers in them, and their meaning."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

import numpy as np

from workbench.core import Ode, Sampled, Step
from workbench.core.equations import equations_of
from workbench.core.fingerprints import fingerprint_of
from workbench.metrics import AbstractMetric
from workbench.metrics.accumulators import accumulated, accumulators, maker, resolved, values
from workbench.metrics.step_for_metrics import choose_step
from workbench.simulate import Trajectories, simulate
from workbench.simulate.arithmetic import default_for, signature
from workbench.simulate.batch import SECONDS_PER_OPERATION
from workbench.simulate.job import Progress
from workbench.simulate.stability import longest_steps, modes_at
from workbench.simulate.step_size import change
from workbench.study.contract import Sweep, again
from workbench.study.ledger.chunk import Chunk, chunk_of, plain
from workbench.study.ledger.store import FOLDER, LedgerError, file_of
from workbench.study.sample import Sample
from workbench.study.uncertainty.designs import AbstractDesign
from workbench.study.uncertainty.factors import Space
from workbench.validation.refusals import Array, Integers, multiple

SECONDS = 2.0  # of one processor, by the cautious estimate of the engine, that a chunk takes: in truth about a third
BYTES = 64 * 2**20  # of kept states that a chunk may hold
STATES = 4  # of a run at which its modes are looked at: the first, the last, and kept ones between them
BLOCK = 256  # a chunk is a multiple of so many runs, where it has more: whole vectors for two threads, also at h / 2


@dataclass(frozen=True, eq=False)
class CompiledSweep:
    """A sweep with its equation and its steps of length h and h / 2, both with the metrics beside the states."""

    sweep: Sweep
    equation: Ode | Sampled
    metrics: tuple[AbstractMetric, ...]
    coarse: Step
    fine: Step
    space: Space
    arithmetic: str
    size: int  # of its runs; of a search, at most
    watched: bool = False  # the longest stable step is looked for along every run, not only along those run again
    chosen: bool = False  # by pilots, of the step

    @property
    def h(self) -> float:
        """The step in s."""
        assert self.sweep.run.h is not None
        return self.sweep.run.h

    @property
    def every(self) -> float:
        """The distance of the times at which metrics are taken, in s."""
        return self.sweep.run.kept

    @property
    def times(self) -> int:
        """The number of these times, T."""
        return round(self.sweep.run.until / self.every)

    @cached_property
    def columns(self) -> tuple[tuple[str, int, str], ...]:
        """The metric, its number counted from 0, and its unit, of each column of values."""
        return tuple((m.name, number, unit) for m in self.metrics for number, unit in enumerate(m.units))

    @property
    def seconds_of_run(self) -> float:
        """The time that a run takes of one processor, by a cautious estimate."""
        steps = self.sweep.run.until / self.coarse.h
        return SECONDS_PER_OPERATION * steps * self.coarse.operations * (1 + 2 / (self.sweep.halved or np.inf))

    @property
    def bytes_of_run(self) -> int:
        """The memory of a run's kept states."""
        return 8 * self.coarse.states.size * (1 + self.times)

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
        sweep = self.sweep
        parts = {
            "arithmetic": signature(self.arithmetic),
            "times": [float(time).hex() for time in (self.h, sweep.run.until, self.every)],
            "seed": [sweep.run.seed, sweep.common],
            "kept": [sweep.halved, self.watched, accumulators(self.coarse, self.metrics).size],
            "rates": self.coarse.rule.rate.numel(),
            "method": self.coarse.rule.method.name,
        }
        rule, head = self.coarse.rule, plain(parts)
        if rule.segment_parts is not None:
            head += fingerprint_of(b"", rule.segment_parts).encode()
        return fingerprint_of(head, rule.parts)

    def rows(self, first: int, last: int) -> tuple[Array, Array]:
        """The parameters (n, np) and the initial states (n, nx) of some runs, those of their metrics among them."""
        p, x0 = map(np.ascontiguousarray, self.space.rows(self.sweep.design.points(first, last)))
        return p, np.hstack([x0, np.tile(self.coarse.states.default[x0.shape[1] :], (last - first, 1))])

    def at(self, design: AbstractDesign) -> CompiledSweep:
        """The sweep with the runs of another design."""
        other = replace(self, sweep=replace(self.sweep, design=design), size=design.size)
        vars(other)["fingerprint"] = self.fingerprint  # which the runs do not change, and which takes a while
        return other

    def under(self, seed: int) -> CompiledSweep:
        """The sweep under the noise of another seed."""
        return replace(self, sweep=replace(self.sweep, run=replace(self.sweep.run, seed=seed)))

    def at_half(self, name: str, size: int) -> CompiledSweep:
        """The sweep at h / 2 with so many runs, under another name; none is halved again, and all are watched."""
        sweep = replace(self.sweep, name=name, run=replace(self.sweep.run, h=self.h / 2), halved=None)
        return replace(self, sweep=sweep, coarse=self.fine, watched=True, size=size)

    def name(self, first: int, last: int) -> str:
        """The name of the chunk of some runs: sweep, runs, and a digest of all on which their numbers depend."""
        digest = hashlib.sha256(self.fingerprint.encode())
        for part in self.rows(first, last):
            digest.update(part.astype("<f8").tobytes())
        return f"{self.sweep.name}/{first}-{last}/{digest.hexdigest()[:16]}"

    def chunk(self, first: int, last: int, progress: Progress | None = None) -> Chunk:
        """The runs first to last - 1 as the kernel computed them: n runs at the step h, and m of them at h / 2 too.

        They are the accumulators of the metrics, (n, T, a) and (m, T, a); when each diverged, NaN for none; and some
        states of runs whose stability is looked at.
        """
        p, x0 = self.rows(first, last)
        runs = np.arange(first, last)
        few = again(first, last, self.sweep.halved) - first
        share = 2 * len(few) / (2 * len(few) + len(runs))
        tell = progress or (lambda done: None)

        arrays = {}
        if len(few):  # the longer run first: from it the engine sees how good its code should be
            fine = self._march(self.fine, runs[few], p[few], x0[few], lambda done: tell(share * done))
            arrays = {"again": self._accumulated(fine), "again_diverged_at": fine.diverged_at}
        coarse = self._march(self.coarse, runs, p, x0, lambda done: tell(share + (1 - share) * done))
        arrays |= {"accumulated": self._accumulated(coarse), "diverged_at": coarse.diverged_at}
        seen = runs - first if self.watched else few
        arrays["states"] = coarse.x[seen][:, self._looks, : self.coarse.flow.states.size]
        return chunk_of(self.name(first, last), arrays)

    def _march(self, step: Step, runs: Integers, p: Array, x0: Array, tell: Progress) -> Trajectories:
        run, keys = self.sweep.run, np.zeros_like(runs) if self.sweep.common else runs
        call = partial(simulate, step, p, x0, until=run.until, every=self.every, seed=run.seed)
        return call(runs=keys, progress=tell, arithmetic=self.arithmetic)

    def _accumulated(self, runs: Trajectories) -> Array:
        return np.stack([accumulated(runs, self.metrics, row) for row in range(1, len(runs.t))], axis=1)

    @cached_property
    def _looks(self) -> Integers:
        """The kept times at which the stability of a run is looked at, by their numbers."""
        return np.unique(np.linspace(0, self.times, STATES).round().astype(int))

    def sample(self, chunks: Iterable[Chunk], first: int = 0) -> Sample:
        """The runs of some chunks that follow one another from the run `first` on, with the values of their metrics."""
        parts = [self._arrays(chunk) for chunk in chunks]
        held = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        found = self._values(held["accumulated"], held["diverged_at"])
        last = first + len(found)
        some = again(first, last, self.sweep.halved) - first
        errors, limits = np.empty((0, *found.shape[1:])), np.empty(0)
        if len(some):
            errors = self._changes(self._values(held["again"], held["again_diverged_at"]), found[some])
        points = self.sweep.design.points(first, last)
        if not self.watched:
            limits = self._limits(held["states"], self.space.rows(points)[0][some])
        return Sample(
            name=self.sweep.name,
            factors=tuple(factor.name for factor in self.sweep.factors),
            columns=self.columns,
            labels=tuple(label for m in self.metrics for label in m.labels),
            t=np.asarray(self.every * np.arange(1, self.times + 1)),
            h=self.h,
            tolerance=self.sweep.run.tolerance if self.chosen else None,
            seed=self.sweep.run.seed,
            arithmetic=signature(self.arithmetic),
            fingerprint=self.fingerprint,
            drawn=self.space.values(points),
            values=found,
            again=some,
            errors=errors,
            limits=limits,
            diverged_at=held["diverged_at"],
            design=self.sweep.design,
        )

    def watched_limits(self, chunk: Chunk) -> Array:
        """The longest stable step along each run of a chunk whose runs are all watched, (n,) in s."""
        first, last = map(int, chunk.name.split("/")[1].split("-"))
        return self._limits(self._arrays(chunk)["states"], self.rows(first, last)[0])

    def _arrays(self, chunk: Chunk) -> dict[str, Array]:
        """The arrays of a chunk, where they have the shapes of those that were computed."""
        arrays = chunk.arrays()
        n, m = (np.size(arrays.get(name, ())) for name in ("diverged_at", "again_diverged_at"))
        a = accumulators(self.coarse, self.metrics).size
        shapes = {"accumulated": (n, self.times, a), "diverged_at": (n,)}
        shapes |= {"again": (m, self.times, a), "again_diverged_at": (m,)} if m else {}
        shapes["states"] = (n if self.watched else m, len(self._looks), self.coarse.flow.states.size)
        if {name: array.shape for name, array in arrays.items()} != shapes:
            raise LedgerError(
                f"The chunk '{chunk.name}' does not hold the runs of its name: remove its file "
                f"'{FOLDER}/{file_of(chunk.name)}', and the same command computes these runs again, and no others."
            )
        none = {"again": np.empty((0, self.times, a)), "again_diverged_at": np.empty(0)}
        return none | arrays

    def _values(self, accumulated: Array, diverged_at: Array) -> Array:
        """The metrics (n, T, k) from their accumulators (n, T, a); NaN from the time at which a run diverged."""
        held, stride = accumulators(self.coarse, self.metrics), round(self.every / self.coarse.h)
        rows = []
        for row in range(self.times):
            horizon = (row + 1) * stride * self.coarse.h
            found = values(self.metrics, held, accumulated[:, row], horizon)
            lost = (diverged_at <= horizon)[:, np.newaxis]
            rows.append(np.where(lost, np.nan, np.hstack([found[m.name] for m in self.metrics])))
        return np.stack(rows, axis=1)

    def _limits(self, states: Array, p: Array) -> Array:
        """The longest step that is stable at some states (m, S, nx) of runs, (m,); NaN where none has a Jacobian."""
        if not len(states):
            return np.empty(0)
        t = np.tile(self._looks * self.every, len(states))
        rows = np.repeat(p, len(self._looks), axis=0)
        modes = modes_at(self.coarse.flow, t, states.reshape(len(t), -1), rows)
        longest = np.min(longest_steps(modes, self.coarse.amplification), axis=1, initial=np.inf)
        longest[np.isnan(modes).any(axis=1)] = np.nan
        return np.asarray(np.fmin.reduce(longest.reshape(len(states), -1), axis=1))

    def _changes(self, fine: Array, rough: Array) -> Array:
        floors = [self.coarse.h if m.is_time else 0.0 for m in self.metrics for _ in m.labels]
        return np.stack([change(fine[..., i], rough[..., i], floor) for i, floor in enumerate(floors)], axis=-1)


def compile_sweep(sweep: Sweep, arithmetic: str | None = None, *, search: bool = False) -> CompiledSweep:
    """A sweep with its equation, in an arithmetic by its name, or else in the one that serves best here.

    A sweep that names no step is run at its points of least and largest coordinate along each axis, to choose one.
    The runs of a search are at twice the step.
    """
    run = sweep.run
    equation: Ode | Sampled = equations_of(run.loop, sweep.name)
    metrics = resolved(equation, run.metrics, run.until)
    method = "rk4"
    space = Space(sweep.factors, equation.parameters, equation.states)
    if run.h is None:
        assert run.tolerance is not None
        points = sweep.design.points()
        p, x0 = space.rows(points[np.unique([points.argmin(axis=0), points.argmax(axis=0)])])
        how: Any = {"until": run.until, "every": run.kept, "tolerance": run.tolerance, "seed": run.seed}
        choice = choose_step(equation, run.metrics, p, x0, **how)
        run, method = replace(run, h=choice.h / (2 if search else 1)), choice.method
    h = run.doubled(equation, f"Trial(run=...) of {sweep.name!r}") if search else run.h
    assert h is not None
    make = maker(equation, metrics, method)
    coarse, fine = make(h), make(h / 2)
    multiple(f"Sweep({sweep.name!r}, run=Run(every=...))", run.kept, coarse.h, "the step")
    chosen = sweep.run.h is None
    sweep = replace(sweep, run=replace(run, h=h))
    arithmetic = arithmetic or default_for(coarse)
    return CompiledSweep(sweep, equation, metrics, coarse, fine, space, arithmetic, sweep.design.size, chosen=chosen)
