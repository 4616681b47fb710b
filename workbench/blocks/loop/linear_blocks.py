"""Linear systems in the sockets of a loop: a plant or a law by its matrices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import (
    AbstractController,
    AbstractPlant,
    Follows,
    Inputs,
    Parts,
    Reads,
)
from workbench.core import Layout, LinearSystem, Signals, block, initial, parameter
from workbench.core.block import Number, States, Vector, socket
from workbench.core.units import ANY
from workbench.core.validation.refusals import vector

REFERENCE_ENDING = "_ref"  # an input of a law by this ending is a wanted signal


class AbstractLinear:
    """The base class of blocks that are linear systems."""

    system: LinearSystem

    @property
    def recursion(self) -> bool:
        """True if the system is in discrete time."""
        return self.system.dt is not None

    @property
    def memory(self) -> Layout:
        """The states of the system."""
        return self.system.states


@block
class LinearPlant(AbstractLinear, AbstractPlant):
    """A linear system as a plant, in continuous time, or in discrete time if the system has a period:

        x' = A x + B u    or    x+ = A x + B u,              y = C x.

    For a system that was linearised at a point, x, u and y are the full values, and not the deviations from the point.

    Parameters
    ----------
    system
        A `StateSpace` or `TransferFunction` of python-control, with names for its inputs and outputs.
    start
        The initial state (nx,). The default is the point of a linearised system, and zero for any other system.

    Raises
    ------
    ValueError
        If `LinearSystem.of` refuses the system, or the system has direct feedthrough (D is not zero).

    Examples
    --------
    >>> import control
    >>> system = control.tf([1.0], [1.0, 0.5], inputs="v", outputs="omega")
    >>> wb.LinearPlant(system).outputs.names
    ('omega',)
    """

    system: LinearSystem = socket(LinearSystem.of)
    start: Vector = initial(default=None, unit=ANY, shape=("nx",))

    def __post_init__(self) -> None:
        refuse_feedthrough("LinearPlant", self.system, self.system.inputs.names, "the loop would be an algebraic one")
        if self.start is not None:
            vector("LinearPlant(start=...)", self.start, self.system.states.size, "states")
        else:
            object.__setattr__(self, "start", self.system.x0)
        object.__setattr__(self, "system", replace(self.system, D=None))  # no number that does nothing
        object.__setattr__(self, "period", self.system.dt)

    @property
    def states(self) -> Layout:
        """The states of the system with their initial values."""
        parts = {} if self.start is None else self.system.states.unpack(self.start)
        return Layout(tuple(replace(e, default=parts.get(e.name, e.default)) for e in self.system.states.entries))

    @property
    def inputs(self) -> Layout:
        """The inputs of the system."""
        return self.system.inputs

    @property
    def outputs(self) -> Layout:
        """The outputs of the system."""
        return self.system.outputs

    def measure(self, t: Number, x: States) -> Signals:
        """The outputs y = C x."""
        del t
        y = self.system.output_column(self.system.states.flatten(x), ca.SX.zeros(self.inputs.size))
        return Signals(self.outputs.view(y))

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        """A x + B u: the time derivative of each state, or its value at the next instant of a discrete system."""
        del t
        return self.system.dynamics(self.system.states.flatten(x), self.inputs.flatten(u))

    update = rate


@block
class LinearLaw(AbstractLinear, AbstractController):
    """A linear system as a law, in continuous time, or in discrete time if the system has a period:

        z' = A z + B v    or    z+ = A z + B v,              u = u0 + C z + D v,              v = inputs - v0.

    An input of the system that is named x reads the estimate of x. An input that is named `x_ref` follows the reference
    of x. A discrete law must run with its own period.

    Parameters
    ----------
    system
        A `StateSpace` or `TransferFunction` of python-control, with names for its inputs and outputs.
    error
        True for a compensator of the error: an input x is then the reference minus the estimate, x_ref - x, as in
        `control.feedback(P * C)`. The errors `e_x` among the outputs of a loop have the opposite sign.
    u0
        The command (nu,) at the operating point. The default is that of a system designed from a linearised plant, and
        zero for any other system.
    v0
        The inputs (nv,) of the system at the operating point, with the same default. With `error` they are zero.

    Raises
    ------
    ValueError
        If `LinearSystem.of` refuses the system, or u0 or v0 has the wrong shape.

    Examples
    --------
    >>> import control
    >>> lead = control.tf([50, 600, 1000], [1, 20, 0], inputs="omega", outputs="v")
    >>> law = wb.LinearLaw(lead, error=True)
    >>> law.reads.names, law.follows.names, law.drives.names
    (('omega',), ('omega',), ('v',))
    """

    system: LinearSystem = socket(LinearSystem.of)
    error: bool = False
    u0: Vector = parameter(default=None, unit=ANY, shape=("nu",))
    v0: Vector = parameter(default=None, unit=ANY, shape=("nv",))
    hint_on_reads = (
        "The inputs of a system are taken by their names: an input 'y' is the output y of the plant, or its error by "
        "`LinearLaw(C, error=True)`, and an input 'y_ref' what is wanted of it."
    )
    hint_on_follows = (
        "`LinearLaw(C, error=True)` where C is a compensator of the error, as that of `lqg` is not, or a system with "
        "the inputs {names} and {wanted}"
    )
    stands = False  # True of a system that was given to a loop as it stands, see `as_it_stands`

    def __post_init__(self) -> None:
        for name, port in (("u0", self.system.outputs), ("v0", self.system.inputs)):
            if getattr(self, name) is not None:
                vector(f"LinearLaw({name}=...)", getattr(self, name), port.size, f"signals {', '.join(port.labels)}")
        own = {"u0": self.system.y0, "v0": None if self.error else self.system.u0}
        for name, value in own.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        object.__setattr__(self, "system", replace(self.system, u0=None, y0=None))
        object.__setattr__(self, "period", self.system.dt)

    @property
    def reads(self) -> Layout:
        """The inputs of the system that are not references."""
        return Layout(tuple(entry for entry in self.system.inputs.entries if not entry.name.endswith(REFERENCE_ENDING)))

    @property
    def follows(self) -> Layout:
        """The signals whose references are inputs of the system; with `error`, also every signal that it reads."""
        inputs = self.system.inputs
        followed = {
            name.removesuffix(REFERENCE_ENDING): inputs[name]
            for name in inputs.names
            if name.endswith(REFERENCE_ENDING)
        }
        followed |= {entry.name: entry for entry in self.reads.entries if self.error}
        return Layout(tuple(replace(entry, name=name) for name, entry in followed.items()))

    @property
    def drives(self) -> Layout:
        """The outputs of the system."""
        return self.system.outputs

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        """The commands u = u0 + C z + D v."""
        del t
        u = self.system.output_column(self.memory.flatten(z), self._inputs(est, ref))
        return Signals(self.drives.view(u if self.u0 is None else self.u0 + u))

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """A z + B v: the time derivative of each state, or its value at the next instant of a discrete system."""
        del t
        return self.system.dynamics(self.memory.flatten(z), self._inputs(est, ref))

    update = rate

    def run_every(self, period: float) -> LinearLaw:
        """A copy of the law that a computer runs once in every `period` seconds.

        A law in discrete time runs only with the period of its system; any other is refused by a ValueError.
        """
        if self.recursion and abs(period - float(self.system.dt or 0)) > 1e-6 * period:
            raise ValueError(
                f"`LinearLaw.run_every(period=...)` must be the period of a discrete law, {self.system.dt:g} s, for "
                f"which its matrices were made; got {period:g} s. Sample the continuous law anew by `wb.c2d`."
            )
        return AbstractController.run_every(self, period)

    def _inputs(self, est: Reads, ref: Follows) -> ca.SX:
        parts = {}
        for name in self.system.inputs.names:
            if name.endswith(REFERENCE_ENDING):
                parts[name] = ref[name.removesuffix(REFERENCE_ENDING)]
            else:
                parts[name] = ref[name] - est[name] if self.error else est[name]
        v = self.system.inputs.flatten(parts)
        return v if self.v0 is None else v - self.v0


def block_maker(block: Callable[..., object]) -> Callable[[object], object]:
    """A function that makes a block of a linear system, and returns any other value unchanged."""
    return lambda value: block(value) if LinearSystem.recognises(value) else value


def law_of_system(system: object) -> LinearLaw:
    """The law of a system that does not say if it is given y or the error: y, for which a loop checks its sign."""
    law = LinearLaw(LinearSystem.of(system))
    object.__setattr__(law, "stands", True)
    return law


def refuse_feedthrough(who: str, system: LinearSystem, names: tuple[str, ...], why: str) -> None:
    """Refuse a system that passes one of the inputs on at once."""
    columns = [place for name in names for place in system.inputs.indices(name)]
    if system.D is None:
        return
    odd = np.argwhere(system.D[:, columns])
    if len(odd):
        i, j = odd[0]
        raise ValueError(
            f"`{who}(system=...)` must not pass an input on at once, as {why}: its output '{system.outputs.labels[i]}' "
            f"follows its input '{system.inputs.labels[columns[j]]}' by D = {system.D[i, columns[j]]:g}. Add the lag "
            "of its actuator or its sensor."
        )
