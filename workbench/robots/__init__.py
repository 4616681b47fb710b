"""From the description of an arm to its dynamics."""

from workbench.robots.catalogue import CATALOGUE, named, paper_arm
from workbench.robots.description import Link, PlanarArm

__all__ = ["CATALOGUE", "Link", "PlanarArm", "named", "paper_arm"]
