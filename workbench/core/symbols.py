"""Symbols of an equation: plain, each with one place, and nothing beside them."""

from __future__ import annotations

import contextlib
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import casadi as ca

ONE_AT_A_TIME = threading.RLock()  # as what is put in place of CasADi's own, and back, is there for all threads


class SymbolError(TypeError):
    """A symbol was taken for a number."""


@contextlib.contextmanager
def symbols_are_no_numbers() -> Iterator[None]:
    """While this lasts, a symbol refuses to become a number: CasADi's is NaN, which `math` passes on in silence."""

    def guard(convert: Callable[[ca.SX], Any]) -> Callable[[ca.SX], Any]:
        def to_number(symbol: ca.SX) -> Any:
            if not symbol.is_constant():
                raise SymbolError(f"the symbol '{symbol}' is no number")
            return convert(symbol)

        return to_number

    with ONE_AT_A_TIME, warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)  # of CasADi's, on NumPy's functions of its symbols
        plain = {name: getattr(ca.SX, name) for name in ("__float__", "__int__", "__bool__")}
        try:
            for name, method in plain.items():
                setattr(ca.SX, name, guard(method))
            yield
        finally:
            for name, method in plain.items():
                setattr(ca.SX, name, method)


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
