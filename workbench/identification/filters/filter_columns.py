"""The columns of a log that a model reads: inputs and outputs by name, with their units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core import Entry, Layout
from workbench.core.units import read
from workbench.core.validation.refusals import Array, describe, known_name
from workbench.identification.datasets import Dataset, Experiment
from workbench.identification.datasets.signal_checks import units_of, wrapped_rows
from workbench.identification.filters.filter_input import times

_OF_MODEL = "parameters and outputs of the model"


@dataclass(frozen=True, eq=False)
class LogReading:
    """Inputs and outputs that a filter reads by name, other names of the log for them, and the inputs in between."""

    inputs: Sequence[str] | None
    outputs: Sequence[str] | None
    signals: Mapping[str, str]  # names of the model by those of the log
    hold: str

    def name_in_log(self, name: str) -> str:
        """The name of an input or an output in the log."""
        return {ours: theirs for theirs, ours in self.signals.items()}.get(name, name)


@dataclass(frozen=True, eq=False)
class FilterColumns:
    """Times (N,), places of the inputs in the parameters with their samples (N, nd), outputs and their samples."""

    t: Array
    input_labels: tuple[str, ...]
    u: Array
    outputs: Layout
    output_places: tuple[int, ...]
    y: Array

    @property
    def remarks(self) -> tuple[str, ...]:
        """A remark for each output that is an angle which jumps by a full turn."""
        jumps = {
            label: wrapped_rows(column[np.isfinite(column)], unit).size
            for label, column, unit in zip(self.outputs.labels, self.y.T, units_of(self.outputs), strict=True)
        }
        return tuple(
            f"The samples of '{label}' jump by a full turn {count} times, and no innovation takes a turn back: add the "
            f"turns by `log.unwrap(['{label}'])`."
            for label, count in jumps.items()
            if count
        )


def columns_of(
    call: str, log: Dataset, reading: LogReading, parameters: Layout, inputs: Sequence[str], all_outputs: Layout
) -> FilterColumns:
    """The columns for a model with these parameters and outputs; `inputs` are read if the caller names none."""
    experiment = _only_experiment(call, log)
    signals = experiment.signals
    _refuse_unknown(call, reading.signals, signals, parameters, all_outputs)
    inputs, outputs = inputs if reading.inputs is None else reading.inputs, reading.outputs
    if outputs is None:
        outputs = [name for name in all_outputs.names if reading.name_in_log(name) in signals]
        if not outputs:
            raise LookupError(
                f"`{call}(log=...)` must have at least one output of the model, which are "
                f"{', '.join(all_outputs.names) or 'none'}; the log has {', '.join(signals.names)}: say by "
                "`signals={'name in the log': 'name in the model'}` which is which."
            )
    pairs = [(name, reading.name_in_log(name)) for name in inputs]
    places = [(parameters.indices(ours), _signal(call, ours, theirs, parameters, signals)) for ours, theirs in pairs]
    pairs = [(name, reading.name_in_log(name)) for name in outputs]
    read_at = [(all_outputs.indices(ours), _signal(call, ours, theirs, all_outputs, signals)) for ours, theirs in pairs]
    u = experiment.values[:, [column for _, columns in places for column in columns]]
    if not np.isfinite(u).all():
        row, column = np.argwhere(~np.isfinite(u))[0]
        label = [signals.labels[column] for _, columns in places for column in columns][column]
        raise ValueError(
            f"`{call}(log=...)` must have a sample of each input at all times, as no filter can guess it; '{label}' "
            f"has none at t = {experiment.t[row]:g} s: fill it in, or cut the log there."
        )
    columns = [column for _, part in read_at for column in part]
    output_places = tuple(place for part, _ in read_at for place in part)
    return FilterColumns(
        times(call, experiment.t, len(experiment)),
        tuple(parameters.labels[place] for part, _ in places for place in part),
        u,
        part_of(all_outputs, outputs),
        output_places,
        np.where(experiment.is_weighed, experiment.values, np.nan)[:, columns],
    )


def part_of(layout: Layout, names: Sequence[str]) -> Layout:
    """The layout of some quantities, or of single numbers of them (`q[0]`)."""
    entries = []
    for name in names:
        (first, *_), labels = layout.indices(name), layout.labels
        if name in layout:
            entries.append(layout[name])
        else:
            whole = layout[labels[first].rpartition("[")[0]]
            unit = whole.units[layout.indices(whole.name).index(first)]
            entries.append(Entry(name, np.array(layout.default[first]), unit))
    return Layout(tuple(entries))


def _only_experiment(call: str, log: Dataset) -> Experiment:
    if len(log.experiments) > 1:
        raise ValueError(
            f"`{call}(log=...)` must have one experiment, as each begins with its own state; this log has "
            f"{len(log.experiments)}: call it once for each `log.of_experiments([name])`."
        )
    experiment = log.experiments[0]
    if not len(experiment):
        raise ValueError(f"`{call}(log=...)` must have at least one sample; '{experiment.name}' has none.")
    return experiment


def _refuse_unknown(call: str, names: Mapping[str, str], signals: Layout, parameters: Layout, outputs: Layout) -> None:
    for theirs, ours in names.items():
        signals.indices(theirs)
        known_name(ours, (*parameters.labels, *parameters.names, *outputs.labels, *outputs.names), _OF_MODEL)
    if len(set(names.values())) < len(names):
        raise ValueError(f"`{call}(signals=...)` must give each name of the model once; got {describe(names)}.")


def _signal(call: str, ours: str, theirs: str, layout: Layout, signals: Layout) -> list[int]:
    """The columns of a signal of the log, whose size and unit must be those of the model."""
    places = layout.indices(ours)
    if theirs not in signals.labels:
        known_name(theirs, signals.names, "signals of this log")
    columns = signals.indices(theirs)
    if len(columns) != len(places):
        raise ValueError(
            f"`{call}(log=...)` must have signals of the size that the model has; '{theirs}' has {len(columns)} "
            f"numbers, and '{ours}' has {len(places)}."
        )
    for place, column in zip(places, columns, strict=True):
        want, got = units_of(layout)[place], units_of(signals)[column]
        if not read(want).fits(read(got)):
            raise ValueError(
                f"`{call}(log=...)` must have signals in the units of the model, as nothing is converted; '{theirs}' "
                f"is in [{got}], and '{ours}' in [{want}]."
            )
    return columns
