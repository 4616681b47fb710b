"""Riccati equations in time: backward, forward-propagating, and along states."""

from workbench.design.riccati_flow.equations import fpre, rde
from workbench.design.riccati_flow.result import RiccatiFlow

__all__ = ["RiccatiFlow", "fpre", "rde"]
