"""Live pages for tests: the data of a few short runs, and a page that holds them and little else."""

from __future__ import annotations

import base64
import json
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, StepMap
from workbench.engine import metrics, simulate
from workbench.engine.kernel.plan import KernelPlan
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.report.live_page import WORKER

TEMPLATES = Path(__file__).parents[2] / "workbench" / "report" / "templates"
SCRIPTS = (
    *("address", "knobs", "answers", "holds", "pictures", "figures", "tables", "animation", "pool", "motion"),
    *("handles", "crossover_handle", "pole_handles", "specification", "page"),
)
SHOWN = 3  # outputs at most
POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; font-src data:; "
    "script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:"
)
STAND_INS = {  # for other files of a page, as far as these tests need them: they keep what they are told
    "figures": """
        const shown = {};
        function openFigure(svg) {
          return {
            show(curves) {
              if (!curves.length) { this.clear(); return; }
              shown[svg.id] = curves; lines(svg, curves); window.paintedAt = performance.now(); },
            clear() { delete shown[svg.id]; svg.replaceChildren(); },
            cursor() {},
          };
        }
        function lines(svg, curves) {
          svg.replaceChildren(...curves.map(({x, y}) => {
            const line = document.createElementNS("http://www.w3.org/2000/svg", "polyline");
            const points = [...x].flatMap((t, i) => (Number.isFinite(y[i]) ? [60 * t, 80 - 30 * y[i]] : []));
            line.setAttribute("points", points.join(" "));
            line.setAttribute("style", "fill: none; stroke: #0067a8");
            return line;
          }));
        }""",
    "animation": """
        function openAnimation(element, drawing) {
          const stood = {
            load(frames, before, times, divergedAt) { Object.assign(stood, {frames, before, times, divergedAt}); },
            pause() {},
          };
          return (window.animation = stood);
        }""",
    "tables": """
        const scored = new Map();
        function openTables() {
          return {
            show(place, scores) { scored.set(place, scores); },
            showLinear() {},
            clear(place) { scored.delete(place); },
          };
        }
        function scoresOf(loop, whole, half = whole) {
          const value = (ends, place) => (ends ? Math.sqrt(ends.x[place] / loop.until) : NaN);
          return loop.metrics.map(({ program }) => program.results.map((_, i) => {
            const [, place] = program.inputs[i];
            return [value(whole, place), 2 * Math.abs(value(whole, place) - value(half, place))];
          }));
        }""",
}


def data_of(loops: dict[tuple[str, str], Any], h: float, until: float, every: float, knobs: Any, seed: int = 0) -> Any:
    """The data of equations by scenario and law: steps h and h / 2, knobs as (name, unit, path, low, high, log)."""
    modules: dict[str, int] = {}
    made, curves, found = [], [], {}
    for number, ((scenario, law), equation) in enumerate(loops.items()):
        measured = MeasuredEquation.of(equation, [metrics.rmse()])
        whole = measured.step(h)
        moves, values = _moves(whole, knobs)
        found |= values
        data = _loop_data(measured, (h, until, every), seed, modules)
        made.append({"scenario": scenario, "law": law, "label": law, "moves": moves, **data})
        curves += [
            {"figure": f"figure_{panel}", "panel": 0, "series": number, "loop": number, "x": "t", "y": ["y", panel],
             "rows": [0, data["rows"] + 1], "scales": [1, 1]}
            for panel in range(min(whole.outputs.size, SHOWN))
        ]  # fmt: skip
    turned = [
        {"name": name, "unit": unit, "low": low, "high": high, "log": log, "value": found[name], "origin": "assumed",
         "paths": [path], "share": False}
        for name, unit, path, low, high, log in knobs
    ]  # fmt: skip
    return {
        "format": 2,
        "study": "small",
        "knobs": turned,
        "loops": made,
        "modules": list(modules),
        "curves": curves,
        "cells": [],
        "marks": [],
        "plates": {curve["figure"]: {} for curve in curves},
        "python": "import workbench as wb\nrun({case}, {values}, {seed})\n",
    }


def _moves(step: StepMap, knobs: Any) -> tuple[list[dict[str, Any]], dict[str, float]]:
    """The parameters that each knob moves, and their values by the knob's name."""
    moves, found = [], {}
    for place, (name, _, path, *_) in enumerate(knobs):
        if path in step.parameters.names:
            spot = step.parameters.slice(path)
            moves.append({"knob": place, "p": list(range(spot.start, spot.stop)), "x": []})
            found[name] = float(step.parameters.default[spot][0])
    return moves, found


def _loop_data(measured: Any, times: tuple[float, float, float], seed: int, modules: dict[str, int]) -> dict[str, Any]:
    """What a page holds of a loop that is run with the steps h and h / 2 until a time and kept every so often."""
    h, until, every = times
    score, whole, half = measured.metrics[0], measured.step(h), measured.step(h / 2)
    run = simulate(whole, until=until, every=every, seed=seed, arithmetic="portable")
    squares = whole.states.slice("integral of RMSE")
    integrals = range(squares.start, squares.stop)
    rmse = {
        "name": "RMSE",
        "unit": score.unit,
        "units": list(score.units),
        "labels": list(score.labels),
        "time": False,
        "program": {"inputs": [["x", i] for i in integrals], "nodes": [], "results": [*integrals]},
    }
    return {
        "until": until,
        "every": every,
        "rows": len(run.t) - 1,
        "p": whole.parameters.default.tolist(),
        "x0": whole.states.default.tolist(),
        "seed": str(seed),
        "normals": whole.noises,
        "whole": _march(whole, round(every / whole.h), modules),
        "half": _march(half, round(every / half.h), modules),
        "outputs": _march(_watched(whole, min(whole.outputs.size, SHOWN)), 1, modules),
        "metrics": [rmse],
        "scores": [[[float(np.sqrt(run.x[0, -1, i] / until)), 0.0] for i in integrals]],
    }


def _march(step: StepMap, stride: int, modules: dict[str, int]) -> dict[str, Any]:
    from workbench.engine.kernel import webassembly  # with llvmlite, which not every machine has

    plan = KernelPlan.of_step(step, ())
    squeeze = zlib.compressobj(9, wbits=-15)
    packed = squeeze.compress(webassembly.compile_plan(plan)) + squeeze.flush()
    return {
        "module": modules.setdefault(base64.b64encode(packed).decode(), len(modules)),
        "h": step.h,
        "stride": stride,
        "states": step.states.size,
        "parameters": list(plan.parameters),
        "constants": list(plan.constants(step.h)),
        "lanes": len(plan.lanes),
        "table": len(plan.table),
    }


def _watched(step: StepMap, count: int) -> StepMap:
    """The step that leaves the states as they are and puts the first outputs behind them."""
    rule, y = step.rule, ca.SX.sym("y", count)
    update = ca.vertcat(rule.x, ca.densify(rule.output[:count]))
    held = replace(rule, x=ca.vertcat(rule.x, y), rate=ca.SX(0, 1), update=update, output=ca.SX(0, 1))
    states = step.states + Layout(tuple(Entry(f"watched {i}", 0.0) for i in range(count)))
    return replace(step, states=states, outputs=Layout(), rule=held)


def script() -> str:
    """All scripts of a page in their order, with stand-ins for those that are not there."""
    return "\n".join(_script(name) for name in SCRIPTS)


def _script(name: str) -> str:
    if name in STAND_INS:
        return STAND_INS[name]
    return (TEMPLATES / "live" / f"{name}.js").read_text("utf-8")


def write_page(folder: Path, data: Any, body: str = "") -> Path:
    """A page with the data, and an empty drawing for each figure."""
    style = "\n".join((TEMPLATES / name).read_text("utf-8") for name in ("style.css", "live/live.css"))
    style = style[style.index(":root") :]  # without the font
    drawings = "".join(
        f'<figure class="drawing" data-figure="{name}"><div><svg id="{name}" viewBox="0 0 600 160"></svg></div>'
        "</figure>"
        for name in data["plates"]
    )
    worker = "\n".join((TEMPLATES / "live" / f"{name}.js").read_text("utf-8") for name in WORKER)
    text = json.dumps(data).replace("<", "\\u003c")
    path = folder / "live.html"
    path.write_text(
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>Small</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}"><style>{style}</style></head>'
        f"<body><h1>A small page</h1>{body}{drawings}"
        f'<script type="application/json" id="live">{text}</script>'
        f'<script type="text/plain" id="live-worker">{worker}</script><script>{script()}</script></body></html>',
        "utf-8",
    )
    return path
