"""What is controlled."""

from workbench.plants.actuator import AbstractActuator, DirectDrive, FirstOrderLag, Friction
from workbench.plants.arm_instruments import ArmInstruments
from workbench.plants.buck_converter import BuckConverter
from workbench.plants.cart_pole import CartPole
from workbench.plants.dc_motor import DCMotor
from workbench.plants.furuta_pendulum import FurutaPendulum
from workbench.plants.manipulator import Manipulator
from workbench.plants.ode_plant import OdePlant
from workbench.plants.planar_quadrotor import PlanarQuadrotor
from workbench.plants.quadrotor import Quadrotor
from workbench.plants.quadruple_tank import QuadrupleTank
from workbench.plants.stirred_tank import StirredTank
from workbench.plants.two_masses import TwoMasses
from workbench.plants.vehicle import SingleTrackVehicle

__all__ = [
    "AbstractActuator",
    "ArmInstruments",
    "BuckConverter",
    "CartPole",
    "DCMotor",
    "DirectDrive",
    "FirstOrderLag",
    "Friction",
    "FurutaPendulum",
    "Manipulator",
    "OdePlant",
    "PlanarQuadrotor",
    "Quadrotor",
    "QuadrupleTank",
    "SingleTrackVehicle",
    "StirredTank",
    "TwoMasses",
]
