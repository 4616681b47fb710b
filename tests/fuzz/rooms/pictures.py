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
        "Tiles": partial(marks.Tiles, "a", ((("x",), ("y", "z")),), [[0.5, np.nan]], True, [[True, False]], False, ()),
        "loops_section": partial(traces.loops_section, "h", "about", outcomes(), "e", caption="c", cut=0.25),
        "components": partial(traces.components, "f", "c", outcomes()[0], [("e", "e", 0)], "e", [window]),
    }


def arguments() -> dict[str, Any]:
    return {}
