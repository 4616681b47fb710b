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

    if TYPE_CHECKING:  # each block is a dataclass, so `dataclasses.replace` takes it
        __dataclass_fields__: ClassVar[dict[str, Field[object]]]

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
    """The sensors and limits between a plant and its computer."""

    @property
    def memory(self) -> Layout:
        """The states of coloured noise, which move from instant to instant."""
        return Layout()

    def noise_states(self, k: ca.SX, z: Parts, w: ca.SX, period: float) -> Parts:
        """The memory at the instant k, by standard normal numbers w, one for each of the memory."""
        del k, z, w, period
        return {}

    def add_coloured_noise(self, y: Signals, z: Parts) -> Signals:
        """The outputs with the coloured noise of the memory, as the sensors meet them."""
        del z
        return y

    @property
    @abstractmethod
    def reads(self) -> Layout:
        """The outputs of the plant that they touch."""

    @property
    @abstractmethod
    def limits(self) -> Layout:
        """The inputs of the plant that they limit."""

    @property
    @abstractmethod
    def noises(self) -> int:
        """The count of standard normal numbers that one reading takes, beside those of the memory."""

    @abstractmethod
    def read(self, y: Signals, w: ca.SX) -> Signals:
        """The readings of the computer where y is true, with w (noises, 1)."""

    @abstractmethod
    def limit_commands(self, u: Signals) -> Signals:
        """The limited commands, where the law commands `u`."""


class AbstractDisturbance(ABC):
    """Signals D(t) that act from outside (the D of the paper's equation (1), for torques)."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number of its components n."""

    @abstractmethod
    def at(self, t: Number) -> ca.SX:
        """D(t), (n, 1)."""


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
    def says(self) -> Layout:
        """No signals."""
        return Layout()

    def at(self, t: Number) -> Signals:
        """No signals."""
        del t
        return Signals()
