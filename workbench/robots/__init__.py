"""From the description of an arm to its dynamics M, C and G.

The room knows planar chains, trees of hinges and slides in space, URDF files and a catalogue of arms; it knows no
loop, no law and no disturbance. Read `planar_arm.py` first, where a book's energies become matrices, then `spatial.py`.
"""

from workbench.robots import urdf
from workbench.robots.arm_catalogue import CATALOGUE, named, paper_arm
from workbench.robots.planar_arm import Link, PlanarArm
from workbench.robots.spatial import SpatialArm, SpatialLink

__all__ = ["CATALOGUE", "Link", "PlanarArm", "SpatialArm", "SpatialLink", "named", "paper_arm", "urdf"]
