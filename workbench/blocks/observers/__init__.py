"""Observers: from measurements to estimates of the state and of the disturbance.

An observer knows readings, commands and a model of the plant; it does not know the law, nor the command of the same
instant. Read `luenberger.py` first for an arm, `linear_observer.py` for any plant.
"""

from workbench.arms.observers.disturbance_observers import (
    AbstractDisturbanceObserver,
    MomentumObserver,
    NonlinearDisturbanceObserver,
    OracleFilter,
    PrintedFilter,
    WithDisturbance,
)
from workbench.arms.observers.extended_state_observer import ExtendedStateObserver
from workbench.arms.observers.full_state import DirtyDerivative, FullState, VelocityFilter
from workbench.arms.observers.luenberger import Luenberger
from workbench.blocks.observers.kalman_filter import ExtendedKalmanFilter, UnscentedKalmanFilter
from workbench.blocks.observers.linear_observer import LinearObserver, SteadyKalmanFilter

__all__ = [
    "AbstractDisturbanceObserver",
    "DirtyDerivative",
    "ExtendedKalmanFilter",
    "ExtendedStateObserver",
    "FullState",
    "LinearObserver",
    "Luenberger",
    "MomentumObserver",
    "NonlinearDisturbanceObserver",
    "OracleFilter",
    "PrintedFilter",
    "SteadyKalmanFilter",
    "UnscentedKalmanFilter",
    "VelocityFilter",
    "WithDisturbance",
]
