"""Plants: the arm and ten others, each with the source of its numbers, and their actuators and sensors.

The room knows a plant's equations, its actuators, sensors and disturbances; it knows no law, no observer and no
simulation. Read `dc_motor.py` first; `manipulator.py` is the arm, `ode_plant.py` makes a plant of functions.
"""

from workbench.loop.linear_blocks import LinearPlant
from workbench.plants.buck_converter import BuckConverter
from workbench.plants.dc_motor import DCMotor
from workbench.plants.disturbed import Disturbed
from workbench.plants.elements import AbstractElement, FirstOrder, PadeDelay, RateLimit, Saturation
from workbench.plants.equipped import Equipped
from workbench.plants.manipulator import AbstractActuator, DirectDrive, FirstOrderLag, Friction, Manipulator
from workbench.plants.mechanisms import CartPole, FurutaPendulum, TwoMasses
from workbench.plants.nonlinear_elements import Backlash, DeadZone, Quantiser
from workbench.plants.ode_plant import OdePlant
from workbench.plants.tanks import QuadrupleTank, StirredTank
from workbench.plants.vehicles import PlanarQuadrotor, Quadrotor, SingleTrackVehicle

__all__ = [
    "AbstractActuator",
    "AbstractElement",
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
    "SingleTrackVehicle",
    "StirredTank",
    "TwoMasses",
]
