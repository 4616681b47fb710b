"""From the description of an arm to its dynamics M, C and G.

This package has planar chains, trees of hinges and slides in space, URDF files, a catalogue of arms, and the inertial
parameters in which the torque is linear. It has no loop, no law and no disturbance. Read `planar_arm.py` first, where
energies become matrices, then `spatial.py`.
"""

from workbench.arms.mechanics import lagrange, urdf
from workbench.arms.mechanics.arm_catalogue import CATALOGUE, paper_arm, planar, robot
from workbench.arms.mechanics.inertial_regressor import Regressor, regressor
from workbench.arms.mechanics.parameter_reduction import BaseParameters, base_parameters
from workbench.arms.mechanics.planar_arm import DIRECTIONS, Link, PlanarArm, PointMass
from workbench.arms.mechanics.spatial import SpatialArm, SpatialLink

__all__ = [
    "BaseParameters",
    "CATALOGUE",
    "DIRECTIONS",
    "Link",
    "PlanarArm",
    "PointMass",
    "Regressor",
    "SpatialArm",
    "SpatialLink",
    "base_parameters",
    "lagrange",
    "robot",
    "paper_arm",
    "planar",
    "regressor",
    "urdf",
]
