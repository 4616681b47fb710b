"""Ports: what a block reads, gives and drives, as layouts, and what makes one of them fit another."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from workbench.core.layout import Entry, Layout
from workbench.core.signals import Signals
from workbench.validation.doors import door
from workbench.validation.words import as_text, described, nearest, numbers, refusal

ANY = "?"  # the unit of a signal whose block was told none, as a system of python-control is
METHODS = {name for name in dir(Signals) if not name.startswith("_")}  # of which `y.name` is none of the signals


@door
def layout(**signals: Any) -> Layout:
    """A port or a memory: a unit for each name, or a unit and the number or numbers at the start, zero else.

    `layout(omega="rad/s", v=("V", 12.0), q=("rad", [0, 0]))` has two signals of one number and one of two.

    Raises
    ------
    ValueError
        If what comes for a name is neither, or a name is that of a method of `Signals`.

    Examples
    --------
    >>> port = wb.layout(omega="rad/s", v=("V", 12.0), q=("rad", [0.0, 0.0]))
    >>> port.names, port["omega"].unit, port["q"].shape
    (('omega', 'v', 'q'), 'rad/s', (2,))
    """
    return Layout(tuple(_entry(name, value) for name, value in signals.items()))


def _entry(name: str, value: Any) -> Entry:
    call = f"layout({name}=...)"
    if name in METHODS:
        raise ValueError(f"`{call}` must have another name, as `{name}` is a method of the `Signals` that hold it.")
    if (unit := as_text(value)) is not None:
        return Entry(name, np.array(0.0), unit)
    if isinstance(value, tuple) and len(value) == 2 and (unit := as_text(value[0])) is not None:
        return Entry(name, numbers(call, value[1]), unit)
    raise refusal(call, "a unit, as 'rad/s' is, or a unit and the numbers at the start", value)


def joined(port: Layout, name: str) -> Entry:
    """All signals of a port as one column, which keeps the unit of each number."""
    units = [unit for entry in port.entries for unit in entry.units]
    return Entry(name, np.zeros(port.size), units[0] if len(set(units)) == 1 else ", ".join(units))


def misfits(wanted: Layout, offered: Layout) -> list[str]:
    """What keeps an offered port from serving a wanted one, a clause for each signal; more may be offered.

    In a clause '{gives}' stands for the block that offers and its verb.
    """
    clauses = []
    for entry in wanted.entries:
        if entry.name not in offered:
            held = ", ".join(map(repr, offered.names)) or "none"
            clauses.append(
                f"'{entry.name}', where {{gives}} {held}{nearest(entry.name, offered.names).replace(' Did', '; did')}"
            )
            continue
        other = offered[entry.name]
        if entry.size != other.size:
            clauses.append(f"'{entry.name}' as {_size(entry)}, where {{gives}} it as {_size(other)}")
        elif any(a != b and ANY not in (a, b) for a, b in zip(entry.units, other.units, strict=True)):
            clauses.append(f"'{entry.name}' in {_unit(entry)}, where {{gives}} it in {_unit(other)}")
    return clauses


def _size(entry: Entry) -> str:
    return "one number" if entry.size == 1 else f"{entry.size} numbers"


def _unit(entry: Entry) -> str:
    return f"[{entry.unit or '1'}]"


def fitting(call: str, port: Layout, parts: object) -> Signals:
    """What a block of the user's own returns for a port: every name of it, each in its shape, and no other name.

    A number stands for a signal of one number; nothing is spread over several.

    Raises
    ------
    ValueError
        If it is no mapping, if a name is missing or is none of the port's, or if a part has another shape.
    """
    must = f"return {_listed(port)}"
    if not isinstance(parts, Mapping):
        raise ValueError(f"`{call}` must {must}; it returned {described(parts)}.")
    for name in port.names:
        if name not in parts:
            held = ", ".join(map(repr, parts)) or "an empty mapping"
            raise ValueError(f"`{call}` must {must}; it returned {held}, without '{name}'.")
    for name in parts:
        if name not in port:
            raise ValueError(
                f"`{call}` must {must}, and no more; it returned {described(name)} too.{nearest(name, port.names)}"
            )
    return Signals({entry.name: column(call, entry.name, entry.shape, parts[entry.name]) for entry in port.entries})


def column(call: str, name: str, shape: tuple[int, ...], value: Any) -> ca.SX:
    """An expression of the shape of a signal, or a refusal that says what a method returned."""
    want = (shape + (1, 1))[:2]
    try:
        part: ca.SX = ca.SX(value)
    except Exception:
        raise ValueError(
            f"`{call}` must return '{name}' as an expression of shape {want}; it returned {described(value)}."
        ) from None
    if part.shape != want:
        raise ValueError(f"`{call}` must return '{name}' in shape {want}; it returned shape {part.shape}.")
    return part


def _listed(port: Layout) -> str:
    names = [f"'{e.name}'" if e.size == 1 else f"'{e.name}' {(e.shape + (1, 1))[:2]}" for e in port.entries]
    return ", ".join(names) or "an empty mapping"
