"""Sockets: the names by which rooms knew `validation` and `doors` before."""

from workbench.core.doors import fitted
from workbench.core.validation import described, require

__all__ = ["described", "fitted", "require"]
