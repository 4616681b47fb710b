"""The instruments between a plant and its computer: sensors with noise and steps, limits, converters."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from workbench.blocks.loop.coloured_noise import AbstractNoise
from workbench.blocks.loop.contracts import AbstractPlant, Parts
from workbench.blocks.loop.environment import AbstractInstruments
from workbench.blocks.loop.noise_states import NoiseStates, noise_of
from workbench.blocks.loop.quantisation import Converter, quantise, refuse_quantum
from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Vector
from workbench.core.expressions import refuse_misfit
from workbench.core.validation.refusals import Array, known_name, numbers, refusal


@block
class Sensor:
    """A sensor of one output x, with white noise and quantisation:

        reading = quantised(x + noise w, quantum),     quantised(x, q) = floor(x / q + 1/2) q, or x for q = 0.

    w is a standard normal random number, a new one at every reading.

    Parameters
    ----------
    output
        Name of the output.
    unit
        Unit of the output.
    noise
        Standard deviation of the noise: one number, or one for each component of the output.
    quantum
        Quantisation step: one number, or one for each component of the output.
    """

    output: str
    unit: str
    noise: Vector = parameter(unit="{unit}", low=0, shape=("*",), symbol="sigma")
    quantum: Vector = parameter(unit="{unit}", low=0, shape=("*",), symbol="q")

    def __post_init__(self) -> None:
        refuse_quantum("Sensor(quantum=...)", self.output, self.quantum)


@block
class Limit:
    """The limits of one command.

    Parameters
    ----------
    input
        Name of the input of the plant.
    unit
        Unit of the input.
    low, high
        The lowest and the highest command: one number, or one for each component of the input.
    """

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
    """The instruments between a plant and its computer: sensors, limits of commands, and converters.

    `Instruments.of` makes them for a plant, by the names of its signals. The coloured noise of an output is added
    first; its sensor then adds white noise and quantisation; its analogue-to-digital converter comes last. A command
    passes its limit, and then its digital-to-analogue converter. A signal without instruments passes unchanged. Limits
    and converters of commands are part of the law that `SampledSystem.law` returns; sensors are not.

    Parameters
    ----------
    sensors
        Sensors of outputs.
    bounds
        Limits of commands.
    adcs
        Analogue-to-digital converters of outputs.
    dacs
        Digital-to-analogue converters of commands.
    coloured_noises
        Noises of outputs that have a memory, such as `RandomWalk`.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> instruments = wb.Instruments.of(motor, noise={"omega": 0.01}, limit={"v": (-12.0, 12.0)})
    >>> instruments.reads.names, instruments.limits.names
    (('omega',), ('v',))
    >>> wb.Instruments.of(motor, dac={"v": (8, -12.8, 12.8)}).dacs[0].quantum
    0.1
    """

    noun = ""  # a reader cares for its sensors, limits and noises

    sensors: tuple[Sensor, ...] = ()
    bounds: tuple[Limit, ...] = ()
    adcs: tuple[Converter, ...] = ()
    dacs: tuple[Converter, ...] = ()
    coloured_noises: tuple[AbstractNoise, ...] = ()

    @staticmethod
    def of(
        plant: AbstractPlant,
        noise: Mapping[str, Vector] | None = None,
        quantum: Mapping[str, Vector] | None = None,
        limit: Mapping[str, Vector] | None = None,
        adc: Mapping[str, Vector] | None = None,  # numbers, behind which a rounding may stand
        dac: Mapping[str, Vector] | None = None,
        coloured_noises: tuple[AbstractNoise, ...] = (),
    ) -> Instruments:
        """Instruments of a plant, given by the names of its outputs and inputs, in the units of these signals.

        Parameters
        ----------
        plant
            The plant.
        noise
            Standard deviation of white noise, by output: one number, or one for each component of the output.
        quantum
            Quantisation step of the readings, by output: one number, or one for each component of the output.
        limit
            The pair (low, high) of the lowest and the highest command, by input.
        adc, dac
            Converters of outputs (adc) and of inputs (dac) by name: (bits, low, high) or (bits, low, high, rounding),
            as in {"omega": (12, -50.0, 50.0)}. The rounding is one of `Converter`.
        coloured_noises
            Noises of outputs that have a memory, such as `RandomWalk`.

        Raises
        ------
        LookupError
            If a name is not an output, or not an input, of the plant.
        ValueError
            If a number is negative or not finite; a limit is not a pair with low < high; or the numbers of a converter
            are wrong.
        """
        given, sensors, bounds = {"noise": noise or {}, "quantum": quantum or {}}, [], []
        for name in dict.fromkeys(name for named in given.values() for name in named):
            entry = plant.outputs[known_name(name, plant.outputs.names, "outputs of the plant")]
            own = {key: _each(key, entry, named.get(name, 0.0)) for key, named in given.items()}
            sensors.append(Sensor(name, entry.unit, **own))
        for name, pair in (limit or {}).items():
            entry = plant.inputs[known_name(name, plant.inputs.names, "inputs of the plant")]
            if not isinstance(pair, tuple | list) or len(pair) != 2:
                raise refusal("Instruments.of(limit=...)", f"a pair (low, high) for '{name}'", pair)
            bounds.append(Limit(name, entry.unit, *(_each("limit", entry, end) for end in pair)))
        adcs = tuple(_converter("adc", plant.outputs, "outputs", *given) for given in (adc or {}).items())
        dacs = tuple(_converter("dac", plant.inputs, "inputs", *given) for given in (dac or {}).items())
        noises = tuple(noise_of("coloured", noise, plant.outputs, "outputs of the plant") for noise in coloured_noises)
        return Instruments(tuple(sensors), tuple(bounds), adcs, dacs, noises)

    @property
    def reads(self) -> Layout:
        """The outputs that have a sensor, a converter or a coloured noise."""
        ports = {sensor.output: _port(sensor.output, sensor.unit, sensor.noise) for sensor in self.sensors}
        drifts = {entry.name: entry for entry in self._drifts.signals.entries}
        return Layout(tuple((drifts | _ports_of(self.adcs) | ports).values()))

    @property
    def limits(self) -> Layout:
        """The inputs that have a limit or a converter."""
        ports = {bound.input: _port(bound.input, bound.unit, bound.low) for bound in self.bounds}
        return Layout(tuple((_ports_of(self.dacs) | ports).values()))

    @property
    def noises(self) -> int:
        """The number of white noises of one reading: one for each component of an output with a sensor."""
        return self._draws.size

    @property
    def memory(self) -> Layout:
        """The states of the coloured noises."""
        return self._drifts.layout

    def noise_states(self, k: ca.SX, z: Parts, w: ca.SX, period: float) -> Parts:
        """The states of the coloured noises at the instant k, from their states z one `period` [s] before."""
        return self._drifts.after(k, z, w, period)

    def add_coloured_noise(self, y: Signals, z: Parts) -> Signals:
        """The outputs y with the coloured noises of the memory z added."""
        return y | {name: y[name] + drift for name, drift in self._drifts.signal_noise(z).items()}

    def read(self, y: Signals, w: ca.SX) -> Signals:
        """The readings for the outputs y, with standard normal random numbers w (noises, 1)."""
        refuse_misfit("Instruments.read", "w", w, self.noises, 1, "a normal number for each")
        draws, readings = self._draws.view(w), dict(y.only(self.reads))
        for sensor in self.sensors:
            x = y[sensor.output] + sensor.noise * draws[sensor.output]
            readings[sensor.output] = quantise(x, sensor.quantum + 0 * x)
        return Signals(readings | {adc.signal: adc.output(readings[adc.signal]) for adc in self.adcs})

    def limit_commands(self, u: Signals) -> Signals:
        """The commands u behind their limits and converters."""
        commands = dict(u.only(self.limits))
        commands |= {b.input: ca.fmin(ca.fmax(u[b.input], b.low), b.high) for b in self.bounds}
        return Signals(commands | {dac.signal: dac.output(commands[dac.signal]) for dac in self.dacs})

    @property
    def _drifts(self) -> NoiseStates:
        return NoiseStates(self.coloured_noises)

    @property
    def _draws(self) -> Layout:
        return Layout(tuple(_port(sensor.output, sensor.unit, sensor.noise) for sensor in self.sensors))


def _ports_of(converters: tuple[Converter, ...]) -> dict[str, Entry]:
    return {each.signal: _port(each.signal, each.unit, each.low) for each in converters}


def _converter(key: str, port: Layout, of: str, name: str, value: object) -> Converter:
    entry = port[known_name(name, port.names, f"{of} of the plant")]
    if not isinstance(value, tuple | list) or len(value) not in (3, 4):
        raise refusal(
            f"Instruments.of({key}=...)", f"(bits, low, high) or (bits, low, high, rounding) for '{name}'", value
        )
    bits, low, high, *rounding = value
    return Converter(name, entry.unit, bits, _each(key, entry, low), _each(key, entry, high), *rounding)


def _port(name: str, unit: str, each: Vector) -> Entry:
    size = ca.SX(each).numel()
    return Entry(name, np.zeros(() if size == 1 else size), unit)


def _each(key: str, entry: Entry, value: object) -> Array:
    call = f"Instruments.of({key}=...)"
    each = numbers(call, value)
    if each.shape not in ((), entry.shape):
        several = f"{entry.size} numbers or one for all of" if entry.shape else "one number for"
        raise ValueError(f"`{call}` must have {several} '{entry.name}'; got shape {each.shape}.")
    return np.broadcast_to(each, entry.shape)
