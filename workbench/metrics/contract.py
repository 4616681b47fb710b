"""What a metric must say of itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca

from workbench.core import Layout
from workbench.core.layout import Array

# Outputs of a loop, or the memory of a metric, by name.
Parts = Mapping[str, ca.SX]


@dataclass(frozen=True)
class AbstractMetric(ABC):
    """A number per run and joint with its name and unit."""

    name: str
    unit: str
    about: str

    @abstractmethod
    def integrand(self, t: ca.SX, y: Parts) -> ca.SX | None:
        """What is integrated over time, (k, 1), or None."""

    @abstractmethod
    def memory(self, joints: int) -> Layout:
        """What is updated at each step."""

    @abstractmethod
    def update(self, k: ca.SX, h: float, z: Parts, y: Parts) -> Parts:
        """The memory after looking at the outputs y at time k h."""

    @abstractmethod
    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The metric (B, k) from the integral (B, k) and the memory at the horizon."""
