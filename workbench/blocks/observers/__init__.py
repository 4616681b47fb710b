"""Observers for any plant: Kalman filters and linear observers.

An observer uses readings, commands and a model of the plant; it does not use the law, nor the command of the same
instant. Its estimates have the names of the plant's signals. `observer_model.py` has the base class of observers with
a model. Read `linear_observer.py` first.
"""

from workbench.blocks.observers.full_state import FullState
from workbench.blocks.observers.kalman_filter import ExtendedKalmanFilter, UnscentedKalmanFilter
from workbench.blocks.observers.linear_observer import LinearObserver, SteadyKalmanFilter
from workbench.blocks.observers.offset_free_observer import OffsetFreeObserver

__all__ = [
    "ExtendedKalmanFilter",
    "FullState",
    "UnscentedKalmanFilter",
    "LinearObserver",
    "OffsetFreeObserver",
    "SteadyKalmanFilter",
]
