"""Lift: the twin of a block, with symbols in the place of its numbers, keyed by path."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Generic, TypeVar

import casadi as ca
import numpy as np

from workbench.core.block import is_block, unit_of_quantity
from workbench.core.layout import Entry, Layout
from workbench.core.numbers import Quantity
from workbench.core.port import Signals
from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import check_arguments

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
@check_arguments
class SymbolicTwin(Generic[T]):
    """A block whose parameters are symbols, and the place of each symbol in the parameter vector."""

    block: T
    layout: Layout
    symbols: ca.SX


@check_arguments
def lift(block: T, prefix: str = "") -> SymbolicTwin[T]:
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
    return SymbolicTwin(twin, layout, ca.vertcat(*symbols) if symbols else ca.SX(0, 1))


def _refuse_other(block: object) -> None:
    if not is_block(block):
        raise refusal("lift(block=...)", "a block, an instance of a class made by `@block`", block)


def _twin(block: T, path: str, index: str, entries: list[tuple[Entry, ca.SX]]) -> T:
    twin = object.__new__(type(block))
    for f in fields(block):  # type: ignore[arg-type]
        value = getattr(block, f.name)
        quantity: Quantity | None = f.metadata.get("quantity")
        if quantity is not None and quantity.is_symbolic and value is not None:
            entry = _entry(
                f"{path}{f.name}", value, quantity, unit_of_quantity(block, quantity), quantity.symbol or f.name, index
            )
            entries.append((entry, _symbol(entry)))
            value = entries[-1][1]
        elif "parameters" in f.metadata:
            named = [(entry, _symbol(entry)) for entry in value.with_prefix(path).entries]
            entries += named
            value = Signals({name: symbol for name, (_, symbol) in zip(value.names, named, strict=True)})
        else:
            value = _twin_of_field(value, f"{path}{f.name}", entries)
        object.__setattr__(twin, f.name, value)
    return twin


def _twin_of_field(value: object, path: str, entries: list[tuple[Entry, ca.SX]]) -> object:
    if is_block(value):
        return _twin(value, f"{path}.", "", entries)
    if isinstance(value, tuple) and any(map(is_block, value)):
        return tuple(_twin(v, f"{path}[{i}].", str(i + 1), entries) for i, v in enumerate(value))
    return value


def _entry(name: str, value: Array | float, quantity: Quantity, unit: str, symbol: str, index: str) -> Entry:
    printed = f"{symbol}_{index}" if index and "_" not in symbol else f"{symbol}{index}"
    return Entry(name, np.asarray(value, dtype=float), unit, quantity.bounds, printed, quantity.is_derived)


def _symbol(entry: Entry) -> ca.SX:
    column = ca.vertcat(*[ca.SX.sym(label) for label in entry.labels()])
    return ca.reshape(column, *(entry.shape + (1, 1))[:2])
