"""Linear systems: four matrices whose states, inputs and outputs have names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING, Annotated, Protocol

import casadi as ca
import numpy as np

from workbench.core.block import Matrix, Vector, block, parameter
from workbench.core.layout import Entry, Layout
from workbench.core.point import OperatingPoint
from workbench.core.units import ANY
from workbench.core.validation.notebook_display import short_list
from workbench.core.validation.refusals import Array, known_name, refusal, seconds, vector

if TYPE_CHECKING:
    from typing_extensions import TypeIs

States = Annotated[ca.SX, "nx"]
Inputs = Annotated[ca.SX, "nu"]
MADE_UP = re.compile(r"[uy]\[\d+\]")  # python-control's names of inputs and outputs that were given none


class ForeignSystem(Protocol):
    """A system of python-control: its name, the labels of its inputs and outputs, and its period."""

    name: str
    dt: float | bool | None
    input_labels: list[str]
    output_labels: list[str]


class StateSpace(ForeignSystem, Protocol):
    """A system of python-control by its matrices."""

    A: Array
    B: Array
    C: Array
    D: Array
    state_labels: list[str]

    def update_names(self, *, inputs: list[str], outputs: list[str]) -> None:
        """Rename inputs and outputs."""


class TransferFunction(ForeignSystem, Protocol):
    """A matrix of fractions of python-control, by their coefficients from the highest power on."""

    ninputs: int
    noutputs: int
    num_list: list[list[Array]]
    den_list: list[list[Array]]

    def issiso(self) -> bool:
        """True if one input and one output are all."""

    def to_ss(self) -> StateSpace:
        """A realisation by matrices."""


@block
class LinearSystem:
    """A linear system in continuous time, or in steps of dt [s] where that is given:

        x' = A x + B u    or    x+ = A x + B u,              y = C x + D u

    and, where it has a point (x0, u0, y0), with x - x0, x+ - x0, u - u0 and y - y0 in the places of x, x+, u and y.

    A is (nx, nx), B (nx, nu), C (ny, nx) and D (ny, nu). A system without states has D alone, and one that has no D
    passes no input on at once. `states` has their names, their units and where they start.
    """

    noun = ""  # it is called what the block is called that holds it
    states: Layout
    inputs: Layout
    outputs: Layout
    A: Matrix = parameter(default=None, unit=ANY, shape=("nx", "nx"))
    B: Matrix = parameter(default=None, unit=ANY, shape=("nx", "nu"))
    C: Matrix = parameter(default=None, unit=ANY, shape=("ny", "nx"), symbol="C_y")
    D: Matrix = parameter(default=None, unit=ANY, shape=("ny", "nu"))
    dt: float | None = None
    x0: Vector = parameter(default=None, unit=ANY, shape=("nx",), symbol="x_0")
    u0: Vector = parameter(default=None, unit=ANY, shape=("nu",), symbol="u_0")
    y0: Vector = parameter(default=None, unit=ANY, shape=("ny",), symbol="y_0")

    def __post_init__(self) -> None:
        if self.dt is not None:
            seconds("LinearSystem(dt=...)", self.dt)
        nx, nu, ny = self.states.size, self.inputs.size, self.outputs.size
        for letter, shape in {"A": (nx, nx), "B": (nx, nu), "C": (ny, nx), "D": (ny, nu)}.items():
            matrix = getattr(self, letter)
            if (matrix is None and nx and letter != "D") or (matrix is not None and matrix.shape != shape):
                got = "None" if matrix is None else f"shape {matrix.shape}"
                raise ValueError(
                    f"`LinearSystem({letter}=...)` must have shape {shape}, for {nx} states, {nu} inputs and {ny} "
                    f"outputs; got {got}."
                )
        for name, port in (("x0", self.states), ("u0", self.inputs), ("y0", self.outputs)):
            if getattr(self, name) is not None:
                vector(f"LinearSystem({name}=...)", getattr(self, name), port.size, f"numbers {', '.join(port.labels)}")

    def __repr__(self) -> str:
        ways = " to ".join(short_list(port.names) for port in (self.inputs, self.outputs))
        period = "" if self.dt is None else f", every {self.dt:g} s"
        return f"<LinearSystem from {ways}: {self.states.size} states{period}>"

    @staticmethod
    def of(
        system: object,
        *,
        inputs: str | Sequence[str] | None = None,
        outputs: str | Sequence[str] | None = None,
        units: Mapping[str, str] | None = None,
        dt: float | None = None,
    ) -> LinearSystem:
        """A `StateSpace` or a `TransferFunction` of python-control, with its names and its matrices bit by bit.

        The point and the units of a linearised system are kept, and those of a law designed from one. Labels that count
        from zero, as q[0] and q[1], become one quantity q of that shape.

        Parameters
        ----------
        inputs, outputs
            Names, one for each number, in the place of the system's own.
        units
            The units of states, inputs and outputs, by name; one that is not named has that of the point, or fits any.
        dt
            The period in s of a discrete system that python-control was told none of (`dt=True`).

        Raises
        ------
        ValueError
            If it is no such system, is improper, not finite, lacks a name or a period, or was linearised where it does
            not rest.
        LookupError
            If a unit is given to a name that the system has not.
        """
        if isinstance(system, LinearSystem):
            return system
        given = _foreign(system)
        space, point = _state_space(given), _rest_point(given)
        labels = {
            "inputs": _labels("inputs", inputs, space.input_labels, given),
            "outputs": _labels("outputs", outputs, space.output_labels, given),
            "states": list(space.state_labels),
        }
        known_units = {port: _units(getattr(point, port)) if point else {} for port in labels}
        ports = {port: _in_units(layout_of(own), known_units[port] | dict(units or {})) for port, own in labels.items()}
        for name in units or {}:
            known_name(name, [n for port in ports.values() for n in port.names], "states, inputs and outputs")
        matrices = {letter: np.asarray(getattr(space, letter), dtype=float) for letter in "ABCD"}
        parts = {letter: m for letter, m in matrices.items() if letter == "D" or ports["states"].size}
        own = {name: getattr(point, name) for name in ("x0", "u0", "y0") if point is not None}
        # a point at zero adds no numbers to the equations; states of a transfer function have no point
        offsets = {name: value for name, value in own.items() if np.any(value)}
        states, inner, outer = (ports[port] for port in ("states", "inputs", "outputs"))
        return LinearSystem(states, inner, outer, **parts, **offsets, dt=_period(given, dt))

    @staticmethod
    def recognises(value: object) -> bool:
        """True for a linear system of any kind: this one, or one of python-control."""
        return isinstance(value, LinearSystem) or _is_foreign(value)

    def dynamics(self, x: States, u: Inputs) -> dict[str, ca.SX]:
        """A x + B u about the point for columns x and u, by the names of the states."""
        if not self.states.size:
            return {}
        moved = self.A @ _less(x, self.x0) + self.B @ _less(u, self.u0)
        return self.states.view(moved if self.x0 is None or self.dt is None else self.x0 + moved)

    def output_column(self, x: States, u: Inputs) -> ca.SX:
        """C x + D u about the point for columns x and u, as a column."""
        columns = ((self.C, x, self.x0), (self.D, u, self.u0))
        parts = [gain @ _less(column, at) for gain, column, at in columns if gain is not None]
        shown = sum(parts, ca.SX.zeros(self.outputs.size))
        return shown if self.y0 is None else self.y0 + shown


def _less(column: ca.SX, at: Array | ca.SX | None) -> ca.SX:
    return column if at is None else column - at


def _rest_point(system: ForeignSystem) -> OperatingPoint | None:
    """The point of a system; one at which it does not rest is refused."""
    point = getattr(system, "point", None)
    if not isinstance(point, OperatingPoint):
        return None
    if point.moving_state:
        raise ValueError(
            "`LinearSystem.of(system)` must be linear about a rest point, as it has no constant rate: "
            f"{point.moving_state} where '{system.name}' was linearised. Linearise at a point of `operating_point` or "
            "`equilibria`, or take `control.ss(system)`, which forgets the point."
        )
    return point


def _units(port: Layout) -> dict[str, str]:
    return {entry.name: entry.unit for entry in port.entries}


def layout_of(labels: Sequence[str]) -> Layout:
    """The layout that has these labels in this order, in which q[0] and q[1] are one quantity q."""
    entries: list[Entry] = []
    for base, group in groupby(labels, lambda label: label.partition("[")[0]):
        own = list(group)
        last = re.fullmatch(r"\[(\d+)(?:,(\d+))?\]", own[-1].removeprefix(base))
        shape = tuple(int(place) + 1 for place in last.groups() if place is not None) if last else ()
        whole = Entry(base, np.zeros(shape)) if last and np.prod(shape) == len(own) else None
        if whole is not None and whole.labels() == own:
            entries.append(whole)
        else:
            entries += [Entry(label, np.zeros(())) for label in own]
    return Layout(tuple(entries))


def _foreign(system: object) -> StateSpace | TransferFunction:
    """A system of python-control, or a refusal."""
    if not _is_foreign(system):
        raise refusal("LinearSystem.of(system=...)", "a `StateSpace` or a `TransferFunction` of python-control", system)
    return system


def _is_foreign(value: object) -> TypeIs[StateSpace | TransferFunction]:
    return all(hasattr(value, name) for name in ("A", "B", "C", "D", "dt", "state_labels")) or _is_transfer(value)


def _is_transfer(value: object) -> TypeIs[TransferFunction]:
    return all(hasattr(value, name) for name in ("num_list", "den_list", "to_ss", "dt"))


def _state_space(system: StateSpace | TransferFunction) -> StateSpace:
    """A system by its matrices; a transfer function becomes one by python-control's own realisation."""
    if not _is_transfer(system):
        return system
    for i, (row, below) in enumerate(zip(system.num_list, system.den_list, strict=True)):
        for j, (num, den) in enumerate(zip(row, below, strict=True)):
            entry = f"'{system.name}' from '{system.input_labels[j]}' to '{system.output_labels[i]}'"
            _refuse_odd_fraction(entry, num, den)
    if not system.issiso():
        raise ValueError(
            f"`LinearSystem.of(system)`: the transfer function '{system.name}' has {system.ninputs} inputs and "
            f"{system.noutputs} outputs, and the states of such a matrix of fractions are not unique: give a "
            "`StateSpace`, as `control.append` and `control.interconnect` make one of its entries."
        )
    space = system.to_ss()
    space.update_names(inputs=system.input_labels, outputs=system.output_labels)
    return space


def _refuse_odd_fraction(entry: str, num: Array, den: Array) -> None:
    if not (np.isfinite(num).all() and np.isfinite(den).all()):
        raise ValueError(f"`LinearSystem.of(system)` must have finite coefficients; {entry} has not.")
    degrees = [len(np.trim_zeros(np.atleast_1d(part), "f")) - 1 for part in (num, den)]
    if degrees[0] > degrees[1]:
        raise ValueError(
            f"`LinearSystem.of(system)` must be proper, as it would differentiate its input otherwise: {entry} "
            f"has a numerator of degree {degrees[0]} over a denominator of degree {degrees[1]}; add fast poles."
        )


def _labels(port: str, labels: str | Sequence[str] | None, own: Iterable[str], system: ForeignSystem) -> list[str]:
    """The names that were given, or the system's own; names made up by python-control are refused."""
    names = list(own)
    if labels is not None:
        chosen = [labels] if isinstance(labels, str) else list(labels)
        if len(chosen) != len(names):
            raise refusal(f"LinearSystem.of({port}=...)", f"{len(names)} names, one a number", labels)
        return chosen
    for name in names:
        if MADE_UP.fullmatch(name):
            raise ValueError(
                f"`LinearSystem.of(system)` must have names, by which a loop is closed: '{name}' of '{system.name}' is "
                f"python-control's own. Give {port}=[...] here, or to python-control."
            )
    return names


def _in_units(port: Layout, units: Mapping[str, str]) -> Layout:
    return Layout(tuple(replace(entry, unit=units.get(entry.name, ANY)) for entry in port.entries))


def _period(system: ForeignSystem, dt: float | None) -> float | None:
    if system.dt is True:
        if dt is None:
            must = f"the period in s of '{system.name}', a discrete system that says none (`dt=True`)"
            raise refusal("LinearSystem.of(dt=...)", must, None)
        return seconds("LinearSystem.of(dt=...)", dt)
    own = float(system.dt) if system.dt else None
    if dt is not None and dt != own:
        raise ValueError(
            f"`LinearSystem.of(dt=...)` is for a discrete system that says no period; '{system.name}' "
            f"{'is continuous' if own is None else f'has {own:g} s'}: sample it by `wb.c2d(system, dt)`; got "
            f"{dt!r}."
        )
    return own
