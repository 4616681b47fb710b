"""Values of metrics at the end of runs, from what was accumulated beside the states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.core import Layout, Step
from workbench.metrics.contract import AbstractMetric
from workbench.simulate import Trajectories
from workbench.simulate.arithmetic import continued
from workbench.validation.refusals import Array, whole
from workbench.validation.signatures import door


@door
def accumulators(step: Step, metrics: Sequence[AbstractMetric]) -> Layout:
    """The states of a step that belong to its metrics: integrals, and what they keep in mind."""
    memories = tuple(f"{m.name}." for m in metrics)
    wanted = (e for e in step.states.entries if e.name in _integrals(metrics) or e.name.startswith(memories))
    return Layout(tuple(wanted))


@door
def accumulated(runs: Trajectories, metrics: Sequence[AbstractMetric], row: int = -1) -> Array:
    """The accumulators of each run, (B, a), at a kept time, the last if none is named.

    A memory was last updated one step before that time, so it looks once more.
    """
    row = whole("accumulated(row=...)", row, -len(runs.t), len(runs.t) - 1)
    step, state = runs.step, runs.x[:, row]
    later = continued(runs.job, state, round(float(runs.t[row]) / step.h), 1)
    names, integrals = accumulators(step, metrics).names, _integrals(metrics)
    parts = [(state if name in integrals else later)[:, step.states.slice(name)] for name in names]
    return np.hstack([np.empty((len(state), 0)), *parts])


@door
def values(metrics: Sequence[AbstractMetric], held: Layout, accumulated: Array, horizon: float) -> Mapping[str, Array]:
    """Each metric, (B, k), from the accumulators (B, a) of its runs and their horizon in s."""
    parts, found = held.unpack(accumulated), {}
    for m in metrics:
        integral = parts.get(f"integral of {m.name}", np.zeros((len(accumulated), 0)))
        memory = {
            name.removeprefix(f"{m.name}."): part for name, part in parts.items() if name.startswith(f"{m.name}.")
        }
        found[m.name] = m.value(integral, memory, horizon)
    return found


@door
def final_values(runs: Trajectories, metrics: Sequence[AbstractMetric], row: int = -1) -> dict[str, Array]:
    """Each metric of each run, (B, k), from the start to a kept time, the last if none is named.

    NaN for a run that had diverged by then.
    """
    row = whole("final_values(row=...)", row, -len(runs.t), len(runs.t) - 1)
    horizon = float(runs.t[row])
    lost = (runs.diverged_at <= horizon)[:, np.newaxis]
    found = values(metrics, accumulators(runs.step, metrics), accumulated(runs, metrics, row), horizon)
    return {name: np.where(lost, np.nan, value) for name, value in found.items()}


def _integrals(metrics: Sequence[AbstractMetric]) -> set[str]:
    return {f"integral of {m.name}" for m in metrics}
