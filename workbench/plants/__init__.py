"""What is controlled."""

from workbench.loop.linear import LinearPlant
from workbench.plants.actuator import AbstractActuator, DirectDrive, FirstOrderLag
from workbench.plants.arm_instruments import ArmInstruments
from workbench.plants.manipulator import Friction, Manipulator

__all__ = [
    "AbstractActuator",
    "ArmInstruments",
    "DirectDrive",
    "FirstOrderLag",
    "Friction",
    "LinearPlant",
    "Manipulator",
]
