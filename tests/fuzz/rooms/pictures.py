from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import workbench.report.pictures as traces
from workbench.study.document import figure as marks

from .study import outcomes

T = np.array([1.0, 2.0])


def calls() -> dict[str, Any]:
    window = traces.Window(0.0, 1.0)
    return {
        "Band": partial(marks.Band, "a", T, T, T, 1),
        "Bars": partial(
            marks.Bars, "a", [0.0, 1.0], [1.0, 2.0], [0.0, 0.0], 1, 0.5, 0.7, [0.5, 1.0], [2.0, 3.0], ("x", "y")
        ),
        "Points": partial(marks.Points, "a", T, T, ("x", "y"), 1, T, T, T, T),
        "Series": partial(marks.Series, "a", T, T, 1, "steps"),
        "Tiles": partial(marks.Tiles, "a", ((("x",), ("y", "z")),), [[0.5, np.nan]], True, [[True, False]], False, ()),
        "Window": partial(traces.Window, 0.0, 1.0, (0.0, 1.0)),
        "components": partial(traces.components, "f", "c", outcomes()[0], [("e", "e", 0)], "e", [window]),
        "curve": partial(traces.curve, outcomes()[0], "e", 0, None, "law", 1, look="steps", unit=(1e3, "m")),
        "traces": partial(traces.traces, "f", "c", outcomes(), "e", 0, "e", [window], "e"),
    }


def arguments() -> dict[str, Any]:
    return {}
