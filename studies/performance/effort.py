"""How much is run for a measurement, and the seconds of a core that it takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import process_time

import numpy as np

from studies.performance.workload import HORIZON, H, draw, rmse, workload
from workbench.simulate import simulate
from workbench.validation.refusals import Array

SEED = 20  # of all parameters that are drawn


@dataclass(frozen=True)
class Effort:
    """How much is run.

    Attributes
    ----------
    horizon
        Of every run of W, in s. A shorter one is scaled to that of W by its steps.
    repetitions, processes
        How often a rate is measured, and how many processes tell a latency: medians are taken.
    seconds
        How long one measurement of a rate takes at least.
    runs, batch, samples
        In one call of ours, in one whose steps a pilot chooses, and behind a median error.
    fine
        The step of the reference, in s.
    sizes, fallback, many, links
        Runs in a call where the rate shall be flat; of the NumPy engine; where memory is looked at; links
        of the arms that are compiled.
    """

    horizon: float = HORIZON
    repetitions: int = 3
    processes: int = 5
    seconds: float = 0.3
    runs: int = 256
    batch: int = 4000
    samples: int = 32
    fine: float = 1e-5
    sizes: tuple[int, ...] = (8, 64, 1000, 10_000)
    fallback: int = 8000
    many: int = 1_000_000
    links: tuple[int, ...] = (2, 3, 4, 5, 6, 7)

    @property
    def scale(self) -> float:
        """How many runs of W one run is."""
        return self.horizon / HORIZON


QUICK = Effort(repetitions=1, processes=2, samples=16, seconds=0.1, batch=1000, sizes=(8, 1000))


def cpu_seconds(work: Callable[[], object]) -> float:
    """What some work takes of all cores together: waiting for a core that others use does not count."""
    begin = process_time()
    work()
    return process_time() - begin


def rows_of(runs: int) -> Array:
    """The parameters of the first so many runs, the same ones in every measurement."""
    return draw(np.random.default_rng(SEED), runs)


def ours(p: Array, horizon: float, h: float = H) -> Array:
    """The RMSE (B, 2) by our engine at the step h [s], with nothing kept but the end."""
    return rmse(simulate(workload(h), p, until=horizon, every=horizon).x[:, -1], horizon)


def rate(run: Callable[[Array], object], p: Array, effort: Effort) -> float:
    """Runs of W in a second of one core."""
    calls, spent = 0, 0.0
    while spent < effort.seconds:
        calls, spent = calls + 1, spent + cpu_seconds(lambda: run(p))
    return calls * len(p) * effort.scale / spent


def our_rate(effort: Effort, runs: int = 0) -> float:
    """The rate of our engine, with so many runs in a call."""
    return rate(lambda p: ours(p, effort.horizon), rows_of(runs or effort.runs), effort)


def alternated(effort: Effort, mine: Callable[[], float], theirs: Callable[[], float]) -> tuple[float, float]:
    """The median rates of two, measured in turns so that whatever disturbs the machine disturbs both."""
    pairs = [(mine(), theirs()) for _ in range(effort.repetitions)]
    return median(pair[0] for pair in pairs), median(pair[1] for pair in pairs)
