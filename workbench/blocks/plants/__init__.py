"""Plants, each with the source of its numbers, and actuators, sensors and disturbances for any plant.

This package has no law, no observer and no simulation. Read `dc_motor.py` first; `ode_plant.py` makes a plant from
functions.

Examples
--------
>>> wb.plants.DCMotor is wb.DCMotor
True
"""

from workbench.blocks.loop.linear_blocks import LinearPlant
from workbench.blocks.plants.buck_converter import BuckConverter
from workbench.blocks.plants.dc_motor import DCMotor
from workbench.blocks.plants.disturbed_plant import DisturbedPlant
from workbench.blocks.plants.elements import AbstractElement, FirstOrder, Memory, PadeDelay, RateLimit, Saturation
from workbench.blocks.plants.equipped_plant import EquippedPlant
from workbench.blocks.plants.input_disturbances import InputDisturbances
from workbench.blocks.plants.mechanisms import CartPole, FurutaPendulum, TwoMasses
from workbench.blocks.plants.nonlinear_elements import Backlash, DeadZone, Quantiser
from workbench.blocks.plants.ode_plant import OdePlant
from workbench.blocks.plants.tanks import QuadrupleTank, StirredTank
from workbench.blocks.plants.vehicles import PlanarQuadrotor, Quadrotor, SingleTrackVehicle

__all__ = [
    "AbstractElement",
    "Backlash",
    "BuckConverter",
    "CartPole",
    "DCMotor",
    "DeadZone",
    "DisturbedPlant",
    "EquippedPlant",
    "FirstOrder",
    "FurutaPendulum",
    "InputDisturbances",
    "LinearPlant",
    "Memory",
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
