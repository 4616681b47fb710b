"""The contracts of a plant, an observer and a law: the ports and methods that a loop needs of each block.

A block declares its ports as layouts. Its `memory`, or the `states` of a plant, are by default the fields declared with
`initial`. `rate` returns the derivative of each state. In discrete time `update` returns their next values instead.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import Field
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, ClassVar, Self

import casadi as ca

from workbench.blocks.loop.declarations import AbstractBlock
from workbench.core import Layout, Signals
from workbench.core.block import Memory, Number, States, initial_states
from workbench.core.shapes import Shape
from workbench.core.validation.refusals import seconds
from workbench.core.validation.signatures import check_arguments

EULER, RECURSION = "explicit Euler", "its own recursion in discrete time"

Parts = Memory  # the memory of a block, or its rate: a name for each quantity
Reads = Annotated[Signals, "reads"]
Follows = Annotated[Signals, "follows"]
Inputs = Annotated[Signals, "inputs"]


ARM = "`Manipulator(arm, q=...)` is the plant of an arm; laws of arms have names such as `ArmPID`"


class AbstractPlant(AbstractBlock, ABC):
    """The base class of plants, with x' = rate(t, x, u) and y = measure(t, x).

    In the methods, t is the time in s; x and u are mappings from names of states and inputs to CasADi expressions.

    Examples
    --------
    >>> @wb.block
    ... class Tank(wb.Plant):
    ...     h: float = wb.initial(default=1.0, unit="m")
    ...     inputs, outputs = wb.layout(w="m^3/s"), wb.layout(h="m")
    ...     def rate(self, t, x, u):
    ...         return {"h": u.w / 2.0}
    >>> wb.linearize(wb.open_loop(Tank()), 0.0, [1.0]).B
    array([[0.5]])
    """

    if TYPE_CHECKING:  # each block is a dataclass, so `dataclasses.replace` takes it
        __dataclass_fields__: ClassVar[dict[str, Field[object]]]
    update: Callable[..., Parts]
    counts: str = ""  # the thing to which each entry of a vector belongs, as 'tank'
    power: tuple[str, ...] = ()  # an input and an output whose product is a power, as ("v", "i")
    period: float | None = None  # s, of a plant in discrete time, which has an `update` in place of a `rate`

    WAYS: ClassVar[Mapping[str, str]] = MappingProxyType(dict.fromkeys(("PlanarArm", "SpatialArm"), ARM))

    @property
    def noises(self) -> int:
        """The number of standard normal random numbers that the plant needs at each instant of a computer."""
        return 0

    @check_arguments
    def noise_states(self, k: Number, x: States, w: ca.SX, period: float) -> Parts:
        """The noise states at the instant k of a computer, from x one `period` [s] before and normal w (noises, 1)."""
        del k, x, w, period
        return {}

    @property
    def sampled_states(self) -> Layout:
        """The states that change only at the instants of a computer, after its command; their rate is zero."""
        return Layout()

    @check_arguments
    def update_sampled_states(self, t: Number, x: States, u: Inputs) -> Parts:
        """The values of `sampled_states` after an instant from which the inputs u act."""
        del t, x, u
        return {}

    @property
    def truths(self) -> Layout:
        """The signals that no instrument measures, such as a disturbance. `measure` returns them with the outputs."""
        return Layout()

    @property
    def labels(self) -> Mapping[str, str]:
        """Shorter names of signals in a loop with this plant, as `{"e_q": "e"}`: the loop calls e_q e."""
        return {}

    @property
    def states(self) -> Layout:
        """The states with their initial values: by default the fields that are declared by `initial`."""
        return initial_states(self)

    @property
    @abstractmethod
    def inputs(self) -> Layout:
        """The inputs of the plant, with their units."""

    @property
    @abstractmethod
    def outputs(self) -> Layout:
        """The outputs of the plant, which instruments can measure, with their units."""

    @check_arguments
    def measure(self, t: Number, x: States) -> Signals:
        """The outputs and truths at time t [s] and states x: by default the states of the same names."""
        del t
        for name in (name for name in self.outputs.names if name not in x):
            must = f"must have a method `measure(t, x)`, as its output '{name}' is no state"
            raise ValueError(f"`{type(self).__name__}` {must}: return a mapping from each output to its expression.")
        return Signals({name: x[name] for name in self.outputs.names})

    @check_arguments
    def applied_inputs(self, t: Number, x: States, u: Inputs) -> Signals:
        """The inputs that act on the plant when the inputs u are commanded, for example behind its actuators."""
        del t, x
        return u

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...] | None:
        """The picture of the plant for a live page: shapes with coordinates in m; None for no picture."""
        del t, x
        return None

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        """The time derivative of each state, by name, at time t [s], states x and inputs u."""
        del t, x, u
        raise ValueError(
            f"`{type(self).__name__}` must have a `rate`, or an `update` and a `period`, as a plant moves by one of "
            "them; it has neither: write one."
        )


class AbstractMember(AbstractBlock, ABC):
    """A block that a computer can run: an observer or a law."""

    if TYPE_CHECKING:  # each block is a dataclass, so `dataclasses.replace` takes it
        __dataclass_fields__: ClassVar[dict[str, Field[object]]]
    update: Callable[..., Parts]
    period: float | None = None  # s, with which a computer runs the block; None for the period of the loop's computer
    hint_on_reads: str = ""  # a sentence of advice, for a loop without a signal that the block reads

    @property
    def memory(self) -> Layout:
        """The states of the block with their initial values: by default the fields that are declared by `initial`."""
        return initial_states(self)

    @property
    def method(self) -> str:
        """The name of the integration method that `advance` uses, as a report prints it."""
        return RECURSION if is_recursion(self) else EULER

    def without(self) -> Mapping[str, AbstractMember]:
        """Copies of the block, each with one part removed, by the name of that part; empty if it has no parts."""
        return {}


class AbstractObserver(AbstractMember):
    """The base class of observers: an observer makes estimates from measurements.

    The estimates do not depend on the command of the same instant. In the methods, t is the time in s; z (the memory of
    the observer), y (measurements), est (estimates) and u (commands) are mappings from names to CasADi expressions.

    Examples
    --------
    >>> @wb.block
    ... class Tachometer(wb.Observer):
    ...     reads, gives = wb.layout(v_t="V"), wb.layout(omega="rad/s")
    ...     def estimate(self, t, z, y):
    ...         return {"omega": 10.0 * y.v_t}
    >>> Tachometer().gives.names
    ('omega',)
    """

    if TYPE_CHECKING:

        def without(self) -> Mapping[str, AbstractObserver]: ...  # noqa: D102

    @property
    def inputs(self) -> Layout:
        """The inputs of the plant whose commands the observer uses; none by default."""
        return Layout()

    @property
    def uses_truth(self) -> bool:
        """True if the observer reads signals that no instrument measures."""
        return False

    @property
    @abstractmethod
    def reads(self) -> Layout:
        """The outputs of the plant that the observer reads, and the truths if `uses_truth` is true."""

    @property
    @abstractmethod
    def gives(self) -> Layout:
        """The signals that the observer estimates."""

    @abstractmethod
    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        """The estimates by name, from the memory z and the measurements y at time t [s]."""

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The time derivative of each state of the memory, with the commands u; empty without a memory."""
        del t, z, y, est, u
        return {}

    @check_arguments
    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        """The memory after one `period` [s] of a computer, which holds y, est and u during the period."""
        if is_recursion(self):
            return self.update(t, z, y, est, u)
        return euler(z, self.rate(t, z, y, est, u), period)


class AbstractController(AbstractMember):
    """The base class of control laws: a law makes commands from estimates and references.

    In the methods, t is the time in s; z (memory), est (estimates) and ref (references) are mappings from names.

    Examples
    --------
    >>> @wb.block
    ... class P(wb.Controller):
    ...     k: float = wb.parameter(unit="V s/rad")
    ...     reads = follows = wb.layout(omega="rad/s")
    ...     drives = wb.layout(v="V")
    ...     def command(self, t, z, est, ref):
    ...         return {"v": self.k * (ref.omega - est.omega)}
    >>> wb.ClosedLoop(wb.DCMotor(), controller=P(50.0), reference=wb.Step("omega", "rad/s", 1.0)).follows
    ('omega',)
    """

    if TYPE_CHECKING:

        def without(self) -> Mapping[str, AbstractController]: ...  # noqa: D102

    hint_on_follows: str = ""  # the law, as a noun phrase, that follows what this one reads alone: {names}, {wanted}

    @property
    def follows(self) -> Layout:
        """The signals of the reference that the law uses; none for a law that only regulates to a fixed point."""
        return Layout()

    @property
    def signal_units(self) -> Mapping[str, str]:
        """The units of the signals that `signals` returns, by name, as {"energy": "J"}."""
        return {}

    @property
    @abstractmethod
    def reads(self) -> Layout:
        """The estimates that the law reads."""

    @property
    @abstractmethod
    def drives(self) -> Layout:
        """The inputs of the plant that the law commands."""

    @abstractmethod
    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        """The commands by name, from the memory z, the estimates est and the references ref at time t [s]."""

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The time derivative of each state of the memory; empty without a memory."""
        del t, z, est, ref
        return {}

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        """Signals of the law that a run records besides the memory, such as a sliding variable s."""
        del z, est, ref
        return {}

    @check_arguments
    def advance(self, t: Number, z: Parts, est: Reads, ref: Follows, period: float) -> Parts:
        """The memory after one `period` [s] of a computer, which holds est and ref during the period."""
        if is_recursion(self):
            return self.update(t, z, est, ref)
        return euler(z, self.rate(t, z, est, ref), period)

    @check_arguments
    def run_every(self, period: float) -> Self:
        """A copy of the law that a computer runs once in every `period` seconds."""
        law = copy(self)
        object.__setattr__(law, "period", seconds("run_every(period=...)", period))
        return law


def is_recursion(block: AbstractMember | AbstractPlant) -> bool:
    """True if a block is in discrete time: its attribute `recursion` is true, or it has `update` and no `recursion`."""
    return hasattr(type(block), "update") and getattr(block, "recursion", True)


def euler(z: Parts, rates: Parts, period: float) -> dict[str, ca.SX]:
    """z + period z', the explicit Euler step of each part of a memory."""
    return {name: z[name] + period * rate for name, rate in rates.items()}
