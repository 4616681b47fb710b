"""What is controlled."""

from workbench.plants.actuator import AbstractActuator, DirectDrive, FirstOrderLag
from workbench.plants.arm_instruments import ArmInstruments
from workbench.plants.elements import (
    AbstractElement,
    Backlash,
    DeadZone,
    FirstOrder,
    Quantiser,
    RateLimit,
    Saturation,
    SecondOrder,
)
from workbench.plants.equipped import Equipped
from workbench.plants.manipulator import Friction, Manipulator
from workbench.plants.pade import PadeDelay

__all__ = [
    "AbstractActuator",
    "AbstractElement",
    "ArmInstruments",
    "Backlash",
    "DeadZone",
    "DirectDrive",
    "Equipped",
    "FirstOrder",
    "FirstOrderLag",
    "Friction",
    "Manipulator",
    "PadeDelay",
    "Quantiser",
    "RateLimit",
    "Saturation",
    "SecondOrder",
]
