"""What is controlled."""

from workbench.loop.linear import LinearPlant
from workbench.plants.actuator import AbstractActuator, DirectDrive, FirstOrderLag, Friction
from workbench.plants.arm_instruments import ArmInstruments
from workbench.plants.buck_converter import BuckConverter
from workbench.plants.cart_pole import CartPole
from workbench.plants.dc_motor import DCMotor
from workbench.plants.disturbed import Disturbed
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
from workbench.plants.furuta_pendulum import FurutaPendulum
from workbench.plants.manipulator import Manipulator
from workbench.plants.ode_plant import OdePlant
from workbench.plants.pade import PadeDelay
from workbench.plants.planar_quadrotor import PlanarQuadrotor
from workbench.plants.quadrotor import Quadrotor
from workbench.plants.quadruple_tank import QuadrupleTank
from workbench.plants.stirred_tank import StirredTank
from workbench.plants.two_masses import TwoMasses
from workbench.plants.vehicle import SingleTrackVehicle

__all__ = [
    "AbstractActuator",
    "AbstractElement",
    "ArmInstruments",
    "Backlash",
    "BuckConverter",
    "CartPole",
    "DCMotor",
    "DeadZone",
    "DirectDrive",
    "Disturbed",
    "Equipped",
    "FirstOrder",
    "FirstOrderLag",
    "Friction",
    "FurutaPendulum",
    "LinearPlant",
    "Manipulator",
    "OdePlant",
    "PadeDelay",
    "PlanarQuadrotor",
    "Quadrotor",
    "QuadrupleTank",
    "Quantiser",
    "RateLimit",
    "Saturation",
    "SecondOrder",
    "SingleTrackVehicle",
    "StirredTank",
    "TwoMasses",
]
