"""What is controlled."""

from workbench.plants.actuator import AbstractActuator, DirectDrive, FirstOrderLag
from workbench.plants.manipulator import Friction, Manipulator

__all__ = ["AbstractActuator", "DirectDrive", "FirstOrderLag", "Friction", "Manipulator"]
