"""Shapes of expressions, declared where their types are: one number, one for each joint, or all signals of a port.

An axis is named as a `parameter` names it; in one call it has one size, which a block's `dof` or its own numbers say.
"""

from __future__ import annotations

import re
import types
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from operator import attrgetter
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import casadi as ca

Number = Annotated[ca.SX, "1"]
Column = Annotated[ca.SX, "n"]
Memory = Annotated[Mapping[str, ca.SX], "memory"]
States = Annotated[Mapping[str, ca.SX], "states"]
PORTS = {  # of a block, each a layout
    "memory": "the whole memory",
    "states": "all states",
    "reads": "all that the block reads",
    "follows": "all that the law follows",
    "inputs": "all inputs",
}
AXIS = re.compile(r"(\d*)([a-z]*)")

# The name of an argument, how a message calls its part, how the part is taken of it, and the axis of that.
Part = tuple[str, str, Callable[[Any], Any], str]


def parts_of(name: str, hint: Any) -> list[Part]:
    """The parts of an argument that have a declared shape: itself, or the fields of a named tuple."""
    own = [(name, name, lambda value: value, axis) for axis in _axes(hint)]
    named = get_type_hints(hint, include_extras=True) if hasattr(hint, "_fields") else {}
    return own + [(name, f"{name}.{f}", attrgetter(f), axis) for f, kind in named.items() for axis in _axes(kind)]


def refuse_misshapen(call: str, owner: object, parts: list[Part], given: Mapping[str, Any]) -> None:
    """Refuse arguments of a call whose parts have other shapes than they declare.

    Raises
    ------
    ValueError
        If a part has another number of entries, or is no column.
    LookupError
        If a signal of a port, or a part of the memory, is missing.
    """
    sizes = _sizes(owner)
    for name, words, part_of, axis in sorted(parts, key=lambda part: part[3] in PORTS):
        value = part_of(given[name]) if name in given else None
        if value is None:
            continue
        if axis in PORTS:
            _refuse_part(f"{call}({words}=...)", axis, getattr(owner, axis, None), value, sizes)
            continue
        times, letter = AXIS.fullmatch(axis).groups()  # type: ignore[union-attr]
        size = int(times or 1) * (sizes.setdefault(letter, value.shape[0]) if letter else 1)
        if value.shape != (size, 1):
            why = f", one number for each of {letter} = {sizes[letter]}" if letter else ""
            raise ValueError(f"`{call}({words}=...)` must have shape ({size}, 1){why}; got {value.shape}.")


def _refuse_part(call: str, of: str, port: Any, value: Mapping[str, ca.SX], sizes: Mapping[str, int]) -> None:
    if callable(port):
        port = port(sizes.get("n", 0))
    for entry in port.entries if port is not None else ():
        if entry.name not in value:
            raise LookupError(f"`{call}` must hold {PORTS[of]}, {', '.join(port.names)}; got no '{entry.name}'.")
        want = (entry.shape + (1, 1))[:2]
        if ca.SX(value[entry.name]).shape != want:
            got = ca.SX(value[entry.name]).shape
            raise ValueError(f"`{call}` must hold '{entry.name}' in shape {want}; got {got}.")


def _axes(hint: Any) -> list[str]:
    options = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    return [kind.__metadata__[0] for kind in options if get_origin(kind) is Annotated]


def _sizes(owner: object) -> dict[str, int]:
    """How long the axes are that a block's number of joints, or its own numbers, tell."""
    sizes: dict[str, int] = {}
    for field in fields(owner) if is_dataclass(owner) else ():
        value, quantity = getattr(owner, field.name), field.metadata.get("quantity")
        if quantity is not None and value is not None:
            sizes |= {axis: value.shape[i] for i, axis in enumerate(quantity.shape) if axis.isalpha()}
    return sizes | ({"n": owner.dof} if hasattr(owner, "dof") else {})
