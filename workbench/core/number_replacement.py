"""Other numbers in a block or in equations, by their paths."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import TypeVar

import numpy as np

from workbench.core.block import is_block
from workbench.core.layout import Layout
from workbench.core.ode import Ode
from workbench.core.symbolic_twin import lift
from workbench.core.validation.refusals import Array, finite, nearest, refusal
from workbench.core.validation.signatures import check_arguments

T = TypeVar("T")


@check_arguments
def replace_numbers(target: T, values: Mapping[str, float]) -> T:
    """A copy of a block or an `Ode` with other numbers; a path such as `plant.J` or `K[0,1]` names a single number.

    Raises
    ------
    ValueError
        If `target` is neither, or a number is not finite or out of its bounds.
    LookupError
        If a path is not that of a parameter.

    Examples
    --------
    >>> from workbench.core.number_replacement import replace_numbers
    >>> replace_numbers(wb.DCMotor(), {"J": 0.02}).J
    0.02
    """
    if isinstance(target, Ode):
        known: Layout = target.parameters
    elif is_block(target):
        known = lift(target).layout
    else:
        raise refusal("replace_numbers(target=...)", "a block or an `Ode`", target)
    for path, value in values.items():
        finite(f"replace_numbers(values={{{path!r}: ...}})", value)
        if path not in known.labels:
            raise LookupError(
                f"There is no '{path}' among the {known.size} parameters of this {type(target).__name__}."
                f"{nearest(path, known.labels)}"
            )
    return _replaced(target, "", values)


@check_arguments
def replace_initial_states(target: T, values: Mapping[str, float]) -> T:
    """A copy of a block or an `Ode` that begins in other states; a path such as `plant.omega` or `q[0]` names one.

    Raises
    ------
    ValueError
        If `target` is neither, or a number is not finite.
    LookupError
        If a path is not that of a state, or a block declares no field for it.

    Examples
    --------
    >>> from workbench.core.number_replacement import replace_initial_states
    >>> replace_initial_states(wb.open_loop(wb.DCMotor()), {"omega": 3.0}).states.default
    array([3., 0.])
    """
    for path, value in values.items():
        finite(f"replace_initial_states(values={{{path!r}: ...}})", value)
    if isinstance(target, Ode):
        for path in values:
            target.states.indices(path)  # refuses a name that is none
        return replace(target, states=_with_defaults(target.states, "", values))
    if not is_block(target):
        raise refusal("replace_initial_states(target=...)", "a block or an `Ode`", target)
    parameters = lift(target).layout.labels
    for path, value in values.items():
        if path in parameters or _replaced(target, "", {path: value}) is target:
            raise LookupError(
                f"`{type(target).__name__}` has no field for an initial state '{path}': give the state to the run, "
                "`wb.simulate(..., x0=...)`."
            )
    return _replaced(target, "", values)


def _replaced(part: T, path: str, values: Mapping[str, float]) -> T:
    """The part at a path, which ends with a dot if it is not empty, with the values of its own paths."""
    own = {name: value for name, value in values.items() if name.startswith(path)}
    if not own:
        return part
    if isinstance(part, Ode):
        return replace(part, parameters=_with_defaults(part.parameters, path, own))
    changes: dict[str, object] = {}
    for f in fields(part):  # type: ignore[arg-type]
        value, name = getattr(part, f.name), f"{path}{f.name}"
        if "quantity" in f.metadata and value is not None:
            array = _entries(name, np.array(value, dtype=float), own)
            if array is not None:
                changes[f.name] = array if array.ndim else float(array)
        elif isinstance(value, Ode):
            changes[f.name] = _replaced(value, path, own)  # its parameters are those of the block
        elif is_block(value):
            changes[f.name] = _replaced(value, f"{name}.", own)
        elif isinstance(value, tuple) and any(map(is_block, value)):
            changes[f.name] = tuple(_replaced(v, f"{name}[{i}].", own) for i, v in enumerate(value))
    return replace(part, **changes) if changes else part  # type: ignore[type-var]


def _with_defaults(layout: Layout, path: str, values: Mapping[str, float]) -> Layout:
    """A layout with other default values, by paths."""
    entries = []
    for entry in layout.entries:
        array = _entries(f"{path}{entry.name}", np.array(entry.default), values)
        entries.append(entry if array is None else replace(entry, default=array))
    new = Layout(tuple(entries))
    new.check(new.default[np.newaxis])
    return new


def _entries(name: str, array: Array, values: Mapping[str, float]) -> Array | None:
    """A copy of the array of a quantity with the values of its entries; None if there are none."""
    pattern = re.compile(rf"{re.escape(name)}(?:\[([\d,]+)\])?")
    places = {path: match for path in values if (match := pattern.fullmatch(path))}
    for path, match in places.items():
        index = tuple(map(int, match[1].split(","))) if match[1] else ()
        array[index] = values[path]
    return array if places else None
