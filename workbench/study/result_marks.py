"""Marks of results: cells, bars and points of scores, and the sources that they and curves carry.

Each is made from an outcome and says which: its law and scenario, its metric or signal, and its run.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np

from workbench.core import Entry, Ode
from workbench.core.piecewise_constant import is_piecewise_constant
from workbench.core.validation.refusals import Array, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.figure import Bars, Label, Points, Style
from workbench.study.document.phrases_and_tables import Cell, DivergedCell, MissingCell, ValueWithError
from workbench.study.document.source import Source
from workbench.study.study import Outcome

Signal: TypeAlias = Literal["t"] | tuple[Literal["x", "y"], int]  # the time, or a place among states or outputs


@check_arguments
def metric_source(outcome: Outcome, metric: str, signal: int | str = 0) -> Source:
    """The source of a number of a metric, of the signal with a label or a number from 0."""
    case, about = outcome.case, (outcome.label, outcome.notes)
    _, place, unit, label = outcome.column(metric, signal)
    return Source(case.law, case.scenario, "metric", metric, place, label, unit, outcome.digest, None, 1.0, *about)


@check_arguments
def signal_source(outcome: Outcome, name: str, number: int | str = 0, rows: tuple[int, int] | None = None) -> Source:
    """The source of one number of an output or state, by its label or counted from 0, in some of the kept rows.

    Raises
    ------
    LookupError
        If there is no such signal, or it has no such number.
    """
    case, labels = outcome.case, labels_of(outcome, name)
    place = _place(f"signal '{name}' of '{case.name}'", labels, number)
    unit = _entry(outcome, name).units[_flat_places(_entry(outcome, name))[place]]
    return Source(
        case.law, case.scenario, "signal", name, place, labels[place], unit, outcome.digest, rows or (0, len(outcome.t))
    )


@check_arguments
def time_source(outcome: Outcome, rows: tuple[int, int] | None = None) -> Source:
    """The source of the time of an outcome, in s, in some of the kept rows."""
    case, rows = outcome.case, rows or (0, len(outcome.t))
    return Source(case.law, case.scenario, "time", "time", 0, "", "s", outcome.digest, rows)


@check_arguments
def labels_of(outcome: Outcome, name: str) -> tuple[str, ...]:
    """The labels of the numbers of an output or state, a matrix row by row, with what the plant counts by them."""
    entry, ode = _entry(outcome, name), outcome.ode if isinstance(outcome.ode, Ode) else outcome.ode.flow
    if entry.size == 1:
        return (name,)
    if ode.counts:
        return tuple(f"{ode.counts} {place + 1}" for place in range(entry.size))
    labels = entry.labels()
    return tuple(labels[place] for place in _flat_places(entry))


def place_of_signal(outcome: Outcome, source: Source) -> Signal:
    """The place of the signal of a source among the states or outputs of its loop; an output that is a state is it."""
    if source.kind == "time":
        return "t"
    step = outcome.measurement.trajectories.step
    layout = step.states if source.name in step.states else step.outputs
    place = layout.slice(source.name).start + _flat_places(layout[source.name])[source.place]
    if layout is step.states:
        return "x", place
    states = {step.rule.x[k].element_hash(): k for k in range(step.rule.x.numel())}
    own = states.get(step.rule.output[place].element_hash())
    return ("y", place) if own is None else ("x", own)


def changes_by_jumps(outcome: Outcome, source: Source) -> bool:
    """True if the signal of a source changes by jumps alone, as a step or the command of a computer."""
    flow = outcome.measurement.trajectories.step.flow
    return is_piecewise_constant(flow, source.name, _flat_places(_entry(outcome, source.name))[source.place])


def _entry(outcome: Outcome, name: str) -> Entry:
    step = outcome.measurement.trajectories.step
    layout = step.states if name in step.states else step.outputs
    return layout[name]


def _flat_places(entry: Entry) -> list[int]:
    """The places of the numbers of a matrix, row by row, in the flat vector, where it lies column by column."""
    places: list[int] = np.arange(entry.size).reshape(entry.shape, order="F").ravel().tolist()
    return places


def _place(call: str, labels: tuple[str, ...], number: int | str) -> int:
    """The place of a number by its label, or counted from 0; a negative one would be counted from the end."""
    if isinstance(number, str):
        return labels.index(known_name(number, labels, f"numbers of `{call}`"))
    if not 0 <= number < len(labels):
        raise LookupError(f"`{call}` has the numbers 0 to {len(labels) - 1}, {', '.join(labels)}; got {number}.")
    return number


@check_arguments
def cell(outcome: Outcome, metric: str, signal: int | str = 0, scale: float = 1.0, unit: str = "") -> Cell:
    """A table cell with a score and its error, times `scale` to convert it to `unit`; or why there is no score.

    The notes of the outcome stand below the table. A metric that the outcome does not have is an empty cell.

    Raises
    ------
    LookupError
        If the metric has no such number.
    """
    if metric not in outcome.measurement.names:
        return None
    source = metric_source(outcome, metric, signal).times(scale, unit)
    value, error = outcome.score(metric, source.place).pair
    if outcome.diverged_at is not None:
        return DivergedCell(outcome.diverged_at, source)
    if value == math.inf:
        return MissingCell("never", source)
    if not (math.isfinite(value) and math.isfinite(error)):
        return MissingCell("no error estimate", source)
    return ValueWithError(scale * value, abs(scale) * error, source)


@check_arguments
def bars(
    label: Label,
    outcomes: Sequence[Outcome],
    metric: str,
    signal: int | str = 0,
    places: Array | None = None,
    style: Style = 0,
    thick: float = 0.7,
) -> Bars:
    """Bars from zero to a score of each outcome, from the top row on or in `places`; a diverged run has none."""
    sources = tuple(metric_source(outcome, metric, signal) for outcome in outcomes)
    ends = _values(outcomes, metric, sources)
    rows = np.arange(len(ends), dtype=float) if places is None else places
    return Bars(label, rows, ends, np.zeros(len(ends)), style, thick=thick, sources=sources)


@check_arguments
def points(
    label: Label,
    outcomes: Sequence[Outcome],
    across: str,
    up: str,
    signal: int | str = 0,
    names: tuple[Label, ...] = (),
    style: Style = 0,
) -> Points:
    """A point of two scores for each outcome; a run that diverged has none."""
    pairs = [tuple(metric_source(outcome, metric, signal) for outcome in outcomes) for metric in (across, up)]
    x, y = (_values(outcomes, metric, sources) for metric, sources in zip((across, up), pairs, strict=True))
    return Points(label, x, y, names, style, sources=tuple(zip(*pairs, strict=True)))


def _values(outcomes: Sequence[Outcome], metric: str, sources: Sequence[Source]) -> Array:
    values = [outcome.score(metric, one.place).pair[0] for outcome, one in zip(outcomes, sources, strict=True)]
    return np.where(np.isfinite(values), values, np.nan)
