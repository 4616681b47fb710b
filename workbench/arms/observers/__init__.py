"""Observers for arms: of positions and velocities, and of the disturbance.

Each knows readings, commands and the arm that its designer believes in; it does not know the law, nor the command of
the same instant. Read `luenberger.py` first.
"""

from workbench.arms.observers.arm_full_state import ArmFullState, DirtyDerivative, VelocityFilter
from workbench.arms.observers.disturbance_observers import (
    AbstractDisturbanceObserver,
    MomentumObserver,
    NonlinearDisturbanceObserver,
    OracleFilter,
    PrintedFilter,
    StateAndDisturbanceObserver,
)
from workbench.arms.observers.extended_state_observer import ExtendedStateObserver
from workbench.arms.observers.luenberger import THEOREM_1, Luenberger

__all__ = [
    "AbstractDisturbanceObserver",
    "DirtyDerivative",
    "ExtendedStateObserver",
    "ArmFullState",
    "Luenberger",
    "MomentumObserver",
    "NonlinearDisturbanceObserver",
    "OracleFilter",
    "PrintedFilter",
    "THEOREM_1",
    "VelocityFilter",
    "StateAndDisturbanceObserver",
]
