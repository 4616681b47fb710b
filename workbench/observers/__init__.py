"""Observers: from measurements to estimates of the state and of the disturbance."""

from workbench.observers.disturbance import AbstractDisturbanceObserver, WithDisturbance
from workbench.observers.disturbance_filters import OracleFilter, PrintedFilter
from workbench.observers.disturbance_observers import MomentumObserver, NonlinearDisturbanceObserver
from workbench.observers.extended_kalman_filter import ExtendedKalmanFilter
from workbench.observers.extended_state_observer import ExtendedStateObserver
from workbench.observers.full_state import FullState
from workbench.observers.linear_observer import LinearObserver
from workbench.observers.luenberger import Luenberger
from workbench.observers.steady_kalman_filter import SteadyKalmanFilter
from workbench.observers.unscented_kalman_filter import UnscentedKalmanFilter
from workbench.observers.velocity_filters import DirtyDerivative, VelocityFilter

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
