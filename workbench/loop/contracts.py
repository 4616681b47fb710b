"""What each block of a loop must be able to say. Every class below is abstract; every law is final.

A block's own states are its `memory` (a `Layout`); its `rate` returns a part for each of them. In a computer it
moves them over a period by its `advance`, an explicit Euler step unless the block has a method of its own.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from copy import copy
from typing import Self

import casadi as ca

from workbench.core import Layout
from workbench.loop.ports import Estimate, Measurement, Motion, Parts
from workbench.validation.doors import door
from workbench.validation.shapes import Column, Number
from workbench.validation.words import seconds

EULER = "explicit Euler"


class AbstractReference(ABC):
    """A wanted motion as an expression in time."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number of joints n."""

    @abstractmethod
    def at(self, t: Number) -> Motion:
        """The wanted motion at time t [s]."""


class AbstractDisturbance(ABC):
    """A torque D(t) that acts on the joints from outside, with known bounds (Assumption 4 of the paper)."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number of joints n."""

    @abstractmethod
    def at(self, t: Number) -> ca.SX:
        """D(t), (n, 1), in N m."""

    @property
    @abstractmethod
    def D_max(self) -> float:
        """A bound on the Euclidean norm of D(t) over all time, in N m."""

    @property
    @abstractmethod
    def L_D(self) -> float:
        """A bound on the Euclidean norm of D'(t) over all time, in N m/s."""


class AbstractPlant(ABC):
    """What is controlled: driven by a torque command, watched by instruments."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number of joints n."""

    @property
    @abstractmethod
    def memory(self) -> Layout:
        """The states; 'q' and 'qd' are among them."""

    @abstractmethod
    def measure(self, t: Number, z: Parts) -> Measurement:
        """What the instruments say at a state."""

    @abstractmethod
    def applied(self, z: Parts, tau: Column) -> ca.SX:
        """The torque that acts on the joints when `tau` is commanded, (n, 1), in N m."""

    @abstractmethod
    def rate(self, t: Number, z: Parts, tau: Column) -> Parts:
        """The derivative of each state."""


class AbstractObserver(ABC):
    """From measurements to estimates. An estimate never sees the torque of the same instant."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number of joints n."""

    @property
    @abstractmethod
    def uses_truth(self) -> bool:
        """Whether it needs what no instrument can give it."""

    @property
    @abstractmethod
    def memory(self) -> Layout:
        """The observer's own states."""

    @abstractmethod
    def estimate(self, t: Number, z: Parts, y: Measurement) -> Estimate:
        """What the observer believes."""

    @abstractmethod
    def rate(self, t: Number, z: Parts, y: Measurement, est: Estimate, tau: Column) -> Parts:
        """The derivative of each state, when the torque `tau` is commanded."""

    @property
    def method(self) -> str:
        """The name of the method by which `advance` steps the memory, as a page has it."""
        return EULER

    @door
    def advance(self, t: Number, z: Parts, y: Measurement, est: Estimate, tau: Column, period: float) -> Parts:
        """The memory at the end of a period in s, over which a computer holds the readings and the torque `tau`."""
        return euler(z, self.rate(t, z, y, est, tau), period)

    def without(self) -> Mapping[str, AbstractObserver]:
        """The observer less each of its parts, by the name of the part; none where it has no parts."""
        return {}


class AbstractController(ABC):
    """From estimates and the wanted motion to a torque command.

    Attributes
    ----------
    period
        How often a computer runs the law, in s; None where it runs in continuous time.
    """

    period: float | None = None

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number of joints n."""

    @property
    @abstractmethod
    def memory(self) -> Layout:
        """The controller's own states."""

    @abstractmethod
    def torque(self, t: Number, z: Parts, est: Estimate, ref: Motion) -> ca.SX:
        """The torque command, (n, 1), in N m."""

    @abstractmethod
    def rate(self, t: Number, z: Parts, est: Estimate, ref: Motion) -> Parts:
        """The derivative of each state."""

    @abstractmethod
    def signals(self, z: Parts, est: Estimate, ref: Motion) -> Parts:
        """What is worth watching besides the memory: the sliding variable s, say."""

    @property
    def method(self) -> str:
        """The name of the method by which `advance` steps the memory, as a page has it."""
        return EULER

    @door
    def advance(self, t: Number, z: Parts, est: Estimate, ref: Motion, period: float) -> Parts:
        """The memory at the end of a period in s, over which a computer holds the estimate and the reference."""
        return euler(z, self.rate(t, z, est, ref), period)

    def without(self) -> Mapping[str, AbstractController]:
        """The law less each of its parts, by the name of the part; none where it has no parts."""
        return {}

    @door
    def run_every(self, period: float) -> Self:
        """The same law, run by a computer once in `period` seconds."""
        law = copy(self)
        object.__setattr__(law, "period", seconds("run_every(period=...)", period))
        return law


def euler(z: Parts, rates: Parts, period: float) -> dict[str, ca.SX]:
    """z + period z', the explicit Euler step of each part of a memory."""
    return {name: z[name] + period * rate for name, rate in rates.items()}
