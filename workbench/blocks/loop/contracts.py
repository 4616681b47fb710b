"""The contracts of a plant, an observer and a law: the ports and methods that a loop asks of each block.

A block declares its ports as layouts, and its own states as its `memory`; a plant calls its own states `states`.
Where a class does not, they are the fields that it declares with `initial`. Its `rate` returns a part for each of them.
A block in discrete time has an `update` of the same arguments in place of a `rate`: the values at the next instant.
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
    """A plant: driven by its inputs, watched by its outputs.

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
    counts: str = ""  # the thing that the numbers of its vectors count, as 'tank'
    power: tuple[str, ...] = ()  # an input and an output whose product is a power, as ("v", "i")
    period: float | None = None  # s, of a plant in discrete time, which has an `update` in place of a `rate`

    WAYS: ClassVar[Mapping[str, str]] = MappingProxyType(dict.fromkeys(("PlanarArm", "SpatialArm"), ARM))

    @property
    def noises(self) -> int:
        """The number of standard normal numbers that the plant takes at each instant of a computer."""
        return 0

    @check_arguments
    def noise_states(self, k: Number, x: States, w: ca.SX, period: float) -> Parts:
        """The states that noise moves at the instant k of a computer, by w (noises, 1); a period in s after k - 1."""
        del k, x, w, period
        return {}

    @property
    def sampled_states(self) -> Layout:
        """The states that move at the instants of a computer alone, behind its command; their rate is zero."""
        return Layout()

    @check_arguments
    def update_sampled_states(self, t: Number, x: States, u: Inputs) -> Parts:
        """The settling states behind an instant from which on `u` acts."""
        del t, x, u
        return {}

    @property
    def truths(self) -> Layout:
        """The signals that no instrument measures, such as a disturbance; `measure` returns them beside the outputs."""
        return Layout()

    @property
    def labels(self) -> Mapping[str, str]:
        """Shorter names that a loop gives to signals of this plant: `{"e_q": "e"}`."""
        return {}

    @property
    def states(self) -> Layout:
        """The states, each with its start: the fields that are declared by `initial`."""
        return initial_states(self)

    @property
    @abstractmethod
    def inputs(self) -> Layout:
        """The signals that drive it."""

    @property
    @abstractmethod
    def outputs(self) -> Layout:
        """The signals that instruments read of it."""

    @check_arguments
    def measure(self, t: Number, x: States) -> Signals:
        """The outputs and truths at a state: by default the states of the same names."""
        del t
        for name in (name for name in self.outputs.names if name not in x):
            must = f"must have a method `measure(t, x)`, as its output '{name}' is no state"
            raise ValueError(f"`{type(self).__name__}` {must}: return a mapping from each output to its expression.")
        return Signals({name: x[name] for name in self.outputs.names})

    @check_arguments
    def applied_inputs(self, t: Number, x: States, u: Inputs) -> Signals:
        """The inputs that act in the plant where `u` is commanded."""
        del t, x
        return u

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...] | None:
        """The picture of the plant at a state, in m to the right and upward, which a live page moves; None: no picture.

        A `Line`, a `Circle` or a `Word` has its place as an expression in the time, the states and the parameters.
        """
        del t, x
        return None

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        """The derivative of each state."""
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
    period: float | None = None  # s, at which a computer runs it, if it is not that of the loop's computer
    hint_on_reads: str = ""  # a sentence of advice for who makes it read what is not there

    @property
    def memory(self) -> Layout:
        """The states of the block: the fields that are declared by `initial`."""
        return initial_states(self)

    @property
    def method(self) -> str:
        """The name of the method by which `advance` steps the memory, as a page has it."""
        return RECURSION if is_recursion(self) else EULER

    def without(self) -> Mapping[str, AbstractMember]:
        """The block less each of its parts, by the name of the part; none where it has no parts."""
        return {}


class AbstractObserver(AbstractMember):
    """An observer: from measurements to estimates, which never depend on the command of the same instant.

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
        """The inputs of the plant whose commands it reads."""
        return Layout()

    @property
    def uses_truth(self) -> bool:
        """True if it reads signals that no instrument measures."""
        return False

    @property
    @abstractmethod
    def reads(self) -> Layout:
        """The outputs of the plant that it reads, and the truths where it `uses_truth`."""

    @property
    @abstractmethod
    def gives(self) -> Layout:
        """The signals that it estimates."""

    @abstractmethod
    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        """The estimates."""

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The derivative of each state, when `u` is commanded; nothing where there is no memory."""
        del t, z, y, est, u
        return {}

    @check_arguments
    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        """The memory at the end of a period in s, over which a computer holds the readings and the commands."""
        if is_recursion(self):
            return self.update(t, z, y, est, u)
        return euler(z, self.rate(t, z, y, est, u), period)


class AbstractController(AbstractMember):
    """A law: from estimates and the wanted signals to commands.

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
        """The signals of the reference; none where the law keeps the plant at rest."""
        return Layout()

    @property
    def signal_units(self) -> Mapping[str, str]:
        """The units of the signals that `signals` returns, by name, as {"energy": "J"}."""
        return {}

    @property
    @abstractmethod
    def reads(self) -> Layout:
        """The estimates that it reads."""

    @property
    @abstractmethod
    def drives(self) -> Layout:
        """The inputs of the plant that it commands."""

    @abstractmethod
    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        """The commands."""

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The derivative of each state; nothing where there is no memory."""
        del t, z, est, ref
        return {}

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The signals that are worth watching besides the memory: the sliding variable s, say."""
        del z, est, ref
        return {}

    @check_arguments
    def advance(self, t: Number, z: Parts, est: Reads, ref: Follows, period: float) -> Parts:
        """The memory at the end of a period in s, over which a computer holds the estimate and the reference."""
        if is_recursion(self):
            return self.update(t, z, est, ref)
        return euler(z, self.rate(t, z, est, ref), period)

    @check_arguments
    def run_every(self, period: float) -> Self:
        """The same law, run by a computer once in `period` seconds."""
        law = copy(self)
        object.__setattr__(law, "period", seconds("run_every(period=...)", period))
        return law


def is_recursion(block: AbstractMember | AbstractPlant) -> bool:
    """True if a block is one in discrete time: it has an `update` in place of a `rate`.

    A block that has both, as what it holds may be of either kind, says which by an attribute `recursion`.
    """
    return hasattr(type(block), "update") and getattr(block, "recursion", True)


def euler(z: Parts, rates: Parts, period: float) -> dict[str, ca.SX]:
    """z + period z', the explicit Euler step of each part of a memory."""
    return {name: z[name] + period * rate for name, rate in rates.items()}
