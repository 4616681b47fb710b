"""The equations of a loop, made once for the tests of one block that are given the same loop."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from workbench.blocks.loop import AbstractObserver, AbstractPlant, ClosedLoop, open_loop
from workbench.core import Ode, SampledSystem
from workbench.engine import Trajectories, simulate
from workbench.testing.bench_blocks import BenchLaw


@lru_cache(maxsize=2)
def observed_loop(plant: AbstractPlant, observer: AbstractObserver) -> ClosedLoop:
    """A plant whose inputs are driven by the bench, and its observer."""
    return ClosedLoop(plant, observer, BenchLaw(plant.inputs))


@lru_cache(maxsize=2)
def observed_runs(loop: ClosedLoop, period: float, until: float) -> Trajectories:
    """Two runs in a computer: from the start of the plant, and from another one."""
    step, start = sampled_of_loop(loop, period).step(1), loop.plant.states.default
    moved = start + 0.05 * np.maximum(np.abs(start), 1.0) * np.where(np.arange(start.size) % 2, -1.0, 1.0)
    x0 = np.tile(step.states.default, (2, 1))
    x0[1, : start.size] = moved
    return simulate(step, None, x0, until=round(until / period) * period)


@lru_cache(maxsize=2)
def ode_of_plant(plant: AbstractPlant) -> Ode:
    """The plant alone, driven by its inputs."""
    return open_loop(plant)


@lru_cache(maxsize=2)
def driven_loop(plant: AbstractPlant) -> ClosedLoop:
    """A plant whose inputs are driven by the bench."""
    return ClosedLoop(plant, controller=BenchLaw(plant.inputs))


@lru_cache(maxsize=2)
def ode_of_loop(loop: ClosedLoop) -> Ode:
    """The loop in continuous time."""
    return loop.ode()


@lru_cache(maxsize=2)
def sampled_of_loop(loop: ClosedLoop, period: float) -> SampledSystem:
    """The loop in a computer."""
    return loop.digital(period)
