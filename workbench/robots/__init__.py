"""From the description of an arm to its dynamics."""

from workbench.robots import urdf
from workbench.robots.catalogue import CATALOGUE, named, paper_arm
from workbench.robots.description import Link, PlanarArm
from workbench.robots.spatial import SpatialArm, SpatialLink

__all__ = ["CATALOGUE", "Link", "PlanarArm", "SpatialArm", "SpatialLink", "named", "paper_arm", "urdf"]
