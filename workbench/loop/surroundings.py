"""The surroundings of plant, observer and law: wanted signals, disturbances, instruments, and their defaults."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Number, Vector
from workbench.core.expressions import refuse_misfit
from workbench.loop.contracts import AbstractObserver, AbstractPlant, Parts, Reads
from workbench.validation.refusals import known, numbers, refusal


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
    """The sensors and limits between a plant and its computer."""

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
        """The count of standard normal numbers that one reading takes."""

    @abstractmethod
    def read(self, y: Signals, w: ca.SX) -> Signals:
        """The readings of the computer where y is true, with w (noises, 1)."""

    @abstractmethod
    def limited(self, u: Signals) -> Signals:
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
class Rest(AbstractReference):
    """A reference without signals, for a law that keeps the plant at rest."""

    @property
    def says(self) -> Layout:
        """No signals."""
        return Layout()

    def at(self, t: Number) -> Signals:
        """No signals."""
        del t
        return Signals()


@block
class Sensor:
    """One output as a computer reads it, with standard normal w, fresh at every reading:

        reading = quantised(x + noise w, quantum),

    where quantised(x, q) = floor(x / q + 1/2) q, or x where q = 0. The standard deviation `noise` and the steps
    `quantum` are one number or (k,), one for each number of the output.
    """

    output: str
    unit: str
    noise: Vector = parameter(unit="{unit}", low=0, shape=("*",), symbol="sigma")
    quantum: Vector = parameter(unit="{unit}", low=0, shape=("*",), symbol="q")


@block
class Limit:
    """One command within low and high, each one number or (k,), one for each number of the input."""

    input: str
    unit: str
    low: Vector = parameter(unit="{unit}", shape=("*",), symbol="u_min")
    high: Vector = parameter(unit="{unit}", shape=("*",), symbol="u_max")

    def __post_init__(self) -> None:
        if np.any(self.low >= self.high):
            raise ValueError(
                f"`Limit(low=..., high=...)` of '{self.input}' must leave room between them; got {self.low} and "
                f"{self.high}."
            )


@block
class Instruments(AbstractInstruments):
    """Sensors for outputs of a plant and limits for its inputs; other signals pass unchanged.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> instruments = wb.Instruments.of(motor, noise={"omega": 0.01}, limit={"v": (-12.0, 12.0)})
    >>> instruments.reads.names, instruments.limits.names
    (('omega',), ('v',))
    """

    sensors: tuple[Sensor, ...] = ()
    bounds: tuple[Limit, ...] = ()

    @staticmethod
    def of(
        plant: AbstractPlant,
        noise: Mapping[str, Any] | None = None,
        quantum: Mapping[str, Any] | None = None,
        limit: Mapping[str, Any] | None = None,
    ) -> Instruments:
        """Instruments of a plant, by the names of its outputs and inputs.

        Parameters
        ----------
        noise, quantum
            A number for each output that is named, or one for each of its numbers.
        limit
            The lowest and the highest command for each input that is named, (low, high).

        Raises
        ------
        LookupError
            If a name is no output or no input of the plant.
        ValueError
            If a number is negative or not finite, or a limit is no pair with room between.
        """
        given, sensors, bounds = {"noise": noise or {}, "quantum": quantum or {}}, [], []
        for name in dict.fromkeys(name for named in given.values() for name in named):
            entry = plant.outputs[known(name, plant.outputs.names, "outputs of the plant")]
            own = {key: _each(key, entry, named.get(name, 0.0)) for key, named in given.items()}
            sensors.append(Sensor(name, entry.unit, **own))
        for name, pair in (limit or {}).items():
            entry = plant.inputs[known(name, plant.inputs.names, "inputs of the plant")]
            if not isinstance(pair, tuple | list) or len(pair) != 2:
                raise refusal("Instruments.of(limit=...)", f"a pair (low, high) for '{name}'", pair)
            bounds.append(Limit(name, entry.unit, *(_each("limit", entry, end) for end in pair)))
        return Instruments(tuple(sensors), tuple(bounds))

    @property
    def reads(self) -> Layout:
        """The outputs that have a sensor."""
        return Layout(tuple(_port(sensor.output, sensor.unit, sensor.noise) for sensor in self.sensors))

    @property
    def limits(self) -> Layout:
        """The inputs that have a limit."""
        return Layout(tuple(_port(bound.input, bound.unit, bound.low) for bound in self.bounds))

    @property
    def noises(self) -> int:
        """The count of noises of a reading: one for each number that is read."""
        return self.reads.size

    def read(self, y: Signals, w: ca.SX) -> Signals:
        """The readings."""
        refuse_misfit("Instruments.read", "w", w, self.noises, 1, "a normal number for each")
        draws, readings = self.reads.view(w), {}
        for sensor in self.sensors:
            x = y[sensor.output] + sensor.noise * draws[sensor.output]
            readings[sensor.output] = quantised(x, sensor.quantum + 0 * x)
        return Signals(readings)

    def limited(self, u: Signals) -> Signals:
        """The commands within their limits."""
        return Signals({b.input: ca.fmin(ca.fmax(u[b.input], b.low), b.high) for b in self.bounds})


def _port(name: str, unit: str, each: Vector) -> Entry:
    size = ca.SX(each).numel()
    return Entry(name, np.zeros(() if size == 1 else size), unit)


def _each(key: str, entry: Entry, value: Any) -> Any:
    call = f"Instruments.of({key}=...)"
    each = numbers(call, value)
    if each.shape not in ((), entry.shape):
        several = f"{entry.size} numbers or one for all of" if entry.shape else "one number for"
        raise ValueError(f"`{call}` must have {several} '{entry.name}'; got shape {each.shape}.")
    return np.broadcast_to(each, entry.shape)


def quantised(x: ca.SX, quantum: ca.SX) -> ca.SX:
    """The multiple of the quantum that is nearest to x, the upper one of two; x itself where the quantum is 0."""
    some = quantum > 0
    b = ca.if_else(some, quantum, 1)  # nothing is ever divided by 0
    return ca.if_else(some, ca.floor(x / b + 0.5) * b, x)
