"""The data of a live page: knobs, loops with their modules, and the curves and cells that are theirs."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import casadi as ca

from workbench.core import Ode, Step
from workbench.metrics import AbstractMetric
from workbench.metrics.value_program import program_of
from workbench.study.document.document import Document
from workbench.study.document.phrases import raised
from workbench.study.live.knob import Knob, check
from workbench.study.live.linear_data import linear_data
from workbench.study.live.links import Curve, LinearCell, LinearMark, LiveCell, LiveMark, links
from workbench.study.live.marches import Modules, coarser, march, may_switch, plain, switches, watched, whole_and_half
from workbench.study.live.turned import offered
from workbench.study.study import Outcome, Results, Study
from workbench.validation.refusals import Array
from workbench.validation.signatures import door

FORMAT = 2
# the lines that compute the same, with places for the name of a case, the values of knobs and a seed
PYTHON = """import workbench as wb

study = wb.load({script!r})
found = wb.turned(study, {{case}}, {{values}}, seed={{seed}})
"""
# and the line that gives the linear answer of the same case behind them
PYTHON_LINEAR = "linear = wb.turned_linear(study, {case}, {values})\n"


@door
def live_data(study: Study, results: Results, document: Document, script: str = "") -> dict[str, Any] | None:
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
    found = links(document, results.outcomes)
    used = sorted({link.loop for link in found})
    outcomes = [results.outcomes[k] for k in used]
    steps = {outcome.case.name: outcome.measurement.trajectories.step for outcome in outcomes}
    knobs = study.live or offered(study, [*steps.values()])
    if not (knobs and outcomes):
        return None
    check(knobs, steps)
    modules, refused, live_places = Modules(), dict[str, str](), dict[int, int]()
    loops: list[dict[str, Any]] = []
    live_curves: list[Curve] = []
    for k, outcome in zip(used, outcomes, strict=True):
        mine = [replace(link, loop=len(loops)) for link in found if isinstance(link, Curve) and link.loop == k]
        try:
            made, shown = _loop(outcome, knobs, mine, modules, _is_linear(found, k))
        except ImportError:  # llvmlite is not here, and nothing can be compiled for a browser
            return None
        except ValueError as error:
            refused[outcome.case.name] = str(error)
            continue
        live_places[k] = len(loops)
        loops.append(made | _everywhere(found, k))
        live_curves += shown
    return {
        "format": FORMAT,
        "study": study.name,
        "version": document.colophon.version,
        "fingerprint": hashlib.sha256("".join(outcome.digest for outcome in outcomes).encode()).hexdigest()[:16],
        **_lines(study, script),
        "knobs": [_knob(knob, outcomes) for knob in knobs],
        "loops": loops,
        "modules": list(modules.packed.values()),
        "curves": [asdict(curve) for curve in live_curves],
        **_told_links(found, live_places),
        "refused": refused,
    }


def _lines(study: Study, script: str) -> dict[str, str]:
    """The lines that compute the same in Python, empty where nobody could run them."""
    if callable(study.cases) or not script:
        return {"python": "", "python_linear": ""}
    return {"python": PYTHON.format(script=script), "python_linear": PYTHON_LINEAR}


def _is_linear(found: Sequence[object], loop: int) -> bool:
    """True if a page shows linear answers of a loop."""
    return any(isinstance(link, LinearMark | LinearCell) and link.loop == loop for link in found)


def _everywhere(found: Sequence[object], loop: int) -> dict[str, Any]:
    """The marks of a loop of which a page shows linear answers alone, beside the runs of others; else none.

    It belongs to each scenario, and there is nothing to watch.
    """
    moving = {link.loop for link in found if isinstance(link, Curve | LiveCell | LiveMark)}
    return {"everywhere": True, "drawing": None} if moving and loop not in moving else {}


def _told_links(found: Sequence[object], places: Mapping[int, int]) -> dict[str, Any]:
    """The cells and the marks of a page whose loops are live."""
    return {
        "cells": [*_told(found, LiveCell, places), *_told(found, LinearCell, places)],
        "marks": _told(found, LiveMark, places),
        "linear_marks": _told(found, LinearMark, places),
    }


def _told(
    found: Sequence[object], kind: type[LiveCell | LiveMark | LinearCell | LinearMark], places: Mapping[int, int]
) -> list[dict[str, Any]]:
    """The links of a kind whose loops are live, with the places of these."""
    mine = (link for link in found if isinstance(link, kind))
    return [asdict(link) | {"loop": places[link.loop]} for link in mine if link.loop in places]


def _knob(knob: Knob, outcomes: Sequence[Outcome]) -> dict[str, Any]:
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
    return held | {"value": value, "unit": raised(knob.unit(runs[0].step))}


def _loop(
    outcome: Outcome, knobs: Sequence[Knob], links: Sequence[Curve], modules: Modules, linear: bool
) -> tuple[dict[str, Any], list[Curve]]:
    """A case as a browser runs it, and its curves, whose outputs are counted among those that the loop makes there.

    With `linear`, where the page shows linear answers of it, these are made there, too.
    """
    case, run = outcome.case, outcome.measurement.trajectories
    whole, half = whole_and_half(outcome)
    every = case.run.every or whole.h
    wanted = sorted({int(axis[1]) for link in links for axis in (link.x, link.y) if axis[0] == "y"})
    metrics = outcome.measurement.metrics
    drawing = outcome.ode.drawing
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
        "outputs": march(watched(whole, seen), 1, modules) if seen.numel() else None,
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

    def among_wanted(axis: Any) -> Any:
        return ("y", wanted.index(axis[1])) if axis[0] == "y" else axis

    return made, [replace(link, x=among_wanted(link.x), y=among_wanted(link.y)) for link in links]


def _has_finer(outcome: Outcome) -> bool:
    """True if the steps of a loop approximate finer ones, as those of a loop in a computer, or with noise, do not."""
    return isinstance(outcome.ode, Ode) and not outcome.measurement.trajectories.step.noises


def _moving(outcome: Outcome, step: Step) -> ca.SX:
    """The coordinates of the drawing of a loop, (n, 1), in the symbols of its step."""
    ode, rule = outcome.ode if isinstance(outcome.ode, Ode) else outcome.ode.flow, step.rule
    assert ode.drawing is not None
    own = ca.vertcat(rule.t, rule.x[: ode.x.numel()], rule.p)
    return ca.substitute(ode.drawing.coordinates, ca.vertcat(ode.t, ode.x, ode.p), own)


def _programs(step: Step, metrics: Sequence[AbstractMetric], t: Array) -> list[dict[str, Any] | None]:
    """The value of each metric at the horizon as a program; None where no other machine can run it."""
    programs: list[dict[str, Any] | None] = []
    for metric in metrics:
        try:
            programs.append(program_of(step, metric, float(t[-1])).plain())
        except ValueError:
            programs.append(None)
    return programs


def _moves(knobs: Sequence[Knob], step: Step, places: Sequence[tuple[int, ...]], named: bool) -> list[dict[str, Any]]:
    """The places among the parameters and states of a step that each knob moves, with their names if asked."""
    size, labels = step.parameters.size, (*step.parameters.labels, *step.states.labels)
    return [
        {
            "knob": i,
            "p": [k for k in here if k < size],
            "x": [k - size for k in here if k >= size],
            "names": [labels[k] for k in sorted(here, key=lambda k: k >= size)] if named else [],
        }
        for i, here in enumerate(places)
        if here
    ]
