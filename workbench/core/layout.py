"""Layout: where each named quantity lies in a flat vector, with its shape, unit, default and bounds."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core.expressions import refuse_misfit
from workbench.core.notation import mathml
from workbench.core.notation.formula import symbol
from workbench.core.numbers import Bounds
from workbench.core.units import checked_unit, unit_of_each
from workbench.core.validation.notebook_display import HtmlText, short_list, table_to_html
from workbench.core.validation.refusals import Array, as_array, describe, known_name, refusal
from workbench.core.validation.refusals import name as check_name
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True, eq=False)
@check_arguments
class Entry:
    """A quantity of a `Layout`; `symbol` is its letter in equations, and one that `is_derived` comes from a design."""

    name: str
    default: Array
    unit: str = ""
    bounds: Bounds = field(default_factory=Bounds)
    symbol: str = ""
    is_derived: bool = False

    def __post_init__(self) -> None:
        check_name("Entry(name=...)", self.name)
        if self.default.ndim > 2:
            raise refusal("Entry(default=...)", "a number, a vector or a matrix", self.default)
        unit = checked_unit(f"Entry({self.name}, unit=...)", self.unit)
        self.__setstate__({**self.__dict__, "default": self.default.copy(), "unit": unit})

    def __setstate__(self, state: Mapping[str, object]) -> None:
        self.__dict__.update(state)
        self.default.flags.writeable = False  # NumPy's copies of an array can be written to

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the quantity: () for a single number."""
        return tuple(self.default.shape)

    @property
    def size(self) -> int:
        """The number of entries of the quantity in the flat vector."""
        return int(self.default.size)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each entry; `unit` is one for all, or a list as "m, rad"."""
        return unit_of_each(self.unit, self.size)

    def labels(self) -> list[str]:
        """The names of the entries in the order of the flat vector, column by column, as `K[0,1]`."""
        if not self.shape:
            return [self.name]
        order = sorted(np.ndindex(self.shape), key=lambda index: index[::-1])
        return [f"{self.name}[{','.join(map(str, index))}]" for index in order]


@dataclass(frozen=True, eq=False)
@check_arguments
class Layout:
    """Named quantities (states, parameters or signals) and their places in a flat vector.

    `wb.layout(...)` makes one. Matrices are stored column by column, as in CasADi. Packed values are an array (B,
    size), one row for each of B runs. `a + b` is the layout of all quantities of a and b.

    Parameters
    ----------
    entries
        The quantities in order, with different names.

    Examples
    --------
    >>> port = wb.layout(q=("rad", [0.0, 0.1]), i="A")
    >>> port.labels, port.pack({"i": 2.0})
    (('q[0]', 'q[1]', 'i'), array([[0. , 0.1, 2. ]]))
    """

    entries: tuple[Entry, ...] = ()

    def __post_init__(self) -> None:
        twice = {name for name in self.names if self.names.count(name) > 1}
        if twice:
            raise ValueError(f"`Layout(...)` needs distinct names; {sorted(twice)} came more than once.")

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names in order."""
        return tuple(entry.name for entry in self.entries)

    @cached_property
    def size(self) -> int:
        """The length of the flat vector."""
        return sum(entry.size for entry in self.entries)

    @property
    def default(self) -> Array:
        """The flat vector (size,) of default values. It is read-only; `pack` makes a vector with other values."""
        vector = np.concatenate([entry.default.ravel(order="F") for entry in self.entries] or [np.zeros(0)])
        vector.flags.writeable = False
        return vector

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """The name of each number in the flat vector, as `plant.q[0]`."""
        return tuple(label for entry in self.entries for label in entry.labels())

    @cached_property
    def _slices(self) -> dict[str, slice]:
        ends = np.cumsum([entry.size for entry in self.entries], dtype=int)
        return {e.name: slice(int(end) - e.size, int(end)) for e, end in zip(self.entries, ends, strict=True)}

    def __add__(self, other: Layout) -> Layout:
        return Layout(self.entries + other.entries)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self._slices

    def __getitem__(self, name: str) -> Entry:
        return self.entries[self.names.index(self._known_name(name))]

    def __repr__(self) -> str:
        return f"<Layout {short_list([_short(entry) for entry in self.entries]) or 'without names'}>"

    def _repr_html_(self) -> str:
        rows = [(e.name, e.default.tolist(), e.unit, e.bounds) for e in self.entries]
        return table_to_html("Layout", ("name", "value", "unit", "bounds"), rows)

    def slice(self, name: str) -> slice:
        """The slice of a quantity in the flat vector."""
        return self._slices[self._known_name(name)]

    def _known_name(self, name: str) -> str:
        return known_name(name, self.names, "entries of this layout")

    @check_arguments
    def with_prefix(self, prefix: str) -> Layout:
        """A copy of the layout with `prefix` before each name."""
        return Layout(tuple(replace(entry, name=f"{prefix}{entry.name}") for entry in self.entries))

    def indices(self, name: str) -> list[int]:
        """The indices of a quantity, or of one of its numbers (`K[0,1]`), in the flat vector."""
        if not isinstance(name, str) or name in self._slices:
            place = self.slice(name)
            return list(range(place.start, place.stop))
        if name in self.labels:
            return [self.labels.index(name)]
        base = re.sub(r"\[[\d,]*\]$", "", name)
        raise LookupError(f"'{base}' has shape {self[base].shape}: there is no {describe(name)}.")

    def pack(self, values: Mapping[str, object] | None = None) -> Array:
        """Rows (B, size) with the given values, by name, and default values for all other quantities.

        A value has the shape of its quantity, or (B, ...) with one value for each of B runs. A name such as `K[0,1]`
        sets a single number.

        Raises
        ------
        LookupError
            If the layout has no such name; the message has the nearest one.
        ValueError
            If a value is not a number, has the wrong shape, is not finite or is out of bounds.
        """
        if not isinstance(values, Mapping | None):
            raise refusal("pack(values=...)", "a mapping from names to numbers, as a dict is", values)
        columns = {name: self._columns(name, value) for name, value in (values or {}).items()}
        runs = {len(c) for c in columns.values() if len(c) > 1}
        if len(runs) > 1:
            raise ValueError(f"`pack(...)` takes one number of runs; got columns of {sorted(runs)} runs.")
        rows = np.tile(self.default, (runs.pop() if runs else 1, 1))
        for name, column in columns.items():
            rows[:, self.indices(name)] = column
        self.check(rows)
        return rows

    def _columns(self, name: str, value: object) -> Array:
        self.indices(name)  # refuses an unknown name
        shape = self[name].shape if name in self._slices else ()
        array = as_array(value)
        if array is None:
            raise refusal(f"pack({name}=...)", "a number or an array", value)
        if array.shape == shape:
            array = array[np.newaxis]
        if array.shape[1:] != shape or len(array) == 0:
            raise ValueError(f"`pack({name}=...)` must have shape {shape}, or (B, ...) for B runs; got {array.shape}.")
        return array.T.reshape(-1, len(array)).T  # each row in Fortran's order

    def printed_names(self) -> dict[str, str]:
        """The letter of each number in printed equations, by its name: m_1 for `links[0].mass`, for example."""
        names = {}
        for entry in self.entries:
            symbol = entry.symbol or entry.name.rpartition(".")[2]
            for label in entry.labels():
                index = "".join(str(int(i) + 1) for i in label[len(entry.name) :].strip("[]").split(",") if i)
                names[label] = f"{symbol}{index}" if "_" in symbol or not index else f"{symbol}_{index}"
        return names

    @cached_property
    def _ends(self) -> tuple[Array, Array] | None:
        """The least and the largest number (size,) that is allowed; None where matrices must be symmetric."""
        if any(entry.bounds.symmetric for entry in self.entries):
            return None
        low, high = (
            np.repeat([e.bounds.ends[i] for e in self.entries], [e.size for e in self.entries]) for i in (0, 1)
        )
        return low, high

    @check_arguments
    def check(self, rows: Array) -> None:
        """Raise a ValueError if a number in rows (B, size) is not finite or out of its bounds."""
        if rows.ndim != 2 or rows.shape[1] != self.size:
            raise ValueError(f"`check(rows)` takes rows (B, {self.size}); got shape {rows.shape}.")
        ends = self._ends
        if not len(rows) or (ends and (rows.min(0) >= ends[0]).all() and (rows.max(0) <= ends[1]).all()):
            return  # at once: entry by entry takes as long as some runs
        for entry in self.entries:
            block = rows[:, self._slices[entry.name]]
            bad = np.argwhere(np.logical_not(entry.bounds.allow(block)))
            if len(bad):
                run, place = bad[0]
                where = f" in run {run}" if len(rows) > 1 else ""
                raise ValueError(
                    f"'{entry.labels()[place]}' must be {entry.bounds}"
                    f"{f' [{entry.unit}]' if entry.unit else ''}; got {block[run, place]:g}{where}."
                )
            if entry.bounds.symmetric:
                entry.bounds.refuse_unsymmetric(entry.name, _unflatten(block, entry.shape))

    @check_arguments
    def unpack(self, rows: Array) -> dict[str, Array]:
        """The values by name, each of shape (..., *shape), from flat vectors (..., size)."""
        if rows.shape[-1:] != (self.size,):
            raise ValueError(f"`unpack(rows)` takes vectors of {self.size} numbers; got shape {rows.shape}.")
        return {e.name: _unflatten(rows[..., self._slices[e.name]], e.shape) for e in self.entries}

    def symbols(self) -> ca.SX:
        """A column (size, 1) of CasADi symbols, one for each number, named by its label."""
        return ca.vertcat(*[ca.SX.sym(label) for label in self.labels]) if self.size else ca.SX(0, 1)

    def view(self, vector: ca.SX) -> dict[str, ca.SX]:
        """The parts of a CasADi vector (size, 1) by name, each in the shape of its quantity."""
        if not isinstance(vector, ca.SX | ca.DM):
            raise refusal("Layout.view(vector=...)", "an `SX`", vector)
        refuse_misfit("Layout.view", "vector", vector, self.size, 1, "one number for each label")
        parts = {}
        for entry in self.entries:
            part = vector[self._slices[entry.name], 0]
            parts[entry.name] = ca.reshape(part, *entry.shape) if len(entry.shape) == 2 else part
        return parts

    @check_arguments
    def flatten(self, parts: Mapping[str, ca.SX]) -> ca.SX:
        """The CasADi vector (size, 1) of all quantities, given by name in their shapes: the inverse of `view`."""
        if odd := set(parts) ^ set(self.names):
            raise LookupError(f"`flatten(parts)` needs exactly {list(self.names)}; differs in {sorted(odd)}.")
        columns = []
        for entry in self.entries:
            part = parts[entry.name]
            want = (entry.shape + (1, 1))[:2]
            if part.shape != want:
                raise ValueError(f"'{entry.name}' must have shape {want}; got {part.shape}.")
            columns.append(ca.vec(ca.densify(part)))
        return ca.vertcat(*columns) if columns else ca.SX(0, 1)


def _short(entry: Entry) -> str:
    size = f" x {entry.size}" if entry.shape else ""
    return f"{entry.name}{f' [{entry.unit}]' if entry.unit else ''}{size}"


def _unflatten(columns: Array, shape: tuple[int, ...]) -> Array:
    """The last axis, laid column by column, back into `shape`."""
    parts = columns.reshape(columns.shape[:-1] + shape[::-1])
    return np.swapaxes(parts, -1, -2) if len(shape) == 2 else parts


def layouts_to_html(title: str, layouts: Mapping[str, Layout]) -> str:
    """One table of names, letters, values and units for each layout."""
    rows = [
        (kind, entry.name, letters(entry.symbol or entry.name.rpartition(".")[2]), entry.default.tolist(), entry.unit)
        for kind, layout in layouts.items()
        for entry in layout.entries
    ]
    return table_to_html(title, ("kind", "name", "letter", "value", "unit"), rows)


def letters(name: str) -> HtmlText:
    """A name of the code as the book's letter, in MathML within a line."""
    return HtmlText(mathml.emit(symbol(name), display=False))
