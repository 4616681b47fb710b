"""The cost of one run of a sweep, and the number of runs that are therefore computed together."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from workbench.engine.batch import SECONDS_PER_OPERATION
from workbench.engine.metrics.measured_run import MeasuredRun

SECONDS = 2.0  # of one processor, by the cautious estimate of the engine, that a chunk takes: in truth about a third
BYTES = 64 * 2**20  # of kept states that a chunk may hold
BLOCK = 256  # a chunk is a multiple of this many runs, where it has more: whole vectors for two threads, also at h / 2


@dataclass(frozen=True)
class RunCost:
    """The time of one processor in s that a run takes, by a cautious estimate, and the bytes of its kept states."""

    seconds: float
    bytes: int

    @staticmethod
    def of(run: MeasuredRun, half_step_every: int | None) -> RunCost:
        """The cost of each of many runs, of which every `half_step_every`-th is repeated at half the step."""
        steps = run.until / run.step.h
        seconds = SECONDS_PER_OPERATION * steps * run.step.operations * (1 + 2 / (half_step_every or inf))
        return RunCost(seconds, 8 * run.step.states.size * (1 + round(run.until / run.every)))

    @property
    def runs_of_chunk(self) -> int:
        """The number of runs that are computed together: the same on every machine."""
        most = max(1, min(int(SECONDS / self.seconds), BYTES // self.bytes))
        return most - most % BLOCK if most > BLOCK else most
