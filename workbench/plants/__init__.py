"""What is controlled."""

from workbench.plants.actuator import AbstractActuator, DirectDrive, FirstOrderLag
from workbench.plants.arm_instruments import ArmInstruments
from workbench.plants.manipulator import Friction, Manipulator
from workbench.plants.ode_plant import OdePlant

__all__ = ["AbstractActuator", "ArmInstruments", "DirectDrive", "FirstOrderLag", "Friction", "Manipulator", "OdePlant"]
