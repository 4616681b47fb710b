"""A sweep ready to run: its equation, its steps, and what each chunk is called and gives."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property, partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from workbench import __version__
from workbench.core import Ode, Sampled, Step
from workbench.core.layout import Array
from workbench.core.numbers import Integers, multiple
from workbench.core.ode import instructions
from workbench.metrics import AbstractMetric
from workbench.metrics.accumulated import maker, resolved
from workbench.metrics.measure import final_values
from workbench.simulate import Trajectories, simulate
from workbench.simulate.job import Progress
from workbench.simulate.request import SECONDS_PER_OPERATION
from workbench.simulate.stepping.accuracy import change
from workbench.simulate.stepping.stability import longest_steps, modes_at
from workbench.study.chunk import Chunk, chunk_of, written
from workbench.study.factors import Space
from workbench.study.sampling import AbstractDesign
from workbench.study.sweep import Sweep, again

ROOT = Path(__file__).parents[1]
SECONDS = 2.0  # of one processor, by the cautious estimate of the engine, that a chunk takes: in truth about a third
BYTES = 64 * 2**20  # of kept states that a chunk may hold
STATES = 4  # of a run at which its modes are looked at: the first, the last, and kept ones between them
BLOCK = 256  # a chunk is a multiple of so many runs, where it has more: whole vectors for two threads, also at h / 2


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sweep with its equation and its steps of length h and h / 2, both with the metrics beside the states.

    Attributes
    ----------
    watched
        Whether the longest stable step is looked for along every run, and not only along those that are run again.
    """

    sweep: Sweep
    equation: Ode | Sampled
    metrics: tuple[AbstractMetric, ...]
    coarse: Step
    fine: Step
    space: Space
    watched: bool = False

    @property
    def every(self) -> float:
        """The distance of the times at which metrics are taken, in s."""
        return self.sweep.until if self.sweep.every is None else self.sweep.every

    @cached_property
    def columns(self) -> tuple[tuple[str, int, str], ...]:
        """What a value belongs to: a metric, its joint counted from 0, and its unit."""
        sizes = ((m, self.coarse.outputs[m.watches[0]].size) for m in self.metrics)
        return tuple((m.name, joint, m.unit) for m, size in sizes for joint in range(size))

    @property
    def seconds_of_run(self) -> float:
        """What a run takes of one processor, by a cautious estimate."""
        steps = self.sweep.until / self.coarse.h
        return SECONDS_PER_OPERATION * steps * self.coarse.operations * (1 + 2 / (self.sweep.halved or np.inf))

    @property
    def bytes_of_run(self) -> int:
        """The memory of a run's kept states."""
        return 8 * self.coarse.states.size * (1 + round(self.sweep.until / self.every))

    @property
    def runs_of_chunk(self) -> int:
        """How many runs are computed together: the same on every machine."""
        if self.sweep.runs_of_chunk is not None:
            return self.sweep.runs_of_chunk
        most = max(1, min(int(SECONDS / self.seconds_of_run), BYTES // self.bytes_of_run))
        return most - most % BLOCK if most > BLOCK else most

    @cached_property
    def chunks(self) -> tuple[tuple[int, int], ...]:
        """The first run of each chunk and that behind its last: a larger design begins with the same ones."""
        size = self.sweep.design.size
        return tuple(pairwise([*range(0, size, self.runs_of_chunk), size]))

    @cached_property
    def fingerprint(self) -> str:
        """A name of all that a run depends on but its own numbers."""
        sweep = self.sweep
        said = {
            "code": code(),
            "equation": self.equation.fingerprint,
            "metrics": [written_of(metric) for metric in self.metrics],
            "times": [float(time).hex() for time in (sweep.h, sweep.until, self.every)],
            "seed": [sweep.seed, sweep.common],
            "halved": sweep.halved,
        }
        digest = hashlib.sha256(written(said))
        for line in instructions(self.coarse.rule.F):
            digest.update(repr(line).encode())
        return digest.hexdigest()

    def rows(self, first: int, last: int) -> tuple[Array, Array, Array]:
        """The values of the factors (n, d), and the parameters (n, np) and initial states (n, nx) of some runs.

        Raises
        ------
        ValueError
            If a value is not finite, or a row is out of the bounds of its numbers.
        """
        points = self.sweep.design.points(first, last)
        p, x0 = map(np.ascontiguousarray, self.space.rows(points))
        return self.space.values(points), p, x0

    def at(self, design: AbstractDesign) -> Prepared:
        """The same for other runs."""
        other = replace(self, sweep=replace(self.sweep, design=design))
        vars(other)["fingerprint"] = self.fingerprint  # which the runs do not change, and which takes a while
        return other

    def at_half(self, name: str) -> Prepared:
        """The same at h / 2, under another name; none of its runs is run again, and all of them are watched."""
        sweep = replace(self.sweep, name=name, h=self.sweep.h / 2, halved=None)
        return replace(self, sweep=sweep, coarse=self.fine, watched=True)

    def name(self, first: int, last: int) -> str:
        """What the chunk of some runs is called: sweep, runs, and a digest of all that they depend on."""
        return self._name(first, last, self.rows(first, last))

    def _name(self, first: int, last: int, rows: tuple[Array, ...]) -> str:
        digest = hashlib.sha256(self.fingerprint.encode())
        for part in rows:
            digest.update(part.astype("<f8").tobytes())
        return f"{self.sweep.name}/{first}-{last}/{digest.hexdigest()[:16]}"

    def chunk(self, first: int, last: int, progress: Progress | None = None) -> Chunk:
        """The numbers of the runs first to last - 1.

        Values (n, T, k) at the step h; errors (m, T, k), their change to h / 2 in those runs that are run again, and
        limits (m,), the longest stable step along these; and when each run diverged, NaN for none. After that its
        values are NaN. Where all runs are watched, the longest stable step along each as well, (n,).
        """
        values, p, x0 = rows = self.rows(first, last)
        runs = np.arange(first, last)
        few = again(first, last, self.sweep.halved) - first
        share = 2 * len(few) / (2 * len(few) + len(runs))
        tell = progress or (lambda done: None)

        # the longer run first: from it the engine sees how good its code should be
        fine = None
        if len(few):
            fine = self._march(self.fine, runs[few], p[few], x0[few], lambda done: tell(share * done))
        coarse = self._march(self.coarse, runs, p, x0, lambda done: tell(share + (1 - share) * done))
        rough = self._values(coarse)
        errors = np.empty((0, *rough.shape[1:])) if fine is None else self._changes(self._values(fine), rough[few])
        arrays = {"factors": values, "values": rough, "errors": errors, "diverged_at": coarse.diverged_at}
        arrays["limits"] = self._limits(coarse, few)
        if self.watched:
            arrays["watched"] = self._limits(coarse, np.arange(len(runs)))
        return chunk_of(self._name(first, last, rows), arrays)

    def _march(self, step: Step, runs: Integers, p: Array, x0: Array, tell: Progress) -> Trajectories:
        memory = np.tile(step.states.default[x0.shape[1] :], (len(runs), 1))
        start, sweep = np.hstack([x0, memory]), self.sweep
        call = partial(simulate, step, p, start, until=sweep.until, every=self.every, seed=sweep.seed)
        return call(runs=np.zeros_like(runs) if sweep.common else runs, progress=tell)

    def _values(self, runs: Trajectories) -> Array:
        rows = []
        for row in range(1, len(runs.t)):
            found = final_values(runs, self.metrics, row)
            rows.append(np.hstack([found[m.name] for m in self.metrics]))
        return np.stack(rows, axis=1)

    def _limits(self, runs: Trajectories, few: Integers) -> Array:
        """The longest step that is stable at some states of a few runs, (m,); NaN where no state has a Jacobian."""
        if not len(few):
            return np.empty(0)
        kept = np.unique(np.linspace(0, len(runs.t) - 1, STATES).round().astype(int))
        t, rows = np.tile(runs.t[kept], len(few)), np.repeat(few, len(kept))
        modes = modes_at(self.coarse.flow, t, runs.x[few][:, kept].reshape(len(t), -1), runs.p[rows])
        longest = np.min(longest_steps(modes, self.coarse.amplification), axis=1, initial=np.inf)
        longest[np.isnan(modes).any(axis=1)] = np.nan
        return np.asarray(np.fmin.reduce(longest.reshape(len(few), len(kept)), axis=1))

    def _changes(self, fine: Array, rough: Array) -> Array:
        floors = [self.coarse.h if unit == "s" else 0.0 for _, _, unit in self.columns]
        return np.stack([change(fine[..., i], rough[..., i], floor) for i, floor in enumerate(floors)], axis=-1)


def prepared(sweep: Sweep) -> Prepared:
    """The sweep with its equation.

    Raises
    ------
    LookupError
        If a factor varies what the loop does not have, or a metric watches what it does not put out.
    ValueError
        If two factors move one number, one leads out of its bounds, or a metric means nothing for the loop.
    """
    equation: Ode | Sampled = sweep.loop.ode(sweep.name)
    metrics = resolved(equation, sweep.metrics, sweep.until)
    make: Callable[[str, float], Step] = maker(equation, metrics)
    space = Space(sweep.factors, equation.parameters, equation.states)
    coarse = make("rk4", sweep.h)
    every = sweep.until if sweep.every is None else sweep.every
    multiple(f"Sweep({sweep.name!r}, every=...)", every, coarse.h, "the step")
    return Prepared(sweep, equation, metrics, coarse, make("rk4", sweep.h / 2), space)


def written_of(metric: AbstractMetric) -> list[str]:
    """A metric as it was written: its class and functions, which may be the user's own, as text, and its numbers."""
    return [_source(type(metric)), *(_written(getattr(metric, field.name)) for field in fields(metric))]


def _written(value: Any, above: tuple[Any, ...] = ()) -> str:
    """A value as text that is the same in every process; a function with its source and all the values that it uses."""
    if isinstance(value, (str, int, float, type(None))):
        return repr(value)
    if isinstance(value, (np.ndarray, np.generic)):
        return repr(value.tolist())
    if isinstance(value, (tuple, list)):
        return repr([_written(part, above) for part in value])
    if isinstance(value, partial):
        return _written((value.func, value.args, sorted(value.keywords.items())), above)
    if not inspect.isfunction(value) or value in above:
        return value.__name__ if inspect.ismodule(value) else _source(value)
    held = inspect.getclosurevars(value)
    uses = sorted({**held.globals, **held.nonlocals}.items())
    return repr([_source(value), _written((value.__defaults__, uses), (*above, value))])


def _source(thing: Any) -> str:
    try:
        return inspect.getsource(thing)
    except (OSError, TypeError):  # typed into a console, or no code, which would print its place in memory
        return str(getattr(thing, "__qualname__", type(thing).__qualname__))


@cache
def code() -> str:
    """A name of the code that a number depends on: version and sources of the rooms between a loop and its metrics."""
    digest = hashlib.sha256(__version__.encode())
    for room in ("core", "metrics", "simulate", "study/sampling", "study/distributions.py", "study/factors.py"):
        place = ROOT / room
        for file in sorted(place.rglob("*.py")) or [place]:
            digest.update(file.read_bytes())
    digest.update(Path(__file__).read_bytes())
    return digest.hexdigest()
