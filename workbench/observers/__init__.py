"""Observers: from measurements to estimates of the state and of the disturbance."""

from workbench.observers.disturbance import AbstractDisturbanceObserver, WithDisturbance
from workbench.observers.disturbance_filters import OracleFilter, PrintedFilter
from workbench.observers.disturbance_observers import MomentumObserver, NonlinearDisturbanceObserver
from workbench.observers.full_state import FullState
from workbench.observers.luenberger import Luenberger
from workbench.observers.velocity_filters import DirtyDerivative, VelocityFilter

__all__ = [
    "AbstractDisturbanceObserver",
    "DirtyDerivative",
    "FullState",
    "Luenberger",
    "MomentumObserver",
    "NonlinearDisturbanceObserver",
    "OracleFilter",
    "PrintedFilter",
    "VelocityFilter",
    "WithDisturbance",
]
