"""A linear system as an observer, by its matrices."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from workbench.blocks.loop.contracts import AbstractObserver, AbstractPlant, Inputs, Parts, Reads
from workbench.blocks.loop.linear_blocks import AbstractLinear, refuse_feedthrough
from workbench.core import Layout, LinearSystem, Signals, block
from workbench.core.block import Number, socket
from workbench.core.validation.refusals import known_name


@block
class LinearFilter(AbstractLinear, AbstractObserver):
    """A linear system as an observer, in continuous time, or in discrete time where it has a period:

        z' = A z + B [y; u]    or    z+ = A z + B [y; u],              estimates = C z + D [y; u].

    `system` may be a `StateSpace` or `TransferFunction` of python-control whose inputs and outputs have names: an input
    of the name of an output of the plant reads that, and its outputs are estimates. `counts_on` names the inputs that
    are commands; in a loop, unless told, those that are inputs of the plant.

    Raises
    ------
    ValueError
        If `LinearSystem.of` refuses the system, or an estimate follows a command at once (D): an estimate never sees
        the command of the same instant.
    LookupError
        If a command is no input of the system.

    Examples
    --------
    >>> import control
    >>> from workbench.blocks.loop import LinearFilter
    >>> LinearFilter(control.ss(-1.0, 1.0, 2.0, 0.0, inputs="v", outputs="omega"), ("v",)).memory.names
    ('x',)
    """

    system: LinearSystem = socket(LinearSystem.of)
    counts_on: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in self.counts_on:
            known_name(name, self.system.inputs.names, "inputs of the system")
        why = "an estimate never sees the command of the same instant"
        refuse_feedthrough("LinearFilter", self.system, self.counts_on, why)
        object.__setattr__(self, "period", self.system.dt)

    @property
    def reads(self) -> Layout:
        """The inputs of the system, but for commands."""
        return Layout(tuple(e for e in self.system.inputs.entries if e.name not in self.counts_on))

    @property
    def inputs(self) -> Layout:
        """The inputs of the system that are commands."""
        return Layout(tuple(e for e in self.system.inputs.entries if e.name in self.counts_on))

    @property
    def gives(self) -> Layout:
        """The outputs of the system."""
        return self.system.outputs

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        """C z + D [y; 0]."""
        del t
        u = {entry.name: ca.SX.zeros(entry.size) for entry in self.inputs.entries}
        inputs = self.system.inputs.flatten(dict(y) | u)
        return Signals(self.gives.view(self.system.output_column(self.memory.flatten(z), inputs)))

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """A z + B [y; u]."""
        del t, est
        return self.system.dynamics(self.memory.flatten(z), self.system.inputs.flatten(dict(y) | dict(u)))

    update = rate


def observer_of_system(plant: AbstractPlant, observer: AbstractObserver) -> AbstractObserver:
    """The observer; a linear system reads the commands of all its inputs that are inputs of the plant."""
    if not isinstance(observer, LinearFilter) or observer.counts_on:
        return observer
    return replace(observer, counts_on=tuple(n for n in observer.system.inputs.names if n in plant.inputs))
