from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from workbench.arms import observers as arm_observers
from workbench.blocks import observers

from ..parts import ARM, OBSERVER, PLANT, signals

MODULES = ("workbench.arms.observers", "workbench.blocks.observers")


def calls() -> dict[str, Any]:
    oracle, I = arm_observers.OracleFilter(2, 1.0), np.eye(4)
    filtered = (PLANT, I, I[:2, :2], I, 0.01, ("q",), {"q": 2}, 2)
    return {
        "AbstractDisturbanceObserver": oracle,
        "DirtyDerivative": partial(arm_observers.DirtyDerivative, 2, 100.0, [0.1, 0.2]),
        "ExtendedKalmanFilter": partial(observers.ExtendedKalmanFilter, *filtered),
        "ExtendedStateObserver": partial(arm_observers.ExtendedStateObserver, ("x", "v"), "u", 1.0, 10.0, "m", "d"),
        "FullState": partial(arm_observers.FullState, 2),
        "LinearObserver": partial(observers.LinearObserver, PLANT, I, ("q", "qd"), [0.1, 0.2, 0.0, 0.0], [0.0, 0.0]),
        "Luenberger": partial(arm_observers.Luenberger, ARM, np.eye(2), np.eye(2), [0.1, 0.2], [0.0, 0.0]),
        "MomentumObserver": partial(arm_observers.MomentumObserver, ARM, 1.0, [0.0, 0.0]),
        "NonlinearDisturbanceObserver": partial(arm_observers.NonlinearDisturbanceObserver, ARM, 1.0, [0.0, 0.0]),
        "OracleFilter": partial(arm_observers.OracleFilter, 2, 1.0),
        "PrintedFilter": partial(arm_observers.PrintedFilter, 2, 1.0),
        "SteadyKalmanFilter": partial(observers.SteadyKalmanFilter, PLANT, I[:, :2], 0.01, ("q",), 2),
        "UnscentedKalmanFilter": partial(observers.UnscentedKalmanFilter, *filtered, 1.0, 2.0, 0.5),
        "VelocityFilter": partial(arm_observers.VelocityFilter, 2, 100.0, [0.0, 0.0]),
        "WithDisturbance": partial(arm_observers.WithDisturbance, OBSERVER, oracle),
    }


def arguments() -> dict[str, Any]:
    return signals()
