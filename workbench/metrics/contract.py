"""What a metric must say of itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca

from workbench.core import Layout, Ode
from workbench.core.layout import Array

# Outputs of a loop, or the memory of a metric, by name.
Parts = Mapping[str, ca.SX]


@dataclass(frozen=True)
class AbstractMetric(ABC):
    """A number per run and joint with its name and unit; without a unit it has that of the first output it watches."""

    name: str
    unit: str
    about: str

    @property
    @abstractmethod
    def watches(self) -> tuple[str, ...]:
        """The outputs that the metric looks at; the size of the first is that of the metric."""

    @property
    @abstractmethod
    def grid(self) -> float | None:
        """The sample time [s] of a grid of its own, which every step must divide; None without one."""

    @abstractmethod
    def check(self, ode: Ode, horizon: float) -> None:
        """Refuse an equation or a horizon [s] for which the metric means nothing."""

    @abstractmethod
    def integrand(self, t: ca.SX, y: Parts) -> ca.SX | None:
        """What is integrated over time, (k, 1), or None."""

    @abstractmethod
    def memory(self, joints: int) -> Layout:
        """What is updated at each step."""

    @abstractmethod
    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The memory after looking at the outputs y at time k h; with a grid of its own, h divides it."""

    @abstractmethod
    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The metric (B, k) from the integral (B, k) and the memory at the horizon."""
