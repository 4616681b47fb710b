"""The doors of `workbench.validation`, by the name that rooms above know."""

from workbench.validation.doors import door, fitted

__all__ = ["door", "fitted"]
