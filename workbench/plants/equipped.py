"""A plant with actuators before its inputs and sensors behind its outputs, and a plant with disturbances."""

from collections.abc import Iterator, Mapping
from copy import copy
from dataclasses import replace
from itertools import count

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Signals, block
from workbench.core.block import Number, States, quantities
from workbench.core.port import column, misfits, signals_of
from workbench.core.shapes import Shape
from workbench.loop.contracts import AbstractPlant, Inputs, Parts, is_recursion
from workbench.loop.surroundings import AbstractReference
from workbench.loop.wiring import asked
from workbench.plants.elements import AbstractElement
from workbench.validation.refusals import known

TRUTH = "d_"  # of a disturbance on x is 'd_x'


class AbstractAround(AbstractPlant):
    """A plant that wraps another one, with the inputs, outputs and labels of that one."""

    plant: AbstractPlant

    @property
    def labels(self) -> Mapping[str, str]:
        return self.plant.labels

    @property
    def inputs(self) -> Layout:
        return self.plant.inputs

    @property
    def outputs(self) -> Layout:
        return self.plant.outputs

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...] | None:
        return self.plant.drawing(t, Signals(x).only(self.plant.states))


@block
class Equipped(AbstractAround):
    """A plant whose inputs pass through actuators, and whose outputs pass through sensors, in their order.

    Its states are those of the plant by their names, and those of the elements: `v.lag` of a lag in the way of v, of a
    second one `v.lag_2`. Where a sensor is in the way of an output, `omega`, say, what the plant gives is the truth
    `omega_true`. `v_applied` of a loop is what reaches the plant.

    Raises
    ------
    LookupError
        If an element is for a signal that is no input of the plant, or no output.
    ValueError
        If an element does not fit its signal in size or units; if an output has sensors already; or if the memory of
        an element moves in continuous time and the plant in discrete time, or the other way round.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> equipped = wb.Equipped(motor, actuators=(wb.Saturation("v", -12.0, 12.0), wb.FirstOrder("v", 0.02)))
    >>> equipped.states.names
    ('omega', 'i', 'v.lag')
    """

    plant: AbstractPlant
    actuators: tuple[AbstractElement, ...] = ()
    sensors: tuple[AbstractElement, ...] = ()

    def __post_init__(self) -> None:
        for name, port, of in (("actuators", self.inputs, "inputs"), ("sensors", self.outputs, "outputs")):
            elements = tuple(_fitted(name, element, port, of) for element in getattr(self, name))
            object.__setattr__(self, name, elements)
            for element in elements:
                _refuse_other_time(name, element, element.memory(port[element.signal]), self.plant)
        for name in self._sensed:
            if f"{name}_true" in self.outputs + self.plant.truths:
                raise ValueError(
                    f"`Equipped(sensors=...)` must leave the name '{name}_true' to what the plant gives, which has it "
                    f"already: put all sensors of '{name}' into one `Equipped`."
                )

    @property
    def period(self) -> float | None:  # type: ignore[override]
        return self.plant.period

    @property
    def recursion(self) -> bool:
        return is_recursion(self.plant)

    @property
    def truths(self) -> Layout:
        true = (replace(self.outputs[name], name=f"{name}_true") for name in self._sensed)
        return self.plant.truths + Layout(tuple(true))

    @property
    def states(self) -> Layout:
        own = (replace(entry, name=names[entry.name]) for _, z, names in self._memories() for entry in z.entries)
        return self.plant.states + Layout(tuple(own))

    def measure(self, t: Number, x: States) -> Signals:
        y = self._outputs(t, x)
        seen, _ = self._through(self.sensors, x, y)
        return seen | {f"{name}_true": y[name] for name in self._sensed}

    def applied(self, t: Number, x: States, u: Inputs) -> Signals:
        driven, _ = self._through(self.actuators, x, u)
        return asked(self.plant, "applied", self.inputs, t, self._own(x), driven)

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        return self._moved("rate", t, x, u)

    def update(self, t: Number, x: States, u: Inputs) -> Parts:
        return self._moved("update", t, x, u)

    def _moved(self, method: str, t: Number, x: States, u: Inputs) -> Parts:
        driven, actuators = self._through(self.actuators, x, u)
        _, sensors = self._through(self.sensors, x, self._outputs(t, x))
        moves = asked(self.plant, method, self.plant.states, t, self._own(x), driven)
        return moves | actuators | sensors

    @property
    def _sensed(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(element.signal for element in self.sensors))

    def _own(self, x: States) -> Signals:
        return Signals(x).only(self.plant.states)

    def _outputs(self, t: Number, x: States) -> Signals:
        return asked(self.plant, "measure", self.outputs + self.plant.truths, t, self._own(x))

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

    def _through(self, elements: tuple[AbstractElement, ...], x: States, signals: Signals) -> tuple[Signals, Parts]:
        """The signals after the elements that they pass through, and the rates, or updates, of these elements."""
        method = "update" if self.recursion else "rate"
        moves: dict[str, ca.SX] = {}
        for element, memory, names in self._memories():
            if element not in elements:
                continue
            kind, v = type(element).__name__, signals[element.signal]
            z = Signals({own: x[here] for own, here in names.items()})
            rates = signals_of(f"{kind}.{method}(...)", memory, getattr(element, method)(z, v))
            moves |= {names[own]: rate for own, rate in rates.items()}
            y = column(f"{kind}.output(...)", element.signal, v.shape, element.output(z, v))
            signals = signals | {element.signal: y}
        return signals, moves


@block
class Disturbed(AbstractAround):
    """A plant whose inputs, behind the command, and whose outputs have a signal in time added to them:

        x' = f(t, x, u + d_u(t)),      y = h(t, x) + d_y(t).

    The signals are those of the reference `by`, each named as an input or an output of the plant, without their
    derivatives; they are truths of the plant, `d_v` that on the input v, which no instrument gives.

    Raises
    ------
    ValueError
        If a signal does not fit the plant by name, size and unit; or the plant is disturbed there already.

    Examples
    --------
    >>> motor = wb.Disturbed(wb.DCMotor(), by=wb.Step("v", "V", 1.0, time=2.0))
    >>> motor.inputs.names, motor.truths.names
    (('v',), ('d_v',))
    """

    plant: AbstractPlant
    by: AbstractReference

    def __post_init__(self) -> None:
        for clause in misfits(self._added, self.plant.inputs + self.plant.outputs):
            held = clause.format(gives=f"`{type(self.plant).__name__}` has")
            raise ValueError(f"`Disturbed(by=...)` adds {held if held.endswith('?') else f'{held}.'}")
        for name in self._added.prefixed(TRUTH).names:
            if name in self.plant.outputs + self.plant.truths:
                raise ValueError(
                    f"`Disturbed(by=...)` must leave the name '{name}' to `{type(self.plant).__name__}`, which has it "
                    "already: where that is a disturbance too, add the two up in one signal."
                )

    @property
    def period(self) -> float | None:  # type: ignore[override]
        return self.plant.period

    @property
    def recursion(self) -> bool:
        return is_recursion(self.plant)

    @property
    def states(self) -> Layout:
        return self.plant.states

    @property
    def truths(self) -> Layout:
        return self.plant.truths + self._added.prefixed(TRUTH)

    def measure(self, t: Number, x: States) -> Signals:
        d, y = self._at(t), Signals(self.plant.measure(t, x))
        truths = {f"{TRUTH}{name}": part for name, part in d.items()}
        return y | {name: y[name] + part for name, part in d.items() if name in self.outputs} | truths

    def applied(self, t: Number, x: States, u: Inputs) -> Signals:
        return self.plant.applied(t, x, self._driven(t, u))

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        return self.plant.rate(t, x, self._driven(t, u))

    def update(self, t: Number, x: States, u: Inputs) -> Parts:
        return self.plant.update(t, x, self._driven(t, u))

    @property
    def _added(self) -> Layout:
        return Layout(
            tuple(Entry(e.name, e.default, e.unit) for e in self.by.says.entries if e.name in self.by.primary)
        )

    def _at(self, t: Number) -> Signals:
        return Signals(self.by.at(t)).only(self._added)

    def _driven(self, t: Number, u: Inputs) -> Signals:
        return u | {name: u[name] + part for name, part in self._at(t).items() if name in self.inputs}


def _refuse_other_time(field: str, element: AbstractElement, memory: Layout, plant: AbstractPlant) -> None:
    """Refuse an element whose memory moves in continuous time before a plant in discrete time, and the other way."""
    if not memory.size or element.recursion == is_recursion(plant):
        return
    kind, times = type(element).__name__, ("continuous", "discrete")
    if element.recursion:
        way = "give it a `time_constant`, which the step of a simulation resolves"
    else:
        way = (
            "there are elements without a memory, a `Backlash` without a `time_constant`, and the `delay` of `digital`"
        )
    raise ValueError(
        f"`{kind}` of '{element.signal}' in `{field}` must move in {times[is_recursion(plant)]} time, as "
        f"`{type(plant).__name__}` does, and moves in {times[element.recursion]} time: {way}."
    )


def _fitted(field: str, element: AbstractElement, port: Layout, of: str) -> AbstractElement:
    """An element with the unit of its signal, or a refusal of one that fits no signal of the port."""
    entry = port[known(element.signal, port.names, f"{of} of the plant")]
    for f, quantity in quantities(element):
        shape = np.shape(getattr(element, f.name))
        differ = quantity.lifted and "{unit}" in quantity.unit and len(set(entry.units)) > 1
        if quantity.shape != ("*",) or shape == entry.shape or not (shape or differ):
            continue
        must = f"be one number, as '{entry.name}' is"
        if entry.shape:
            why = f" (in {entry.unit})" if differ else ", or one for all"
            must = f"be {entry.size} numbers, one for each of '{entry.name}'{why}"
        raise ValueError(f"`{type(element).__name__}({f.name}=...)` in `{field}` must {must}; got shape {shape}.")
    twin = copy(element)
    object.__setattr__(twin, "unit", entry.unit)
    return twin
