"""Design by linear models: the only room that opens python-control."""

from workbench.design.linear import linearize, to_control

__all__ = ["linearize", "to_control"]
