"""Symbols of an equation: plain, each with one place, and nothing beside them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import casadi as ca


def refuse_unknown(owner: str, symbols: Mapping[str, ca.SX], **made: ca.SX) -> None:
    """Refuse an equation whose `symbols` are none, or whose expressions `made` hold others: nothing gives them a value.

    Raises
    ------
    ValueError
        With the name of the expression that stands for a symbol, or of the symbol beside them.
    """
    letters = ", ".join(symbols)
    if not all(part.is_valid_input() for part in symbols.values()):
        raise ValueError(
            f"`{owner}({letters})` must be plain symbols, as `Layout.symbols()` makes them; got an expression."
        )
    held = ca.symvar(ca.vertcat(*map(ca.vec, symbols.values())))
    if len(held) < (size := sum(part.numel() for part in symbols.values())):
        raise ValueError(
            f"`{owner}({letters})` must be {size} symbols, each with one place; got {len(held)} different ones."
        )
    known = {symbol.__hash__() for symbol in held}
    for name, expression in made.items():
        for symbol in ca.symvar(expression):
            if symbol.__hash__() not in known:
                raise ValueError(
                    f"`{owner}({name}=...)` must be of {letters} alone, as nothing else gets a value; got the symbol "
                    f"'{symbol.name()}' beside them."
                )


def refuse_misfit(owner: str, name: str, value: ca.SX, rows: int, columns: int, why: str = "") -> None:
    """Refuse an expression of another shape than (rows, columns); of no entries, any shape is right."""
    if value.shape != (rows, columns) and (rows * columns, value.numel()) != (0, 0):
        raise ValueError(
            f"`{owner}({name}=...)` must have shape ({rows}, {columns}){f', {why}' if why else ''}; got {value.shape}."
        )


def holds_nan(expression: ca.SX) -> bool:
    """Whether one of the numbers in an expression is not a number."""
    f = ca.Function("f", ca.symvar(expression), [expression])
    numbers = (f.instruction_constant(k) for k in range(f.n_instructions()) if f.instruction_id(k) == ca.OP_CONST)
    return any(map(math.isnan, numbers))
