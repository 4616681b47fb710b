"""Simulated runs as experiments of a dataset."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import known_name
from workbench.engine.trajectories import Trajectories
from workbench.identification.datasets.experiment import Experiment


def experiments_of(runs: Trajectories, signals: Sequence[str]) -> tuple[Experiment, ...]:
    """Each run as an experiment with the states and outputs that are named, or all of them."""
    step = runs.step
    entries = {entry.name: entry for layout in (step.outputs, step.states) for entry in layout.entries}
    for name in signals:
        known_name(name, entries, "states and outputs of these runs")
    layout = Layout(tuple(entries[name] for name in signals or entries))
    names = ["run"] if len(runs) == 1 else [f"run {i}" for i in range(len(runs))]
    columns = [runs[entry.name].reshape(len(runs), runs.t.size, -1) for entry in layout.entries]
    for place, entry in enumerate(layout.entries):
        if len(entry.shape) == 2:  # a layout stores matrices column by column
            columns[place] = np.swapaxes(runs[entry.name], -1, -2).reshape(len(runs), runs.t.size, -1)
    values = np.concatenate(columns, axis=-1)
    return tuple(Experiment(name, runs.t, layout, values[i]) for i, name in enumerate(names))
