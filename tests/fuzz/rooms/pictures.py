from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import workbench.report.pictures as traces
from workbench.report import pictures
from workbench.report.pictures import loop_gain_pictures
from workbench.study.document import figure as marks
from workbench.study.uncertainty import sobol

from .evidence import COMPARISON, EFFECTS, INDICES, NAMES, PAIRS, QUANTILES, TORNADO, outputs
from .study import outcomes

MODULES = ("workbench.report.pictures",)
NOTE = "40 runs, none of them failed; seed 0; step error 1e-6."
LABELS = {"k": "stiffness"}
T = np.array([1.0, 2.0])


def calls() -> dict[str, Any]:
    series = marks.Series("a", T, T)
    bars = marks.Bars("a", [0.0, 1.0], [1.0, 2.0], [0.0, 0.0])
    window = traces.Window(0.0, 1.0)
    over_time = sobol(PAIRS, outputs(PAIRS), NAMES)
    return {
        "loops_section": partial(traces.loops_section, "h", "about", outcomes(), "e", caption="c"),
        "Band": partial(marks.Band, "a", T, T, T, 1),
        "Bars": partial(
            marks.Bars, "a", [0.0, 1.0], [1.0, 2.0], [0.0, 0.0], 1, 0.5, 0.7, [0.5, 1.0], [2.0, 3.0], ("x", "y")
        ),
        "Panel": partial(
            marks.Panel, "y", (series,), "x", (0.0, 1.0), (0.5, 1.0), "linear", "log", "t", (0.5,), (0.5,)
        ),
        "Panel with names": partial(marks.Panel, "y", (bars,), ynames=("a", "b")),
        "Points": partial(marks.Points, "a", T, T, ("x", "y"), 1, T, T, T, T),
        "Series": partial(marks.Series, "a", T, T, 1, "steps"),
        "Tiles": partial(marks.Tiles, "a", ((("x",), ("y", "z")),), [[0.5, np.nan]], True, [[True, False]], False, ()),
        "Window": partial(traces.Window, 0.0, 1.0, (0.0, 1.0)),
        "budget_curves": partial(pictures.budget_curves, "f", "c", {"a": (T, [T, T])}, NOTE, "y"),
        "components": partial(traces.components, "f", "c", outcomes()[0], [("e", "e", 0)], "e", [window]),
        "curve": partial(traces.curve, outcomes()[0], "e", 0, None, "law", 1, look="steps", unit=(1e3, "m")),
        "indices_over_time": partial(pictures.indices_over_time, "f", "c", T, over_time, NOTE, labels=LABELS),
        "loop_gain_pictures": partial(loop_gain_pictures.loop_gain_pictures, outcomes()[0], "gain", 0.6),
        "morris_plane": partial(pictures.morris_plane, "f", "c", EFFECTS, NOTE, "rad", labels=LABELS),
        "pareto_fronts": partial(pictures.pareto_fronts, "f", "c", {"a": [[1.0, 2.0], [2.0, 1.0]]}, NOTE, "x", "y"),
        "quantile_bands": partial(pictures.quantile_bands, "f", "c", T, {"a": QUANTILES}, NOTE, "y"),
        "rank_figure": partial(pictures.rank_figure, "f", "c", {"a": [0.5, 0.5], "b": [0.5, 0.5]}, NOTE),
        "sobol_bars": partial(pictures.sobol_bars, "f", "c", INDICES, NOTE, labels=LABELS),
        "standings_figure": partial(pictures.standings_figure, "f", "c", {"s": {"median": COMPARISON}}, "median"),
        "tornado_figure": partial(pictures.tornado_figure, "f", "c", TORNADO, NOTE, "rad", labels=LABELS),
        "traces": partial(traces.traces, "f", "c", outcomes(), "e", 0, "e", [window], "e"),
    }


def arguments() -> dict[str, Any]:
    return {}
