"""Sockets: the names by which rooms knew `validation` and `doors` before."""

from workbench.validation.doors import fitted
from workbench.validation.words import described, require

__all__ = ["described", "fitted", "require"]
