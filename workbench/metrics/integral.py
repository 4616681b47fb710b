"""Metrics that are integrals over time, carried along by the integrator of the loop itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import cast

import casadi as ca

from workbench.core import Layout, Ode
from workbench.metrics.contract import AbstractMetric, Parts, column
from workbench.validation.doors import answer
from workbench.validation.words import Array


@dataclass(frozen=True)
class Integral(AbstractMetric):
    """finish(integral of g(t, y) dt, horizon)."""

    g: Callable[[ca.SX, Parts], ca.SX]
    finish: Callable[[Array, float], Array]
    signals: tuple[str, ...] = ("e",)

    @property
    def watches(self) -> tuple[str, ...]:
        """What g looks at."""
        return self.signals

    @property
    def grid(self) -> float | None:
        """None: the integrator sees to it."""
        return None

    def check(self, ode: Ode, horizon: float) -> None:
        """An integral is one of any equation."""
        del ode, horizon

    def integrand(self, t: ca.SX, y: Parts) -> ca.SX | None:
        """g."""
        must = f"be a function of (t, y) that gives an expression (k, 1), for the metric '{self.name}'"
        return cast(ca.SX, answer("Integral(g=...)", must, lambda: self.g(t, y), column))

    def memory(self, joints: int) -> Layout:
        """None."""
        del joints
        return Layout()

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """Nothing to remember."""
        del k, h, z, y
        return {}

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """What `finish` makes of the integral."""
        del z
        return self.finish(integral, horizon)
