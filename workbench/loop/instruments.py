"""The instruments between a plant and its computer: sensors with noise and quantisation, limits of the commands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Vector
from workbench.core.expressions import refuse_misfit
from workbench.loop.contracts import AbstractPlant
from workbench.loop.surroundings import AbstractInstruments
from workbench.validation.refusals import known, numbers, refusal

LEAST_QUANTUM = 1e-100  # of a smaller one a reading of 1e208 would have more than a double can count


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

    def __post_init__(self) -> None:
        if np.any((self.quantum > 0) & (self.quantum < LEAST_QUANTUM)):
            raise ValueError(
                f"`Sensor(quantum=...)` of '{self.output}' must be 0, for none, or at least {LEAST_QUANTUM:g}, as a "
                f"reading is a count of quanta, which a number must hold; got {self.quantum}."
            )


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
