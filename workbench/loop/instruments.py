"""What stands between any plant and its computer: sensors with noise and steps, limits of the commands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Vector
from workbench.loop.contracts import AbstractPlant
from workbench.loop.surroundings import AbstractInstruments
from workbench.validation.words import known, numbers, refusal


@block
class Sensor:
    """One output as a computer reads it, with standard normal w, fresh at every reading:

        reading = quantised(x + noise w, quantum),      quantised(x, b) = floor(x / b + 1/2) b,   or x where b = 0.

    Parameters
    ----------
    output
        Its name.
    unit
        That of the output.
    noise
        (k,), standard deviations, one for each number of the output.
    quantum
        (k,), the steps in which a reading comes; 0 for a reading without steps.
    """

    output: str
    unit: str
    noise: Vector = parameter(unit="{unit}", low=0, shape=("k",), symbol="sigma")
    quantum: Vector = parameter(unit="{unit}", low=0, shape=("k",), symbol="b")


@block
class Limit:
    """One command within low and high.

    Parameters
    ----------
    input
        Its name.
    unit
        That of the input.
    low, high
        (k,), one for each number of the input.
    """

    input: str
    unit: str
    low: Vector = parameter(unit="{unit}", shape=("k",), symbol="u_min")
    high: Vector = parameter(unit="{unit}", shape=("k",), symbol="u_max")

    def __post_init__(self) -> None:
        if np.any(self.low >= self.high):
            raise ValueError(
                f"`Limit(low=..., high=...)` of '{self.input}' must leave room between them; got {self.low} and "
                f"{self.high}."
            )


@block
class Instruments(AbstractInstruments):
    """Sensors for outputs of a plant and limits for its inputs; what has none is read and commanded as it is."""

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
        noise, quantum, limit = noise or {}, quantum or {}, limit or {}
        sensors = []
        for name in dict.fromkeys((*noise, *quantum)):
            known(name, plant.outputs.names, "outputs of the plant")
            entry = plant.outputs[name]
            call = "Instruments.of(noise=..., quantum=...)"
            steps = (_each(call, entry, held.get(name, 0.0)) for held in (noise, quantum))
            sensors.append(Sensor(name, entry.unit, *steps))
        bounds = []
        for name, pair in limit.items():
            known(name, plant.inputs.names, "inputs of the plant")
            if not isinstance(pair, tuple | list) or len(pair) != 2:
                raise refusal("Instruments.of(limit=...)", f"a pair (low, high) for '{name}'", pair)
            entry = plant.inputs[name]
            bounds.append(Limit(name, entry.unit, *(_each("Instruments.of(limit=...)", entry, end) for end in pair)))
        return Instruments(tuple(sensors), tuple(bounds))

    @property
    def reads(self) -> Layout:
        """The outputs that have a sensor."""
        return Layout(tuple(Entry(s.output, np.zeros(s.noise.shape[0]), s.unit) for s in self.sensors))

    @property
    def limits(self) -> Layout:
        """The inputs that have a limit."""
        return Layout(tuple(Entry(b.input, np.zeros(b.low.shape[0]), b.unit) for b in self.bounds))

    @property
    def noises(self) -> int:
        """One for each number that is read."""
        return self.reads.size

    def read(self, y: Signals, w: ca.SX) -> Signals:
        """The readings."""
        draws = self.reads.view(w)
        return Signals({s.output: quantised(y[s.output] + s.noise * draws[s.output], s.quantum) for s in self.sensors})

    def limited(self, u: Signals) -> Signals:
        """The commands within their limits."""
        return Signals({b.input: ca.fmin(ca.fmax(u[b.input], b.low), b.high) for b in self.bounds})


def _each(call: str, entry: Entry, value: Any) -> Any:
    each = numbers(call, value)
    return np.full(entry.size, float(each)) if each.ndim == 0 else each


def quantised(x: ca.SX, quantum: ca.SX) -> ca.SX:
    """The multiple of the quantum that is nearest to x, the upper one of two; x itself where the quantum is 0."""
    some = quantum > 0
    b = ca.if_else(some, quantum, 1)  # nothing is ever divided by 0
    return ca.if_else(some, ca.floor(x / b + 0.5) * b, x)
