from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from workbench.study.document import plane_marks as marks

OMEGA = np.array([0.5, 1.0, 2.0, 4.0])


def calls() -> dict[str, Any]:
    return {
        "Area": partial(marks.Area, "a", OMEGA, OMEGA, 1),
        "Arrows": partial(marks.Arrows, "a", OMEGA, OMEGA, OMEGA, OMEGA, 1, 5.0),
        "Guides": partial(marks.Guides, ((OMEGA, OMEGA),), ("g",)),
    }


def arguments() -> dict[str, Any]:
    return {}
