"""The surroundings of plant, observer and law: wanted signals, instruments and disturbances, and their defaults."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import Field
from typing import TYPE_CHECKING, ClassVar

import casadi as ca

from workbench.blocks.loop.contracts import AbstractObserver, Parts, Reads
from workbench.core import Layout, Signals, block
from workbench.core.block import Number


class AbstractReference(ABC):
    """The base class of references: signals that a loop should follow, as expressions in time.

    Examples
    --------
    >>> @wb.block
    ... class Parabola(wb.Reference):
    ...     a: float = wb.parameter(default=0.5, unit="m/s^2")
    ...     gives = wb.layout(x="m")
    ...     def at(self, t):
    ...         return {"x": self.a * t**2 / 2}
    >>> Parabola().at(2.0)
    {'x': 1.0}
    """

    if TYPE_CHECKING:  # each block is a dataclass, so `dataclasses.replace` takes it
        __dataclass_fields__: ClassVar[dict[str, Field[object]]]

    @property
    @abstractmethod
    def gives(self) -> Layout:
        """The signals of the reference, with their units."""

    @property
    def primary(self) -> tuple[str, ...]:
        """The names of the signals that are not derivatives of other ones; by default all signals."""
        return self.gives.names

    @property
    def ends(self) -> float:
        """The last time in s for which the reference has values; infinity by default."""
        return math.inf

    @abstractmethod
    def at(self, t: Number) -> Signals:
        """The signals by name at time t [s]."""


class AbstractInstruments(ABC):
    """The base class of the instruments between a plant and its computer: sensors and limits of commands."""

    @property
    def memory(self) -> Layout:
        """The states of coloured noise, which change from instant to instant of the computer."""
        return Layout()

    def noise_states(self, k: ca.SX, z: Parts, w: ca.SX, period: float) -> Parts:
        """The memory at the instant k, from the memory z one `period` [s] before.

        w has one standard normal random number for each number of the memory.
        """
        del k, z, w, period
        return {}

    def add_coloured_noise(self, y: Signals, z: Parts) -> Signals:
        """The outputs y with the coloured noise of the memory z added, before the sensors."""
        del z
        return y

    @property
    @abstractmethod
    def reads(self) -> Layout:
        """The outputs of the plant that the instruments measure."""

    @property
    @abstractmethod
    def limits(self) -> Layout:
        """The inputs of the plant that the instruments limit."""

    @property
    @abstractmethod
    def noises(self) -> int:
        """The number of standard normal random numbers for one reading, without those of the memory."""

    @abstractmethod
    def read(self, y: Signals, w: ca.SX) -> Signals:
        """The readings of the computer for the outputs y, with standard normal random numbers w (noises, 1)."""

    @abstractmethod
    def limit_commands(self, u: Signals) -> Signals:
        """The limited commands for the commands u of the law."""


class AbstractDisturbance(ABC):
    """Signals D(t) that act on a plant from outside, such as disturbance torques."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number n of components of the disturbance."""

    @abstractmethod
    def at(self, t: Number) -> ca.SX:
        """The disturbance D(t) at time t [s], (n, 1)."""


@block
class Readings(AbstractObserver):
    """An observer that returns the readings of the instruments, `outputs` of the plant, unchanged."""

    noun = ""  # no observer at all

    outputs: Layout

    @property
    def reads(self) -> Layout:
        """The outputs."""
        return self.outputs

    @property
    def gives(self) -> Layout:
        """The outputs."""
        return self.outputs

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        """The readings."""
        del t, z
        return y


@block
class NoReference(AbstractReference):
    """A reference without signals, for a law that keeps the plant at rest."""

    noun = ""  # no reference at all

    @property
    def gives(self) -> Layout:
        """No signals."""
        return Layout()

    def at(self, t: Number) -> Signals:
        """No signals."""
        del t
        return Signals()
