"""The study of a single loop, for a page on which one tries it: signals, metrics, and all its numbers as knobs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Ode, SampledSystem, StepMap
from workbench.core.equations import Loop, equations_of
from workbench.core.validation.refusals import multiple, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.engine.metrics import AbstractMetric, effort, peak_error, rmse
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.report.pictures.loop_gain_pictures import loop_gain_pictures
from workbench.report.pictures.plan_curves import plan_curves
from workbench.report.pictures.traces import curve
from workbench.study.design_knob import DesignKnob
from workbench.study.document.document import (
    Cell,
    Figure,
    Panel,
    Paragraph,
    ReportTable,
    Section,
    TableColumn,
)
from workbench.study.document.phrases_and_tables import superscript_powers
from workbench.study.knob import Knob
from workbench.study.pid_specification import PidSpecification, knobs_among
from workbench.study.result_marks import cell
from workbench.study.run_and_sweep import Run
from workbench.study.study import Case, Outcome, Results, Study

REACH = 5.0  # a knob goes from a fifth of the loop's own number to five times as much
ABOUT_ZERO = 1.0  # as far as a knob goes either way from a number that is zero
BESIDE = 0.5  # of the width of a text: a picture among others
POINTS = 1000  # kept times, or about that many
FIRST = ("controller", "plant", "reference", "observer", "instruments")  # the blocks whose knobs come first
PID_NUMBERS = ("Kp", "Ki", "Kd", "N", "b", "c")
UNKNOWN_UNIT = "?"  # as the unit of a number that nobody named


@check_arguments
def loop_study(
    loop: Loop | Ode | SampledSystem,
    until: float,
    h: float,
    metrics: Sequence[AbstractMetric] = (),
    knobs: Sequence[Knob | DesignKnob | PidSpecification] = (),
    title: str = "",
) -> Study:
    """The study with one case: a loop until a horizon [s], at a step h [s], of a sampled loop a substep.

    The values are those of the step h, their errors from h / 2. Without `metrics` they are those of
    tracking errors and inputs; without `knobs` every number on which the page depends is one, a vector by a share of
    itself, and so is each initial state of the plant that is not zero. A loop whose law is a `PID` of one signal then
    has a specification, too.

    Raises
    ------
    ValueError
        If the loop is none, or h does not divide the horizon.
    """
    equation, until = equations_of(loop, "loop"), seconds("live(until=...)", until)
    flow = equation if isinstance(equation, Ode) else equation.flow
    step = equation.period if isinstance(equation, SampledSystem) else seconds("live(h=...)", h)
    every = step * max(1, round(until / step / POINTS))
    while multiple("live(until=...)", until, step, "the step") % round(every / step):
        every -= step
    taken = tuple(metrics) or _usual_metrics(flow)
    case = Case("run", flow.name, Run(loop, taken, until, every, h))
    return Study(
        "live",
        title or f"The loop '{flow.name}', to be turned",
        "How does the loop answer to its numbers?",
        f"One run over {until:g} s at h = {h:g} s; values at the step, errors from half of it.",
        _sections,
        cases=(case,),
        live=_controls(loop, knobs, MeasuredEquation.of(equation, taken).step(h)),
    )


def _controls(
    loop: Loop | Ode | SampledSystem, given: Sequence[Knob | DesignKnob | PidSpecification], step: StepMap
) -> tuple[Knob | DesignKnob | PidSpecification, ...]:
    """All that a reader turns: what is given, and else the numbers of the loop, with the specification of its PID."""
    if given:
        return (*given, *(() if knobs_among(given) else knobs_of(step)))
    knobs, one = knobs_of(step), PidSpecification("specification")
    own = {knob.path for knob in knobs if not knob.share}
    is_pid = (
        all(f"{one.law}.{name}" in step.parameters for name in PID_NUMBERS) and f"{one.law}.integral" in step.states
    )
    can_be_cut = not isinstance(loop, Ode | SampledSystem)
    return (*knobs, one) if can_be_cut and is_pid and {*one.paths[:2]} <= own else knobs


def knobs_of(step: StepMap) -> tuple[Knob, ...]:
    """A knob for each number of a step that moves what its page shows, laws first and what they believe last.

    A number that a design computes together with others has none.
    """
    seen = [place for name in shown_signals(step) for place in _places(step, name)]
    moving = step.rule.without_crossings(ca.vertcat(step.rule.rate, step.rule.update, step.rule.output[seen]))
    used = np.array(ca.which_depends(moving, step.rule.p, 1, False), dtype=bool)
    free = [entry for entry in step.parameters.entries if not entry.is_derived]
    entries = [entry for entry in free if used[step.parameters.slice(entry.name)].any()]
    starts = [entry for entry in step.states.entries if _block(entry) == "plant" and entry.default.any()]
    knobs = [knob for entry in sorted((*entries, *starts), key=_rank) if (knob := _knob(entry))]
    times = Counter(_brief(knob.name) for knob in knobs)
    return tuple(replace(one, name=name) if times[name := _brief(one.name)] == 1 else one for one in knobs)


def _brief(path: str) -> str:
    """A path without what stands between its block and its last two names."""
    block, *others = path.split(".")
    return ".".join([block, *others[-2:]])


def _places(step: StepMap, name: str) -> list[int]:
    """The places of a signal and its reference among the outputs of a step."""
    all_places, there = range(step.outputs.size), (one for one in (name, f"{name}_ref") if one in step.outputs)
    return [place for one in there for place in all_places[step.outputs.slice(one)]]


def _block(entry: Entry) -> str:
    return entry.name.split(".")[0]


def _rank(entry: Entry) -> tuple[bool, int]:
    """The numbers of models, which are those of the plant again, come behind all others."""
    block = _block(entry)
    return "model" in entry.name.split("."), FIRST.index(block) if block in FIRST else len(FIRST)


def _knob(entry: Entry) -> Knob | None:
    """The knob of a number, or of a share of several, or of one without a known unit; none for zeros of those."""
    values, bounds = entry.default.ravel(), entry.bounds
    share = entry.size > 1 or entry.units[0] == UNKNOWN_UNIT
    if not np.isfinite(values).all() or (share and not values.any()):
        return None
    value, low, high = float(values[0]), bounds.low, bounds.high
    if share:
        ends = np.sort([[low / x, high / x] for x in values if x])
        value, low, high = 1.0, ends[:, 0].max(), ends[:, 1].min()
    if bounds.strict:  # an end that must not be reached: a fifth of the way to it is left
        low, high = (value / REACH + end * (1 - 1 / REACH) for end in (low, high))
    first, last = sorted((value / REACH, value * REACH)) if value else (-ABOUT_ZERO, ABOUT_ZERO)
    first, last = max(first, float(low)), min(last, float(high))
    log = min(value, first) > 0
    return Knob(entry.name, entry.name, first, last, log, origin="", share=share) if first < last else None


def _usual_metrics(flow: Ode) -> tuple[AbstractMetric, ...]:
    tracking = (rmse(), peak_error()) if flow.follows else ()
    return (*tracking, *((effort(),) if flow.drives else ()))


def _sections(results: Results) -> tuple[Section, ...]:
    outcome = results.outcomes[0]
    names = shown_signals(outcome.measurement.trajectories.step)
    figures = (_picture(outcome, i, name) for i, name in enumerate(names, 1))
    scores = (_scores(outcome),) if outcome.measurement.scores else ()
    first = Section("The loop", (*_warned(outcome), *figures, *scores))
    if isinstance(outcome.case.run.loop, Ode | SampledSystem):  # equations alone, which do not say where a loop is cut
        return (first,)
    return first, Section("The linear loop", loop_gain_pictures(outcome, "linear", BESIDE, loop=""))


def _warned(outcome: Outcome) -> tuple[Paragraph, ...]:
    """The warnings of the run as it is printed."""
    runs = outcome.measurement.trajectories
    said = dict.fromkeys((*outcome.measurement.warnings, *runs.check.warnings))
    return (Paragraph(f"At the baseline, {'; '.join(said)}."),) if said else ()


def _scores(outcome: Outcome) -> ReportTable:
    """A row for each number of each metric."""
    rows: list[tuple[Cell, ...]] = []
    for name, place, unit, label in outcome.measurement.columns:
        rows.append((name, label, cell(outcome, name, place), superscript_powers(unit)))
    columns = (TableColumn("metric"), TableColumn("of"), TableColumn("value", align="right"), TableColumn("unit"))
    return ReportTable("scores", "The metrics of the loop.", columns, tuple(rows))


def shown_signals(step: StepMap) -> tuple[str, ...]:
    """The signals that a page of a loop draws: what it follows and what drives it, or else its outputs, or states."""
    flow = step.flow
    known = tuple(name for name in flow.default_signals if name in step.outputs or name in step.states)
    return known or step.outputs.names or tuple(name for name in step.states.names if name in flow.states)


def _picture(outcome: Outcome, number: int, name: str) -> Figure:
    """A signal over time, as wide as one of several pictures side by side."""
    return Figure(f"signal_{number}", f"{name} over time.", (_panel(outcome, name),), width=BESIDE, title=name)


def _panel(outcome: Outcome, name: str) -> Panel:
    """The numbers of a signal over its reference; a single one needs no name beside that of its axis."""
    step = outcome.measurement.trajectories.step
    entry = step.outputs[name] if name in step.outputs else step.states[name]
    labels = [label.removeprefix(name) for label in entry.labels()] if entry.size > 1 else [""]
    lines = [curve(outcome, name, i, label=label, style=i % 12) for i, label in enumerate(labels)]
    lines += [one for i in range(len(labels)) for one in plan_curves(outcome, name, i)]
    if f"{name}_ref" in step.outputs:
        lines += [curve(outcome, f"{name}_ref", i, label="reference", style="reference") for i in range(len(labels))]
    unit = ", ".join(dict.fromkeys(superscript_powers(unit) for unit in entry.units if unit))
    return Panel(f"{name} [{unit}]" if unit else name, tuple(lines))
