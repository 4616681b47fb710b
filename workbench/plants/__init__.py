"""What is controlled."""

from workbench.plants.actuator import AbstractActuator, DirectDrive, FirstOrderLag
from workbench.plants.arm_instruments import ArmInstruments
from workbench.plants.disturbed import Disturbed
from workbench.plants.manipulator import Friction, Manipulator

__all__ = ["AbstractActuator", "ArmInstruments", "DirectDrive", "Disturbed", "FirstOrderLag", "Friction", "Manipulator"]
