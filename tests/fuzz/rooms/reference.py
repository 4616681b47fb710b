from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from workbench.engine import reference as room

from ..parts import ODE

MODULES = ("workbench.engine.reference",)


def rate(t: float, x: Any) -> Any:
    """x' = -x."""
    return -x


def calls() -> dict[str, Any]:
    how = {"times": [0.0, 0.5], "rtol": 1e-6, "atol": 1e-8, "method": "auto", "most_steps": 1000}
    one = np.ones(1)
    return {
        "Reference": partial(
            room.Reference, one, np.ones((1, 1)), np.zeros((1, 1)), (), 0.0, ((0.0, 1.0, ("x",)),), 3, 9, "explicit"
        ),
        "reference": partial(room.reference, ODE, [2.0], [1.0], **how),
        "reference_of_function": partial(room.reference_of_function, rate, [1.0, 2.0], **how),
    }


def arguments() -> dict[str, Any]:
    return {}
