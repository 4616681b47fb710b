"""What stands around plant, observer and law: wanted signals, disturbances, and the instruments of a computer."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import casadi as ca

from workbench.core import Layout, Signals
from workbench.validation.shapes import Number


class AbstractReference(ABC):
    """Wanted signals as expressions in time.

    Examples
    --------
    >>> @wb.block
    ... class Parabola(wb.Reference):
    ...     a: float = wb.parameter(default=0.5, unit="m/s^2")
    ...     says = wb.layout(x="m")
    ...     def at(self, t):
    ...         return {"x": self.a * t**2 / 2}
    >>> Parabola().at(2.0)
    {'x': 1.0}
    """

    @property
    @abstractmethod
    def says(self) -> Layout:
        """The signals that it gives."""

    @property
    def primary(self) -> tuple[str, ...]:
        """The signals that are wanted for themselves; others are their derivatives."""
        return self.says.names

    @property
    def ends(self) -> float:
        """The last time for which it has values, in s."""
        return math.inf

    @abstractmethod
    def at(self, t: Number) -> Signals:
        """The signals at time t [s]."""


class AbstractInstruments(ABC):
    """What stands between a plant and its computer."""

    @property
    @abstractmethod
    def reads(self) -> Layout:
        """The outputs of the plant that they touch."""

    @property
    @abstractmethod
    def limits(self) -> Layout:
        """The inputs of the plant that they limit."""

    @property
    def drifts(self) -> Layout:
        """The outputs whose readings drift, each with its drift at the start."""
        return Layout()

    @property
    @abstractmethod
    def noises(self) -> int:
        """How many standard normal numbers one reading takes."""

    def drifted(self, z: Signals, w: ca.SX, period: float) -> Signals:
        """The drifts at an instant, a period in s after they were z, with w (noises, 1)."""
        del w, period
        return z

    @abstractmethod
    def read(self, y: Signals, w: ca.SX) -> Signals:
        """What the computer reads where y is true, its drift added, with w (noises, 1)."""

    @abstractmethod
    def limited(self, u: Signals) -> Signals:
        """What is asked for where the law commands `u`."""


class AbstractDisturbance(ABC):
    """Signals D(t) that act from outside (the D of the paper's equation (1), for torques)."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number of its components n."""

    @abstractmethod
    def at(self, t: Number) -> ca.SX:
        """D(t), (n, 1)."""
