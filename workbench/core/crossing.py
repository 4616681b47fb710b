"""Crossing: values that one part of an equation hands to the next as numbers, so that nothing is simplified across."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core.expressions import refuse_misfit, refuse_unknown
from workbench.core.layout import Entry, Layout
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True, eq=False)
@check_arguments
class Crossing:
    """Symbols of a later part of an equation, and the values that an earlier part hands over for them.

    The later part is written in the symbols, and each part is read and rewritten by itself: its bits depend neither on
    the formula behind a symbol nor on what is made of its own values.

    Raises
    ------
    ValueError
        If symbols or values are not one for each number of the layout.
    """

    layout: Layout
    symbols: ca.SX  # (m, 1)
    values: ca.SX  # (m, 1), in symbols of the equation and of the crossings before this one

    def __post_init__(self) -> None:
        for name in ("symbols", "values"):
            refuse_misfit("Crossing", name, getattr(self, name), self.layout.size, 1, "one for each number")

    @staticmethod
    def of(parts: Mapping[str, ca.SX]) -> Crossing:
        """The crossing of values by name, each in its shape."""
        made = {name: ca.densify(ca.SX(part)) for name, part in parts.items()}
        layout = Layout(tuple(Entry(name, np.zeros(_shape(part))) for name, part in made.items()))
        return Crossing(layout, layout.symbols(), layout.flatten(made))

    @property
    def parts(self) -> dict[str, ca.SX]:
        """The symbols by name, each in the shape of its value."""
        return self.layout.view(self.symbols)


def without_crossings(crossings: Sequence[Crossing], expression: ca.SX) -> ca.SX:
    """An expression with the values of the crossings in the place of their symbols."""
    for crossing in reversed(crossings):
        if crossing.symbols.numel() and expression.numel():
            expression = ca.substitute(expression, crossing.symbols, crossing.values)
    return expression


def refuse_strangers(
    owner: str, symbols: Mapping[str, ca.SX], crossings: Sequence[Crossing], **expressions: ca.SX
) -> None:
    """Refuse crossings and expressions with a symbol that is none of the equation's nor of a crossing before them."""
    known = dict(symbols)
    for i, crossing in enumerate(crossings):
        refuse_unknown(owner, known, crossings=crossing.values)
        known[f"crossing {i + 1}"] = crossing.symbols
    refuse_unknown(owner, known, **expressions)


def _shape(part: ca.SX) -> tuple[int, ...]:
    rows, columns = part.shape
    return (rows, columns) if columns != 1 else (rows,) if rows != 1 else ()
