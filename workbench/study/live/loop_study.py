"""The study of a single loop, for a page on which one tries it: signals, metrics, and all its numbers as knobs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.core import Entry, Ode, Sampled
from workbench.metrics import AbstractMetric, effort, peak_error, rmse
from workbench.study.contract import Loop, Run, equations_of
from workbench.study.document.document import Cell, Column, Diverged, Figure, Measured, Panel, Section, Series, Table
from workbench.study.document.phrases import raised
from workbench.study.live.knob import Knob
from workbench.study.study import Case, Outcome, Results, Study
from workbench.validation.refusals import Array, multiple, seconds
from workbench.validation.signatures import door

REACH = 5.0  # a knob goes from a fifth of the loop's own number to five times as much
ABOUT_ZERO = 1.0  # as far as a knob goes either way from a number that is zero
POINTS = 1000  # kept times, or about that many
FIRST = ("controller", "plant", "observer", "reference", "instruments")  # the blocks whose knobs come first


@door
def loop_study(
    loop: Loop | Ode | Sampled,
    until: float,
    h: float,
    metrics: Sequence[AbstractMetric] = (),
    knobs: Sequence[Knob] = (),
    title: str = "",
) -> Study:
    """The study with one case: a loop until a horizon [s], at a step h [s], of a sampled loop a substep.

    The values are those of the step h; their errors are the change from 2 h. Without `metrics` they are those of
    tracking errors and inputs; without `knobs` every number of the loop is one, a vector by a share of itself.

    Raises
    ------
    ValueError
        If the loop is none, or h does not divide the horizon into an even number of steps.
    """
    equation = equations_of(loop, "loop")
    flow = equation if isinstance(equation, Ode) else equation.flow
    step = equation.period if isinstance(equation, Sampled) else 2 * seconds("live(h=...)", h)
    every = step * max(1, round(until / step / POINTS))
    while multiple("live(until=...)", until, step, "2 h, the step of the check,") % round(every / step):
        every -= step
    taken = tuple(metrics) or _usual_metrics(flow)
    case = Case("run", flow.name, Run(equation, taken, until, every, h))
    return Study(
        "live",
        title or f"The loop '{flow.name}', to be turned",
        "How does the loop answer to its numbers?",
        f"One run over {until:g} s at h = {h:g} s; values at the step, errors from twice the step.",
        _sections,
        cases=(case,),
        live=tuple(knobs) or knobs_of(equation),
    )


def knobs_of(equation: Ode | Sampled) -> tuple[Knob, ...]:
    """A knob for each number of a loop, those of its laws first; a vector that is all zero has none."""
    entries = sorted(equation.parameters.entries, key=_rank)
    return tuple(knob for entry in entries if (knob := _knob(entry)))


def _rank(entry: Entry) -> int:
    head = entry.name.split(".")[0]
    return FIRST.index(head) if head in FIRST else len(FIRST)


def _knob(entry: Entry) -> Knob | None:
    if entry.size > 1:
        return Knob(entry.name, entry.name, 1 / REACH, REACH, log=True, share=True) if entry.default.any() else None
    value, low, high = float(entry.default.ravel()[0]), entry.bounds.low, entry.bounds.high
    if not np.isfinite(value):
        return None
    ends = sorted((value / REACH, value * REACH)) if value else (-ABOUT_ZERO, ABOUT_ZERO)
    inside = max(ends[0], low), min(ends[1], high)
    log = value > 0 and inside[0] > 0
    return Knob(entry.name, entry.name, *inside, log=log) if inside[0] < inside[1] else None


def _usual_metrics(flow: Ode) -> tuple[AbstractMetric, ...]:
    tracking = (rmse(), peak_error()) if flow.follows else ()
    return (*tracking, *((effort(),) if flow.drives else ()))


def _sections(results: Results) -> tuple[Section, ...]:
    outcome = results.outcomes[0]
    panels = [panel for name in shown_signals(outcome) if (panel := _panel(outcome, name))]
    figure = Figure("signals", "The signals of the loop over time.", tuple(panels))
    return (Section("The loop", (figure, _scores(outcome))),)


def _scores(outcome: Outcome) -> Table:
    """A row for each number of each metric."""
    rows: list[tuple[Cell, ...]] = []
    for name, score in outcome.measurement.scores.items():
        for place, (label, unit) in enumerate(zip(score.metric.labels, score.metric.units, strict=True)):
            rows.append((name, label, _cell(outcome, *outcome.score(name, place)), raised(unit)))
    columns = (Column("metric"), Column("of"), Column("value", align="right"), Column("unit"))
    return Table("scores", "The metrics of the loop.", columns, tuple(rows))


def _cell(outcome: Outcome, value: float, error: float) -> Cell:
    if outcome.diverged_at is not None:
        return Diverged(outcome.diverged_at)
    return Measured(value, error) if np.isfinite([value, error]).all() else "never"


def shown_signals(outcome: Outcome) -> tuple[str, ...]:
    """The signals that a page of a loop draws: what it follows and what drives it, or else its outputs, or states."""
    step = outcome.measurement.trajectories.step
    applied = (f"{name}_applied" for name in step.flow.drives)
    drives = tuple(name for name in applied if name in step.flow.outputs) or step.flow.drives
    known = tuple(name for name in (*step.flow.follows, *drives) if name in step.outputs)
    own = tuple(name for name in step.states.names if name in step.flow.states)
    return known or step.outputs.names or own


def _panel(outcome: Outcome, name: str) -> Panel | None:
    """The numbers of a signal over its reference."""
    step, t = outcome.measurement.trajectories.step, outcome.t
    entry = step.outputs[name] if name in step.outputs else step.states[name]
    labels = entry.labels() if entry.size > 1 else [name]
    lines = [Series(label, t, _finite(outcome, name, i), i % 12) for i, label in enumerate(labels)]
    if f"{name}_ref" in step.outputs:
        lines += [Series("reference", t, _finite(outcome, f"{name}_ref", i), "reference") for i in range(len(labels))]
    unit = ", ".join(dict.fromkeys(raised(unit) for unit in entry.units if unit))
    return Panel(f"{name} [{unit}]" if unit else name, tuple(lines))


def _finite(outcome: Outcome, name: str, place: int) -> Array:
    y = outcome.signal(name, place)
    return np.where(np.isfinite(y), y, np.nan)
