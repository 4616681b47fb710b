"""Functions of a user's own as expressions: CasADi's, and Python's called once with symbols in place of numbers."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Signals
from workbench.core.expressions import symbols_are_no_numbers
from workbench.core.port import ANY
from workbench.validation.refusals import Array, described, raised, vector

PLAIN = """
sin cos tan asin acos atan atan2 arcsin arccos arctan arctan2 sinh cosh tanh arcsinh arccosh arctanh
sqrt exp log log10 log1p expm1 fabs fmax fmin fmod sign floor ceil hypot power if_else
"""
# What a Python function finds in its argument m: CasADi's functions, some by NumPy's names too.
FUNCTIONS = SimpleNamespace(
    **{name: getattr(ca, name) for name in PLAIN.split()},
    abs=ca.fabs,
    maximum=ca.fmax,
    minimum=ca.fmin,
    where=ca.if_else,
    pi=math.pi,
)


def port(what: str, given: Layout | tuple[str, ...]) -> Layout:
    """A layout from a "name:unit" for each number; without a colon the unit is unknown."""
    if isinstance(given, Layout):
        return given
    if not given:
        raise ValueError(f"`OdePlant.of({what}=...)` must have a name for each number, as 'omega:rad/s'; got none.")
    parts = (name.partition(":") for name in given)
    return Layout(tuple(Entry(name, np.array(0.0), unit if colon else ANY) for name, colon, unit in parts))


def with_defaults(what: str, held: Layout, values: Array | None) -> Layout:
    """A layout with these numbers (size,) as its defaults."""
    if values is None:
        return held
    column = vector(f"OdePlant.of({what}=...)", values, held.size, "names")
    held.check(column[np.newaxis])
    numbers = held.unpack(column)
    return Layout(tuple(replace(entry, default=numbers[entry.name]) for entry in held.entries))


@dataclass(frozen=True)
class Arguments:
    """Symbols for what f(t, x, u, p) and h(t, x, p) are called with."""

    t: ca.SX
    states: Layout
    inputs: Layout
    parameters: Layout

    @cached_property
    def x(self) -> ca.SX:
        """The states, (nx, 1)."""
        return self.states.symbols()

    @cached_property
    def u(self) -> ca.SX:
        """The inputs, (nu, 1)."""
        return self.inputs.symbols()

    @cached_property
    def p(self) -> ca.SX:
        """The parameters, (np, 1)."""
        return self.parameters.symbols()

    def of_rate(self) -> dict[str, ca.SX | Signals]:
        """The arguments of f, by letter."""
        return {"t": self.t, "x": self.x, "u": self.u, **self._of_parameters()}

    def of_output(self) -> dict[str, ca.SX | Signals]:
        """The arguments of h, by letter."""
        return {"t": self.t, "x": self.x, **self._of_parameters()}

    def _of_parameters(self) -> dict[str, Signals]:
        return {"p": Signals(self.parameters.view(self.p))} if self.parameters.size else {}


def read(letter: str, function: Callable[..., Any], given: dict[str, ca.SX | Signals], of: Layout) -> ca.SX:
    """What a function gives for symbols, a number for each of a layout, (size, 1)."""
    call = f"OdePlant.of({letter}=...)"
    if isinstance(function, ca.Function):
        return _column(call, _of_casadi(call, function, given), of)
    arguments = [_vector(part) if name in "xu" else part for name, part in given.items()]
    if _takes(call, function, given) > len(arguments):
        arguments.append(FUNCTIONS)
    try:
        with symbols_are_no_numbers():
            values = function(*arguments)
    except Exception as error:  # whatever a function of a user's own does with a symbol
        raise ValueError(
            f"`{call}` must compute with symbols in place of numbers, as it is read once, derived and compiled; it "
            f"raised {raised(error).rstrip('.')}: take `m.sin`, `m.sqrt`, ... of its last argument m in place of "
            "`math.sin`, and `m.where(c, a, b)` in place of `if`."
        ) from error
    return _column(call, values, of)


def _of_casadi(call: str, function: ca.Function, given: dict[str, ca.SX | Signals]) -> Any:
    """What a CasADi function gives for symbols; one of a graph of matrices is expanded into scalar operations."""
    columns = [
        ca.vertcat(*map(ca.vec, part.values())) if isinstance(part, Signals) else part for part in given.values()
    ]
    sizes = [function.size_in(i) for i in range(function.n_in())]
    if sizes != [part.shape for part in columns]:
        wanted = ", ".join(f"{name} {part.shape}" for name, part in zip(given, columns, strict=True))
        raise ValueError(f"`{call}` must be a function of {wanted}; got one of {sizes}.")
    if function.n_out() != 1:
        raise ValueError(f"`{call}` must have one output, a column; got {function.n_out()} of them.")
    try:
        return function(*columns)
    except Exception as error:  # an interpolant or an integrator within it, say
        raise ValueError(
            f"`{call}` must consist of operations that CasADi expands; it raised {raised(error)}."
        ) from error


def _vector(symbols: Any) -> Any:
    """Symbols as a NumPy vector, which can be indexed, unpacked and multiplied as one of numbers can."""
    entries = np.empty(symbols.numel(), dtype=object)
    entries[:] = [symbols[i] for i in range(symbols.numel())]
    return entries


def _takes(call: str, function: Callable[..., Any], given: dict[str, Any]) -> int:
    """How many arguments a Python function must be called with, by its signature: those given, or m beside them."""
    letters = ", ".join(given)
    try:
        named = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        raise ValueError(f"`{call}` must be a Python function of {letters} or of {letters}, m.") from None
    placed = (part for part in named if part.kind in (part.POSITIONAL_ONLY, part.POSITIONAL_OR_KEYWORD))
    needed = [part.name for part in placed if part.default is part.empty]
    if len(needed) not in (len(given), len(given) + 1):
        raise ValueError(
            f"`{call}` must be a function of {letters} or of {letters}, m; got one of {', '.join(needed)}."
        )
    return len(needed)


def _column(call: str, values: Any, of: Layout) -> ca.SX:
    """Values as a column, one for each number of a layout."""
    must = f"return {of.size} {'number' if of.size == 1 else 'numbers'}, for {', '.join(of.labels)}"
    try:
        parts = [values] if isinstance(values, ca.SX | ca.DM | np.ndarray) else list(map(ca.SX, values))
        column = ca.densify(ca.vertcat(*(ca.vec(ca.SX(part)) for part in parts)))
    except Exception:  # whatever it is that came
        raise ValueError(f"`{call}` must {must}; it returned {described(values)}.") from None
    if column.numel() != of.size:
        raise ValueError(f"`{call}` must {must}; it returned {column.numel()}.")
    return column
