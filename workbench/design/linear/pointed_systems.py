"""Systems of python-control that carry their point. Import this file inside functions: python-control takes seconds."""

from __future__ import annotations

from typing import final

import control
import numpy as np

from workbench.core import Layout
from workbench.core.point import OperatingPoint
from workbench.core.validation.notebook_display import short_list, table_to_html
from workbench.core.validation.refusals import Array
from workbench.design.control_system import System


@final
class PointedSpace(control.StateSpace):  # type: ignore[misc]
    """A `StateSpace` about a `point`, of which x, u and y are the deviations.

    A system that is sampled from it, and one of some of its outputs and inputs, have the point too. What python-control
    computes otherwise is a plain `StateSpace` without it; `control.ss(system)` drops it.
    """

    point: OperatingPoint

    def __init__(self, system: control.StateSpace, point: OperatingPoint) -> None:
        names = {"states": system.state_labels, "inputs": system.input_labels, "outputs": system.output_labels}
        matrices = (system.A, system.B, system.C, system.D, system.dt)
        control.StateSpace.__init__(self, *matrices, name=system.name, remove_useless_states=False, **names)
        self.point = point

    @property
    def x0(self) -> Array:
        """The states (nx,) at the point."""
        return self.point.x0

    @property
    def u0(self) -> Array:
        """The inputs (nu,) at the point."""
        return self.point.u0

    @property
    def y0(self) -> Array:
        """The outputs (ny,) at the point."""
        return self.point.y0

    def __repr__(self) -> str:
        return _line("StateSpace", self)

    def _repr_html_(self) -> str:
        return _table("StateSpace", self)

    def sample(self, *arguments: object, **options: object) -> PointedSpace:
        """The system sampled as python-control does it, about the same point."""
        return PointedSpace(control.StateSpace.sample(self, *arguments, **options), self.point)

    def __getitem__(self, key: object) -> PointedSpace:
        """Some outputs and inputs, as python-control takes them, about the same point."""
        part = control.StateSpace.__getitem__(self, key)
        outputs = [self.output_labels.index(label) for label in part.output_labels]
        inputs = [self.input_labels.index(label) for label in part.input_labels]
        named = control.StateSpace(part, states=self.state_labels)  # whose names python-control leaves out
        return PointedSpace(named, self.point.part(outputs, inputs))


@final
class PointedTransfer(control.TransferFunction):  # type: ignore[misc]
    """A `TransferFunction` about a `point`, which one that is sampled from it has too."""

    point: OperatingPoint

    def __init__(self, system: control.TransferFunction, point: OperatingPoint) -> None:
        names = {"inputs": system.input_labels, "outputs": system.output_labels, "name": system.name}
        control.TransferFunction.__init__(self, system.num_list, system.den_list, system.dt, **names)
        self.point = point

    @property
    def u0(self) -> Array:
        """The inputs (nu,) at the point."""
        return self.point.u0

    @property
    def y0(self) -> Array:
        """The outputs (ny,) at the point."""
        return self.point.y0

    def __repr__(self) -> str:
        return _line("TransferFunction", self)

    def _repr_html_(self) -> str:
        return _table("TransferFunction", self)

    def sample(self, *arguments: object, **options: object) -> PointedTransfer:
        """The system sampled as python-control does it, about the same point."""
        return PointedTransfer(control.TransferFunction.sample(self, *arguments, **options), self.point)


def _line(kind: str, system: System) -> str:
    ways = " to ".join(short_list(names) for names in (system.input_labels, system.output_labels))
    return f"<{kind} '{system.name}' from {ways}, about {', '.join(_values(system.point.inputs, system.u0)[:3])}>"


def _table(kind: str, system: System) -> str:
    ports = {"state": (system.point.states, system.point.x0)}
    ports |= {"input": (system.point.inputs, system.u0), "output": (system.point.outputs, system.y0)}
    rows = [(name, value) for name, (port, at) in ports.items() for value in _values(port, at)]
    return table_to_html(f"{kind} {system.name}", ("signal", "at the point"), rows)


def _values(port: Layout, at: Array) -> list[str]:
    """Each number of a port with its value."""
    return [f"{label} = {value:.6g}" for label, value in zip(port.labels, at, strict=True)]


def point_of(system: System) -> OperatingPoint | None:
    """The point of a system, or None if it has none or another number of inputs, outputs or states by now."""
    point = getattr(system, "point", None)
    if not isinstance(point, OperatingPoint) or len(point.u0) != system.ninputs or len(point.y0) != system.noutputs:
        return None
    return point if np.shape(point.x0) in ((0,), (system.nstates,)) else None
