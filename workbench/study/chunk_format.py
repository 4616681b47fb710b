"""The format of a chunk of runs: the arrays that are computed, all on which they depend, and how they are read."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from workbench.core.fingerprints import fingerprint_of
from workbench.core.validation.refusals import Array, Integers
from workbench.engine import Trajectories
from workbench.engine.arithmetic import signature
from workbench.engine.divergence import Divergence
from workbench.engine.job import Progress
from workbench.engine.metrics.measured_run import Accumulation, MeasuredRun
from workbench.study.ledger.chunk import Chunk, plain
from workbench.study.ledger.ownership import LedgerError
from workbench.study.ledger.store import FOLDER, file_of
from workbench.study.run_and_sweep import half_step_runs


@dataclass(frozen=True, eq=False)
class ChunkFormat:
    """The arrays of a `MeasuredRun` with many rows: an `Accumulation`, and the states too if it `keeps` them.

    Attributes
    ----------
    half_step_every
        Each run whose number it divides is repeated at half the step; none if it is None.
    common
        True if all runs have the same noise.
    """

    run: MeasuredRun
    half_step_every: int | None
    common: bool
    keeps: bool = False

    @cached_property
    def fingerprint(self) -> str:
        """The digest of equations, times, seed and arithmetic, on which a run depends besides its own row."""
        run, rule = self.run, self.run.step.rule
        parts = {
            "arithmetic": signature(run.arithmetic),
            "times": [float(time).hex() for time in (run.h, run.until, run.every, run.spacing)],
            "seed": [run.seed, self.common],
            "kept": [self.half_step_every, self.keeps, run.points, run.measured_equation.accumulators.size],
            "rates": rule.rate.numel(),
            "method": rule.method.name,
        }
        head = plain(parts)
        if rule.segment_parts is not None:
            head += fingerprint_of(b"", rule.segment_parts).encode()
        return fingerprint_of(head, rule.parts)

    def looked_at(self, first: int, last: int) -> Integers:
        """The places among the runs first to last - 1 of those that are repeated at half the step."""
        return half_step_runs(first, last, self.half_step_every) - first

    def arrays(self, first: int, p: Array, x0: Array, progress: Progress) -> dict[str, Array]:
        """The arrays of the runs from `first` on with rows p (n, np) and x0 (n, nx), as the kernel computes them."""
        last = first + len(p)
        found, runs = self.run.march(p, x0, self._keys(first, last), self.looked_at(first, last), progress)
        arrays = {field.name: getattr(found, field.name) for field in fields(found)}
        return arrays | ({"x": runs.x, "diverged_in": runs.divergence.state} if self.keeps else {})

    def arrays_in(self, chunk: Chunk) -> dict[str, Array]:
        """The arrays of a chunk, where they have the shapes of those that were computed."""
        arrays = chunk.arrays()
        n, m = (np.size(arrays.get(name, ())) for name in ("diverged_at", "half_diverged_at"))
        if {name: array.shape for name, array in arrays.items()} != self._shapes(n, m):
            raise LedgerError(
                f"The chunk '{chunk.name}' does not hold the runs of its name: remove its file "
                f"'{FOLDER}/{file_of(chunk.name)}', and the same command computes these runs again, and no others."
            )
        return arrays

    def trajectories(self, first: int, p: Array, arrays: dict[str, Array]) -> Trajectories | None:
        """The trajectories of the runs from `first` on with rows p (n, np); None where no states are kept."""
        if not self.keeps:
            return None
        divergence = Divergence(arrays["diverged_at"], arrays["diverged_in"].astype(int))
        return self.run.trajectories(p, self._keys(first, first + len(p)), arrays["x"], divergence)

    def _keys(self, first: int, last: int) -> Integers:
        """The keys of the noise of the runs first to last - 1."""
        runs = np.arange(first, last)
        return np.zeros_like(runs) if self.common else runs

    def _shapes(self, n: int, m: int) -> dict[str, tuple[int, ...]]:
        """The shapes of the arrays of n runs, of which m are repeated at half the step."""
        kept = n, 1 + round(self.run.until / self.run.every), self.run.step.states.size
        return self.run.shapes(n, m) | ({"x": kept, "diverged_in": (n,)} if self.keeps else {})


def accumulation_of(arrays: dict[str, Array]) -> Accumulation:
    """The accumulators among the arrays of a chunk."""
    return Accumulation(**{field.name: arrays[field.name] for field in fields(Accumulation)})
