"""The data of a live page: knobs, loops with their modules, and the curves and cells that are theirs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from workbench.metrics.accumulators import resolved
from workbench.study.document.document import Document
from workbench.study.document.phrases import raised
from workbench.study.live.knob import Knob, check, has, value_of
from workbench.study.live.links import cells, curves
from workbench.study.live.marches import Modules, coarse_and_fine, march, plain, watched
from workbench.study.study import Outcome, Results, Study
from workbench.validation.signatures import door

FORMAT = 1


@door
def live_data(study: Study, results: Results, document: Document) -> dict[str, Any] | None:
    """What the page of a study needs to run its loops again, as plain data; None where nothing can be turned.

    A loop that no browser can run stays printed, and the data say why.

    Raises
    ------
    ValueError, LookupError
        If a knob of the study fits no loop, or leads beyond the bounds of its number.
    """
    if study.live is None:
        return None
    found = (*curves(document, results.outcomes), *cells(document, results.outcomes))
    outcomes = [results.outcomes[k] for k in sorted({one.loop for one in found})]
    places = {results.outcomes.index(outcome): i for i, outcome in enumerate(outcomes)}
    knobs = study.live or _offered(study, outcomes)
    if not (knobs and outcomes):
        return None
    steps = {outcome.case.name: outcome.measurement.trajectories.step for outcome in outcomes}
    check(knobs, steps)
    modules, refused, loops = Modules(), {}, []
    links = [asdict(one) | {"loop": places[one.loop]} for one in found]
    for i, outcome in enumerate(outcomes):
        mine = [link for link in links if link["loop"] == i]
        try:
            loops.append(_loop(outcome, knobs, mine, modules))
        except (ValueError, ImportError) as error:
            refused[outcome.case.name] = str(error)
            loops.append(None)
    live = [link for link in links if loops[link["loop"]]]
    return {
        "format": FORMAT,
        "study": study.name,
        "version": document.colophon.version,
        "knobs": [_knob(knob, outcomes) for knob in knobs],
        "loops": loops,
        "modules": list(modules.packed.values()),
        "curves": [link for link in live if "figure" in link],
        "cells": [link for link in live if "table" in link],
        "refused": refused,
    }


def _offered(study: Study, outcomes: Sequence[Outcome]) -> tuple[Knob, ...]:
    """The factors of the sweeps, each once, that a loop of the page has."""
    sweeps = () if callable(study.sweeps) else study.sweeps
    knobs = {factor.name: Knob.of(factor) for sweep in sweeps for factor in sweep.factors}
    steps = [outcome.measurement.trajectories.step for outcome in outcomes]
    return tuple(knob for knob in knobs.values() if all(any(has(step, path) for step in steps) for path in knob.paths))


def _knob(knob: Knob, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """A knob with the number at which it stands, which is the same in all loops that have it."""
    runs = [outcome.measurement.trajectories for outcome in outcomes]
    moved = [run for run in runs if knob.places(run.step)]
    values = {value_of(knob, run.step, run.p[0], run.x[0, 0]) for run in moved}
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
    return held | {"value": value, "unit": raised(knob.unit(moved[0].step))}


def _loop(outcome: Outcome, knobs: Sequence[Knob], links: Sequence[dict[str, Any]], modules: Modules) -> dict[str, Any]:
    """A case as a browser runs it; the links name the outputs that it shows, which from here on count only these."""
    run, case = outcome.measurement.trajectories, outcome.case
    coarse, fine = coarse_and_fine(outcome)
    every = case.run.every or coarse.h
    shown = [link[axis][1] for link in links for axis in ("x", "y") if "figure" in link and link[axis][0] == "y"]
    wanted = sorted(set(shown))
    for link in links:
        for axis in ("x", "y"):
            if "figure" in link and link[axis][0] == "y":
                link[axis] = ("y", wanted.index(link[axis][1]))
    size = fine.parameters.size
    moves = [(i, knob.places(fine)) for i, knob in enumerate(knobs)]
    metrics = resolved(outcome.ode, case.run.metrics, case.run.until)
    programs = programs_of(fine, metrics)
    return {
        "scenario": case.scenario,
        "law": case.law,
        "label": outcome.label,
        "until": float(run.t[-1]),
        "every": every,
        "rows": len(run.t) - 1,
        "p": plain(run.p[0]),
        "x0": plain(run.x[0, 0]),
        "moves": [
            {"knob": i, "p": [k for k in places if k < size], "x": [k - size for k in places if k >= size]}
            for i, places in moves
            if places
        ],
        "seed": str(case.run.seed),
        "normals": fine.noises,
        "coarse": march(coarse, round(every / coarse.h), modules),
        "fine": march(fine, round(every / fine.h), modules),
        "outputs": march(watched(fine, fine.rule.output[wanted]), 1, modules) if wanted else None,
        "metrics": [
            {"name": m.name, "unit": m.unit, "units": m.units, "labels": m.labels, "time": m.is_time, "program": program}
            for m, program in zip(metrics, programs, strict=True)
        ],
        "scores": [
            [plain(pair) for pair in zip(score.value[0], score.error[0], strict=True)]
            for score in outcome.measurement.scores.values()
        ],
    }
