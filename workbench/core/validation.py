"""The words of `workbench.validation`, by the name that rooms above know."""

from workbench.validation.words import *  # noqa: F403
