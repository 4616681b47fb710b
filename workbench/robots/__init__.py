"""From the description of an arm to its dynamics.

description, kinematics, lagrange    planar chains, by their energies, as a book writes them
spatial, link, limits, frames        trees of hinges and slides in space: what an arm is, and its matrices
motion, inertia                      turns, shifts and masses as matrices
newton_euler, composite, poses       the recursions behind it: torque; M and C; places and energies
agreement                            Newton and Euler against Lagrange, whenever an arm is made
tree, urdf, safe_xml                 bodies and joints by name, and the files that hold them
regressor, base_parameters           tau = Y theta, and what of theta a motion can tell
catalogue, industrial                arms with a name, and where their numbers are from
"""

from workbench.robots import urdf
from workbench.robots.catalogue import CATALOGUE, named, paper_arm
from workbench.robots.description import Link, PlanarArm
from workbench.robots.limits import JointLimits, Limits
from workbench.robots.link import SpatialLink
from workbench.robots.spatial import SpatialArm

__all__ = [
    "CATALOGUE",
    "JointLimits",
    "Limits",
    "Link",
    "PlanarArm",
    "SpatialArm",
    "SpatialLink",
    "named",
    "paper_arm",
    "urdf",
]
