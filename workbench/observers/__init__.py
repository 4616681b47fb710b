"""Observers: from measurements to estimates of the state and of the disturbance.

An observer knows readings, commands and a model of the plant; it does not know the law, nor the command of the same
instant. Read `luenberger.py` first for an arm, `linear_observer.py` for any plant.
"""

from workbench.observers.disturbance_observers import (
    AbstractDisturbanceObserver,
    MomentumObserver,
    NonlinearDisturbanceObserver,
    OracleFilter,
    PrintedFilter,
    WithDisturbance,
)
from workbench.observers.extended_state_observer import ExtendedStateObserver
from workbench.observers.full_state import DirtyDerivative, FullState, VelocityFilter
from workbench.observers.kalman_filter import ExtendedKalmanFilter, UnscentedKalmanFilter
from workbench.observers.linear_observer import LinearObserver, SteadyKalmanFilter
from workbench.observers.luenberger import Luenberger

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
