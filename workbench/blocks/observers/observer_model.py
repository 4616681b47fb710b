"""The model that an observer holds of any plant: its ports, and its equations as columns with their Jacobians."""

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractObserver, AbstractPlant, Inputs, Parts, Reads, is_recursion
from workbench.blocks.loop.plant_equilibrium import refuse_other
from workbench.blocks.loop.wiring import call_block
from workbench.core import Entry, Layout, Signals
from workbench.core.block import Number
from workbench.core.point import OperatingPoint, gain_of
from workbench.core.validation.refusals import Array, describe, known_name
from workbench.core.validation.signatures import check_arguments

MOST_SUBSTEPS = 1000  # of a period; each is written out
HAT = "_hat"  # of a state in the memory of an observer
# Taylor's series to this order at M / 2^SQUARINGS errs by 1e-16 there, while the poles of M stay below 40 in size.
ORDER, SQUARINGS = 15, 6


class AbstractModelObserver(AbstractObserver):
    """The base class of observers with a model of the plant in continuous time.

    Parameters
    ----------
    model
        The model: any plant in continuous time. The estimate begins at the initial values of its states.
    outputs
        Names of the outputs that the observer reads; the default () means all.
    """

    model: AbstractPlant
    outputs: tuple[str, ...]

    @property
    def inputs(self) -> Layout:
        """The inputs of the model, whose commands the observer uses."""
        return self.model.inputs

    @property
    def reads(self) -> Layout:
        """The outputs that the observer reads."""
        offered, of = self.model.outputs, f"outputs of `{type(self.model).__name__}`"
        return Layout(tuple(offered[known_name(name, offered.names, of)] for name in self.outputs or offered.names))

    @property
    def gives(self) -> Layout:
        """The estimates: of all states, and of the outputs that are not states."""
        states = self.model.states
        return states + Layout(tuple(e for e in self.model.outputs.entries if e.name not in states))

    @property
    def memory(self) -> Layout:
        """The estimated states, as `x_hat` for the state x, with their initial values."""
        return with_hats(self.model.states)

    @check_arguments
    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return self._estimates(t, self._column(z))

    def _estimates(self, t: ca.SX, x: ca.SX) -> Signals:
        """The signals that the observer gives, of a column of states."""
        return (self._outputs(t, x) | self._view(x)).only(self.gives)

    def _column(self, z: Parts) -> ca.SX:
        """The estimated states of a memory, (nx, 1)."""
        return self.model.states.flatten({name: z[f"{name}{HAT}"] for name in self.model.states.names})

    def _parts(self, x: ca.SX) -> dict[str, ca.SX]:
        """A column of states as the parts of a memory."""
        return {f"{name}{HAT}": part for name, part in self.model.states.view(x).items()}

    def _f(self, t: ca.SX, x: ca.SX, u: Inputs) -> ca.SX:
        """The rate of the model, (nx, 1)."""
        return self.model.states.flatten(call_block(self.model, "rate", self.model.states, t, self._view(x), u))

    def _h(self, t: ca.SX, x: ca.SX) -> ca.SX:
        """The outputs of the model that the observer reads, (ny, 1)."""
        return stack_signals(self._outputs(t, x), self.reads)

    def _view(self, x: ca.SX) -> Signals:
        return Signals(self.model.states.view(x))

    def _outputs(self, t: ca.SX, x: ca.SX) -> Signals:
        return call_block(self.model, "measure", self.model.outputs + self.model.truths, t, self._view(x))


def with_hats(states: Layout) -> Layout:
    """The states of a model as the memory of its observer calls them."""
    return Layout(tuple(Entry(f"{e.name}{HAT}", e.default, e.unit) for e in states.entries))


def start_layout(states: Layout, start: Array | None) -> Layout:
    """The memory of an observer that starts at a state (nx,), or at that of its model."""
    parts = {} if start is None else states.unpack(start)
    return with_hats(Layout(tuple(replace(e, default=parts.get(e.name, e.default)) for e in states.entries)))


def point_of_model(call: str, model: AbstractPlant, design: object) -> tuple[object, OperatingPoint]:
    """The gain of a design and the rest point of the model that it is about; anything else is refused."""
    gain, point = gain_of(design)
    if point is None:
        raise ValueError(
            f"`{call}(design=...)` must be a design about a point, as `steady_kalman` and `lqg` return it for a linear "
            f"model; got {describe(design)}. A gain alone is `{call.removesuffix('.of')}(model, L)`."
        )
    refuse_other(call, point, model.states, model.inputs)
    return gain, point


def stack_signals(signals: Signals, port: Layout) -> ca.SX:
    """The signals of a port as one column."""
    return port.flatten({name: ca.SX(part) for name, part in signals.only(port).items()})


def jacobian(function: Callable[[ca.SX], ca.SX], x: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The value of a function of a column at x, and its exact Jacobian there."""
    s = ca.SX.sym("s", x.numel())
    value = function(s)
    at, slope = ca.substitute([value, ca.jacobian(value, s)], [s], [x])
    return at, slope


def refuse_unfit(observer: AbstractModelObserver, **axes: tuple[Layout, ...]) -> None:
    """Refuse a model in discrete time, and arrays that have not the shape of the ports along their `axes`."""
    name, model = type(observer).__name__, observer.model
    if is_recursion(model):
        raise ValueError(
            f"`{name}(model=...)` must be a plant in continuous time, whose rate the observer integrates; "
            f"`{type(model).__name__}` has an update."
        )
    for field, ports in axes.items():
        value, want = getattr(observer, field), tuple(port.size for port in ports)
        if value is not None and np.shape(value) != want:
            each = zip(("a row", "a column") if len(ports) > 1 else ("a number",), ports, strict=True)
            labels = " and ".join(f"{axis} for each of {', '.join(port.labels) or 'none'}" for axis, port in each)
            raise ValueError(f"`{name}({field}=...)` must have shape {want}, {labels}; got {np.shape(value)}.")


def phi(M: ca.SX) -> ca.SX:
    """The series I + M / 2 + M^2 / 6 + ... of M^-1 (exp(M) - I): x' = M x + g moves by phi x'(0) in a unit of time."""
    one, small = ca.SX.eye(M.shape[0]), M / 2**SQUARINGS
    value = one
    for order in range(ORDER, 1, -1):
        value = one + small @ value / order
    for _ in range(SQUARINGS):
        value = value + value @ small @ value / 2  # phi(2 M) = phi(M) (I + exp(M)) / 2
        small = 2 * small
    return value
