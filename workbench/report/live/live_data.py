"""The data of a live page: knobs, loops with their modules, and the curves and cells that are theirs."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import casadi as ca

from workbench.core import Ode, StepMap
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.engine.metrics import AbstractMetric
from workbench.engine.metrics.value_program import program_of
from workbench.report.live.linear_data import linear_data
from workbench.report.live.links import Curve, LinearCell, LinearMark, Links, LiveCell, LiveMark, links_of
from workbench.report.live.marches import (
    Modules,
    coarser,
    evaluation,
    march,
    may_switch,
    plain,
    switches,
    whole_and_half,
)
from workbench.report.live.page_data import LiveData, Plain
from workbench.report.live.specification_data import specification_data
from workbench.report.live.turned_knobs import knobs_of_sweeps
from workbench.study.design_knob import DesignKnob
from workbench.study.document.document import Document
from workbench.study.document.phrases_and_tables import superscript_powers
from workbench.study.document.printed_results import PrintedResults
from workbench.study.knob import Knob, check
from workbench.study.pid_specification import knobs_among, specifications_among
from workbench.study.result_marks import Signal
from workbench.study.study import Outcome, Results, Study

FORMAT = 2
# the lines that compute the same, with places for the name of a case, the values of knobs and a seed
PYTHON = """import workbench as wb

study = wb.load({script!r})
found = wb.turn_knobs(study, {{case}}, {{values}}, seed={{seed}})
"""
# and the line that gives the linear answer of the same case behind them
PYTHON_LINEAR = "linear = wb.linear_loop_at_knobs(study, {case}, {values})\n"


@check_arguments
def live_data(study: Study, results: Results, document: Document, script: str = "") -> LiveData | None:
    """The data with which the page of a study runs its loops again, plain; None where nothing can be turned.

    A loop that no browser can run stays printed, and the data say why; without llvmlite there are no data. `script` is
    the file of the study, for the lines that compute the same in Python.

    Raises
    ------
    ValueError, LookupError
        If a knob of the study fits no loop, or leads beyond the bounds of its number.
    """
    if study.live is None:
        return None
    links = links_of(PrintedResults.of(document), results.outcomes)
    outcomes = {k: results.outcomes[k] for k in sorted(links.moving_loops | links.linear_loops)}
    steps = {outcome.case.name: outcome.measurement.trajectories.step for outcome in outcomes.values()}
    knobs = knobs_among(study.live) or knobs_of_sweeps(study, [*steps.values()])
    if not (knobs and outcomes):
        return None
    check(knobs, steps)
    try:
        page = _page_loops(links, outcomes, knobs)
    except ImportError:  # llvmlite is not here, and nothing can be compiled for a browser
        return None
    runs = bool(script) and not callable(study.cases)
    digests = "".join(outcome.digest for outcome in outcomes.values())
    return {
        "format": FORMAT,
        "study": study.name,
        "version": document.colophon.version,
        "fingerprint": hashlib.sha256(digests.encode()).hexdigest()[:16],
        "python": PYTHON.format(script=script) if runs else "",  # else nobody could run it
        "python_linear": PYTHON_LINEAR if runs else "",
        "scenario": "",
        "knobs": [_knob(knob, [*outcomes.values()]) for knob in knobs],
        "specifications": specification_data(specifications_among(study.live), knobs, page.loops),
        "loops": page.loops,
        "modules": list(page.modules.packed_modules.values()),
        "records": [],
        "curves": [asdict(curve) for curve in page.curves],
        "cells": [*_plain_links(links.cells, page.places), *_plain_links(links.linear_cells, page.places)],
        "marks": _plain_links(links.marks, page.places),
        "linear_marks": _plain_links(links.linear_marks, page.places),
        "refused": page.refused,
    }


@dataclass(frozen=True)
class _PageLoops:
    """The loops of a page with their modules and curves, their places by those of outcomes, and why others are none."""

    loops: list[Plain]
    curves: list[Curve]
    places: dict[int, int]
    refused: dict[str, str]
    modules: Modules


def _page_loops(links: Links, outcomes: Mapping[int, Outcome], knobs: Sequence[Knob | DesignKnob]) -> _PageLoops:
    """Each outcome as a loop that a browser runs, or the reason why none can, by the name of its case."""
    page = _PageLoops([], [], {}, {}, Modules())
    for k, outcome in outcomes.items():
        mine = [replace(link, loop=len(page.loops)) for link in links.curves if link.loop == k]
        try:
            loop, curves = _loop(outcome, knobs, mine, page.modules, k in links.linear_loops)
        except ValueError as error:
            page.refused[outcome.case.name] = str(error)
            continue
        page.places[k] = len(page.loops)
        page.loops.append(loop | _everywhere(links, k))
        page.curves.extend(curves)
    return page


def _plain_links(
    links: Sequence[LiveCell | LinearCell | LiveMark | LinearMark], places: Mapping[int, int]
) -> list[Plain]:
    """The links of those loops that have a place on the page, with these places."""
    return [asdict(link) | {"loop": places[link.loop]} for link in links if link.loop in places]


def _everywhere(links: Links, loop: int) -> Plain:
    """The marks of a loop of which a page shows linear answers alone, beside the runs of others; else none.

    It belongs to each scenario, and there is nothing to watch.
    """
    return {"everywhere": True, "drawing": None} if links.moving_loops and loop not in links.moving_loops else {}


def _knob(knob: Knob | DesignKnob, outcomes: Sequence[Outcome]) -> Plain:
    """A knob with the number at which it stands, which is the same in all loops that have it."""
    runs = [run for outcome in outcomes if knob.places((run := outcome.measurement.trajectories).step)]
    values = {knob.value(run.step, run.p[0], run.x[0, 0]) for run in runs}
    if len(values) > 1:
        raise ValueError(
            f"`Knob({knob.name!r}, ...)` must turn one number, and '{knob.paths[0]}' is "
            f"{' or '.join(f'{value:g}' for value in sorted(values))} in different loops: turn a share of it, with "
            "`share=True`."
        )
    value = values.pop()
    if not knob.low <= value <= knob.high:
        raise ValueError(
            f"`Knob({knob.name!r}, low=..., high=...)` must hold the number of the loops, {value:g}; got {knob.low:g} "
            f"to {knob.high:g}."
        )
    held = {name: getattr(knob, name) for name in ("name", "paths", "low", "high", "log", "origin", "share")}
    if isinstance(knob, DesignKnob):
        return held | {"paths": [], "value": value, "unit": superscript_powers(knob.unit), "stops": plain(knob.values)}
    return held | {"value": value, "unit": superscript_powers(knob.unit(runs[0].step))}


def _loop(
    outcome: Outcome, knobs: Sequence[Knob | DesignKnob], links: Sequence[Curve], modules: Modules, linear: bool
) -> tuple[Plain, list[Curve]]:
    """A case as a browser runs it, and its curves, whose outputs are counted among those that the loop makes there.

    With `linear`, where the page shows linear answers of it, these are made there, too.
    """
    case, run = outcome.case, outcome.measurement.trajectories
    whole, half = whole_and_half(outcome)
    every = case.run.every or whole.h
    wanted = _wanted(links)
    metrics, drawing = outcome.measurement.metrics, outcome.ode.drawing
    seen = ca.vertcat(whole.rule.output[wanted], ca.SX(0, 1) if drawing is None else _moving(outcome, whole))
    places = [knob.places(whole) for knob in knobs]
    switched = may_switch(whole, run.p[0], [k for here in places for k in here if k < whole.parameters.size])
    moving = {"first": len(wanted), "places": seen.numel() - len(wanted)}  # behind the outputs
    made = {
        "scenario": case.scenario,
        "law": case.law,
        "label": outcome.label,
        "digest": outcome.digest[:16],
        "until": float(run.t[-1]),
        "every": every,
        "rows": len(run.t) - 1,
        "p": plain(run.p[0]),
        "x0": plain(run.x[0, 0]),
        "moves": _moves(knobs, whole, places, linear),
        "seed": str(case.run.seed),
        "normals": whole.noises,
        "switches": switches(outcome.ode),
        "whole": march(whole, round(every / whole.h), modules, switched),
        "coarse": coarser(whole, len(run.t) - 1, round(every / whole.h), switched) if _has_finer(outcome) else [],
        "half": march(half, round(every / half.h), modules, switched),
        "outputs": march(evaluation(whole, seen), 1, modules) if seen.numel() else None,
        "drawing": None if drawing is None else drawing.data | moving,
        "metrics": [
            {"name": m.name, "units": m.units, "labels": m.labels, "time": m.is_time, "program": program}
            for m, program in zip(metrics, _programs(whole, metrics, run.t), strict=True)
        ],
        "scores": [
            [plain(score.pair) for score in outcome.measurement.scores_of(name)] for name in outcome.measurement.names
        ],
        **(linear_data(outcome, modules) if linear else {"linear": None, "linear_refused": ""}),
    }

    def among_wanted(axis: Signal) -> Signal:
        return ("y", wanted.index(axis[1])) if isinstance(axis, tuple) and axis[0] == "y" else axis

    return made, [replace(link, x=among_wanted(link.x), y=among_wanted(link.y)) for link in links]


def _wanted(links: Sequence[Curve]) -> list[int]:
    """The places of the outputs that curves show, a plan at each of its stages."""
    axes = [(axis[1], link.stages or 1) for link in links for axis in (link.x, link.y) if axis[0] == "y"]
    return sorted({int(place) + j for place, stages in axes for j in range(stages)})


def _has_finer(outcome: Outcome) -> bool:
    """True if the steps of a loop approximate finer ones, as those of a loop in a computer, or with noise, do not."""
    return isinstance(outcome.ode, Ode) and not outcome.measurement.trajectories.step.noises


def _moving(outcome: Outcome, step: StepMap) -> ca.SX:
    """The coordinates of the drawing of a loop, (n, 1), in the symbols of its step."""
    ode, rule = outcome.ode if isinstance(outcome.ode, Ode) else outcome.ode.flow, step.rule
    assert ode.drawing is not None
    own = ca.vertcat(rule.t, rule.x[: ode.x.numel()], rule.p)
    return ca.substitute(ode.drawing.coordinates, ca.vertcat(ode.t, ode.x, ode.p), own)


def _programs(step: StepMap, metrics: Sequence[AbstractMetric], t: Array) -> list[Plain | None]:
    """The value of each metric at the horizon as a program; None where no other machine can run it."""
    programs: list[Plain | None] = []
    for metric in metrics:
        try:
            programs.append(program_of(step, metric, float(t[-1])).plain())
        except ValueError:
            programs.append(None)
    return programs


def _moves(
    knobs: Sequence[Knob | DesignKnob], step: StepMap, places: Sequence[tuple[int, ...]], named: bool
) -> list[Plain]:
    """The places among the parameters and states of a step that each knob moves, with their names if asked."""
    size, labels = step.parameters.size, (*step.parameters.labels, *step.states.labels)
    return [
        {
            "knob": i,
            "p": [k for k in here if k < size],
            "x": [k - size for k in here if k >= size],
            "names": [labels[k] for k in sorted(here, key=lambda k: k >= size)] if named else [],
            "designs": [plain(row) for row in knob.table] if isinstance(knob, DesignKnob) else [],
        }
        for i, (knob, here) in enumerate(zip(knobs, places, strict=True))
        if here
    ]
