"""Lift: the twin of a block, with symbols in the place of its numbers, keyed by path."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Generic, TypeVar

import casadi as ca
import numpy as np

from workbench.core.block import Quantity, is_block, unit_of_quantity
from workbench.core.layout import Entry, Layout
from workbench.core.port import Signals
from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import door

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
@door
class Lifted(Generic[T]):
    """A block whose parameters are symbols, and the place of each symbol in the parameter vector."""

    block: T
    layout: Layout
    symbols: ca.SX


@door
def lift(block: T, prefix: str = "") -> Lifted[T]:
    """The twin of `block`, of the same class, whose parameters are SX symbols keyed by path: `plant.arm.links[0].mass`.

    A block met twice (the arm that is simulated and the arm the designer believes in) gets two sets of symbols.

    Raises
    ------
    ValueError
        If `block` is no instance of a class made by `@block`.
    """
    _refuse_other(block)
    found: list[tuple[Entry, ca.SX]] = []
    twin = _twin(block, prefix, "", found)
    symbols = [ca.vec(symbol) for _, symbol in found]
    layout = Layout(tuple(entry for entry, _ in found))
    return Lifted(twin, layout, ca.vertcat(*symbols) if symbols else ca.SX(0, 1))


def _refuse_other(block: object) -> None:
    if not is_block(block):
        raise refusal("lift(block=...)", "a block, an instance of a class made by `@block`", block)


def _twin(block: T, path: str, index: str, found: list[tuple[Entry, ca.SX]]) -> T:
    twin = object.__new__(type(block))
    for f in fields(block):  # type: ignore[arg-type]
        value = getattr(block, f.name)
        quantity: Quantity | None = f.metadata.get("quantity")
        if quantity is not None and quantity.lifted and value is not None:
            entry = _entry(
                f"{path}{f.name}", value, quantity, unit_of_quantity(block, quantity), quantity.symbol or f.name, index
            )
            found.append((entry, _symbol(entry)))
            value = found[-1][1]
        elif "parameters" in f.metadata:
            named = [(entry, _symbol(entry)) for entry in value.prefixed(path).entries]
            found += named
            value = Signals({name: symbol for name, (_, symbol) in zip(value.names, named, strict=True)})
        else:
            value = _twin_of_field(value, f"{path}{f.name}", found)
        object.__setattr__(twin, f.name, value)
    return twin


def _twin_of_field(value: object, path: str, found: list[tuple[Entry, ca.SX]]) -> object:
    if is_block(value):
        return _twin(value, f"{path}.", "", found)
    if isinstance(value, tuple) and any(map(is_block, value)):
        return tuple(_twin(v, f"{path}[{i}].", str(i + 1), found) for i, v in enumerate(value))
    return value


def _entry(name: str, value: Array | float, quantity: Quantity, unit: str, symbol: str, index: str) -> Entry:
    printed = f"{symbol}_{index}" if index and "_" not in symbol else f"{symbol}{index}"
    return Entry(name, np.asarray(value, dtype=float), unit, quantity.bounds, printed)


def _symbol(entry: Entry) -> ca.SX:
    column = ca.vertcat(*[ca.SX.sym(label) for label in entry.labels()])
    return ca.reshape(column, *(entry.shape + (1, 1))[:2])
