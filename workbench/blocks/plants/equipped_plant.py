"""A plant with actuators before its inputs and sensors behind its outputs."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import count

import casadi as ca

from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts, is_recursion
from workbench.blocks.loop.signal_units import fit_element
from workbench.blocks.loop.wiring import call_block
from workbench.blocks.plants.elements import AbstractElement
from workbench.core import Layout, Signals, block
from workbench.core.block import Number, States
from workbench.core.port import column, signals_of
from workbench.core.shapes import Shape


class AbstractPlantWrapper(AbstractPlant):
    """A plant that wraps another plant and has the same inputs, outputs and labels.

    Parameters
    ----------
    plant
        The plant inside.
    """

    plant: AbstractPlant

    @property
    def power(self) -> tuple[str, ...]:  # type: ignore[override]
        return self.plant.power

    @property
    def labels(self) -> Mapping[str, str]:
        return self.plant.labels

    @property
    def inputs(self) -> Layout:
        return self.plant.inputs

    @property
    def outputs(self) -> Layout:
        return self.plant.outputs

    @property
    def noises(self) -> int:
        return self.plant.noises

    def noise_states(self, k: Number, x: States, w: ca.SX, period: float) -> Parts:
        return self.plant.noise_states(k, Signals(x).only(self.plant.states), w, period)

    @property
    def sampled_states(self) -> Layout:
        return self.plant.sampled_states

    def update_sampled_states(self, t: Number, x: States, u: Inputs) -> Parts:
        return self.plant.update_sampled_states(t, Signals(x).only(self.plant.states), u)

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...] | None:
        return self.plant.drawing(t, Signals(x).only(self.plant.states))


@block
class EquippedPlant(AbstractPlantWrapper):
    """A plant with actuators before its inputs and sensors behind its outputs.

    The states are the states of the plant and of the elements. A lag in the path of v adds the state `v.lag`; a second
    lag adds `v.lag_2`. If an output `omega` has a sensor, `omega` is the signal behind the sensor, and the plant's
    output before the sensor is the truth `omega_true`. In a loop, `v` is the command and `v_applied` is the signal that
    reaches the plant behind its actuators.

    Some elements move from sample to sample, as a `Backlash` without a time constant does. Their samples are the
    instants of a computer, so such a loop must be made by `digital`.

    Parameters
    ----------
    actuators
        Elements for inputs of the plant. Elements for the same input act in the order given.
    sensors
        Elements for outputs of the plant. Elements for the same output act in the order given.

    Raises
    ------
    LookupError
        If the signal of an actuator is not an input of the plant, or the signal of a sensor not an output.
    ValueError
        If an element does not fit its signal in size or units; if an output has sensors already; or if the memory of
        an element moves in continuous time and the plant in discrete time.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> equipped = wb.EquippedPlant(motor, actuators=(wb.Saturation("v", -12.0, 12.0), wb.FirstOrder("v", 0.02)))
    >>> equipped.states.names
    ('omega', 'i', 'v.lag')
    """

    plant: AbstractPlant
    actuators: tuple[AbstractElement, ...] = ()
    sensors: tuple[AbstractElement, ...] = ()

    def __post_init__(self) -> None:
        for name, port, of in (("actuators", self.inputs, "inputs"), ("sensors", self.outputs, "outputs")):
            elements = tuple(fit_element(name, element, port, of) for element in getattr(self, name))
            object.__setattr__(self, name, elements)
            for element in elements:
                _refuse_other_time(name, element, element.memory(port[element.signal]), self.plant)
        for name in self._sensed_outputs:
            if f"{name}_true" in self.outputs + self.plant.truths:
                raise ValueError(
                    f"`EquippedPlant(sensors=...)` must leave the name '{name}_true' to what the plant gives, which "
                    f"has it already: put all sensors of '{name}' into one `EquippedPlant`."
                )

    @property
    def period(self) -> float | None:  # type: ignore[override]
        """The period of a plant in discrete time in s, else None."""
        return self.plant.period

    @property
    def recursion(self) -> bool:
        """True if the plant is in discrete time."""
        return is_recursion(self.plant)

    @property
    def truths(self) -> Layout:
        true = (replace(self.outputs[name], name=f"{name}_true") for name in self._sensed_outputs)
        return self.plant.truths + Layout(tuple(true))

    @property
    def states(self) -> Layout:
        own = (replace(entry, name=names[entry.name]) for _, z, names in self._memories() for entry in z.entries)
        return self.plant.states + Layout(tuple(own))

    def measure(self, t: Number, x: States) -> Signals:
        y = self._outputs(t, x)
        seen, _ = self._through(self.sensors, x, y)
        return seen | {f"{name}_true": y[name] for name in self._sensed_outputs}

    def applied_inputs(self, t: Number, x: States, u: Inputs) -> Signals:
        driven, _ = self._through(self.actuators, x, u)
        return call_block(self.plant, "applied_inputs", self.inputs, t, self._own(x), driven)

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        return self._next_states("rate", self.plant.states, t, x, u)

    def update(self, t: Number, x: States, u: Inputs) -> Parts:
        """The states at the next instant, for a plant in discrete time."""
        return self._next_states("update", self.plant.states, t, x, u)

    @property
    def sampled_states(self) -> Layout:
        """The states of elements that move from sample to sample, if the plant moves in continuous time."""
        own = ((z, names) for each, z, names in self._memories() if each.recursion and not self.recursion)
        return self.plant.sampled_states + Layout(tuple(replace(e, name=n[e.name]) for z, n in own for e in z.entries))

    def update_sampled_states(self, t: Number, x: States, u: Inputs) -> Parts:
        return {} if self.recursion else self._next_states("update_sampled_states", self.plant.sampled_states, t, x, u)

    def _next_states(self, method: str, port: Layout, t: Number, x: States, u: Inputs) -> Parts:
        driven, actuators = self._through(self.actuators, x, u, method)
        _, sensors = self._through(self.sensors, x, self._outputs(t, x), method)
        return call_block(self.plant, method, port, t, self._own(x), driven) | actuators | sensors

    @property
    def _sensed_outputs(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(element.signal for element in self.sensors))

    def _own(self, x: States) -> Signals:
        return Signals(x).only(self.plant.states)

    def _outputs(self, t: Number, x: States) -> Signals:
        return call_block(self.plant, "measure", self.outputs + self.plant.truths, t, self._own(x))

    def _memories(self) -> Iterator[tuple[AbstractElement, Layout, dict[str, str]]]:
        """Each element with its memory, and the names of its states here."""
        taken = set(self.plant.states.names)
        for element in (*self.actuators, *self.sensors):
            port = self.inputs if element in self.actuators else self.outputs
            memory = element.memory(port[element.signal])
            for i in count(1):
                end = "" if i == 1 else f"_{i}"
                names = {name: f"{element.signal}.{name}{end}" for name in memory.names}
                if taken.isdisjoint(names.values()):
                    break
            taken |= set(names.values())
            yield element, memory, names

    def _through(
        self, elements: tuple[AbstractElement, ...], x: States, signals: Signals, method: str = "rate"
    ) -> tuple[Signals, Parts]:
        """The signals after the elements that they pass through, and what moves the memories of these elements."""
        moves: dict[str, ca.SX] = {}
        for element, memory, names in self._memories():
            if element not in elements:
                continue
            v = signals[element.signal]
            z = Signals({own: x[here] for own, here in names.items()})
            moves |= {names[own]: part for own, part in _moves(element, memory, method, z, v).items()}
            y = column(f"{type(element).__name__}.output(...)", element.signal, v.shape, element.output(z, v))
            signals = signals | {element.signal: y}
        return signals, moves


def _moves(element: AbstractElement, memory: Layout, method: str, z: Signals, v: ca.SX) -> Parts:
    """The rates of a memory, which are zero where it moves sample by sample, or its next values, if it does."""
    if method == "rate" and element.recursion:
        return {name: ca.SX.zeros(part.shape) for name, part in z.items()}
    own = "rate" if method == "rate" else "update"
    if own == "update" and not element.recursion:
        return {}
    return signals_of(f"{type(element).__name__}.{own}(...)", memory, getattr(element, own)(z, v))


def _refuse_other_time(field: str, element: AbstractElement, memory: Layout, plant: AbstractPlant) -> None:
    """Refuse an element whose memory moves in continuous time before a plant in discrete time."""
    if memory.size and is_recursion(plant) and not element.recursion:
        kind = type(element).__name__
        raise ValueError(
            f"`{kind}` of '{element.signal}' in `{field}` must move in discrete time, as `{type(plant).__name__}` "
            "does, and moves in continuous time: there are elements without a memory, a `Backlash` without a "
            "`time_constant`, and the `delay` of `digital`."
        )
