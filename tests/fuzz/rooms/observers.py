from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from workbench import observers

from ..parts import ARM, OBSERVER, signals

MODULES = ("workbench.observers",)


def calls() -> dict[str, Any]:
    oracle = observers.OracleFilter(2, 1.0)
    return {
        "AbstractDisturbanceObserver": oracle,
        "DirtyDerivative": partial(observers.DirtyDerivative, 2, 100.0, [0.1, 0.2]),
        "FullState": partial(observers.FullState, 2),
        "Luenberger": partial(observers.Luenberger, ARM, np.eye(2), np.eye(2), [0.1, 0.2], [0.0, 0.0]),
        "MomentumObserver": partial(observers.MomentumObserver, ARM, 1.0, [0.0, 0.0]),
        "NonlinearDisturbanceObserver": partial(observers.NonlinearDisturbanceObserver, ARM, 1.0, [0.0, 0.0]),
        "OracleFilter": partial(observers.OracleFilter, 2, 1.0),
        "PrintedFilter": partial(observers.PrintedFilter, 2, 1.0),
        "VelocityFilter": partial(observers.VelocityFilter, 2, 100.0, [0.0, 0.0]),
        "WithDisturbance": partial(observers.WithDisturbance, OBSERVER, oracle),
    }


def arguments() -> dict[str, Any]:
    return signals()
