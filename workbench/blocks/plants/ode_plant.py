"""A plant made from existing equations: an open `Ode`, CasADi functions, or plain Python functions."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import NoReturn, TypeAlias

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts
from workbench.core import Entry, Layout, Ode, Signals, block
from workbench.core.block import Number, States, parameters
from workbench.core.expressions import SymbolError, symbols_are_no_numbers
from workbench.core.ode import time_beside
from workbench.core.units import ANY
from workbench.core.validation.refusals import Array, describe, error_text, nearest, text, vector

Port = Layout | tuple[str, ...]
Arguments: TypeAlias = Mapping[str, ca.SX | Signals]
Values: TypeAlias = ca.SX | ca.DM | Array | Iterable[ca.SX | float]  # of a function, a number for each state or output
PLAIN = """
sin cos tan asin acos atan atan2 arcsin arccos arctan arctan2 sinh cosh tanh arcsinh arccosh arctanh
sqrt exp log log10 log1p expm1 fabs fmax fmin fmod sign floor ceil hypot power if_else
"""


class FunctionNamespace(SimpleNamespace):
    """The namespace m of a Python function: CasADi's functions, some by NumPy's names too."""

    def __getattr__(self, name: str) -> NoReturn:
        near = nearest(name, vars(self)).replace(" Did", "; did").rstrip("?")
        raise AttributeError(f"the functions m have no attribute '{name}'{near}", name=name, obj=self)


FUNCTIONS = FunctionNamespace(
    **{name: getattr(ca, name) for name in PLAIN.split()},
    abs=ca.fabs,
    maximum=ca.fmax,
    minimum=ca.fmin,
    where=ca.if_else,
    pi=math.pi,
)


@block
class OdePlant(AbstractPlant):
    """A plant made from an `Ode` with declared inputs, or, by `OdePlant.of`, from functions.

    The declared inputs and the outputs of `ode` become those of the plant. A parameter R is `plant.R` in a loop.

    Raises
    ------
    ValueError
        If the equations declare no inputs, or an output depends on an input, which makes an algebraic loop.

    Examples
    --------
    >>> tank = wb.OdePlant.of(lambda t, x, u: [u[0] - x[0] ** 0.5], states=("h:m",), inputs=("w:m/s",), x0=[1.0])
    >>> tank.inputs.names, tank.outputs.names
    (('w',), ('h',))
    """

    ode: Ode
    own: Layout | Signals = parameters()  # of the lifted twin the symbols

    def __post_init__(self) -> None:
        ode = self.ode
        if not ode.inputs:
            raise ValueError(
                f"`OdePlant(ode=...)` must declare in `inputs` which of its parameters drive it; '{ode.name}' declares "
                "none."
            )
        for entry in ode.outputs.entries:
            if ca.depends_on(ode.output[ode.outputs.slice(entry.name)], ode.input_symbols):
                raise ValueError(
                    f"`OdePlant(ode=...)` must have outputs that depend on no input, as a law that reads one would "
                    f"meet its own command of the same instant, an algebraic loop; '{entry.name}' of '{ode.name}' "
                    "does: leave it out, or put the lag between the two into the states."
                )
        own = tuple(entry for entry in ode.parameters.entries if entry.name not in ode.inputs)
        object.__setattr__(self, "own", Layout(own))

    def __repr__(self) -> str:
        """One line: a notebook should not print the equations by accident."""
        return f"<OdePlant '{self.ode.name}': {', '.join(self.inputs.names)} to {', '.join(self.outputs.names)}>"

    @staticmethod
    def of(
        f: Callable[..., Values],
        states: Port,
        inputs: Port,
        outputs: Port | None = None,
        h: Callable[..., Values] | None = None,
        *,
        p: Layout | None = None,
        x0: Array | None = None,
        u0: Array | None = None,
        name: str = "plant",
    ) -> OdePlant:
        """A plant x' = f(t, x, u, p), y = h(t, x, p) from CasADi or Python functions.

        Parameters
        ----------
        f, h
            A `casadi.Function` of columns, or a Python function that returns a number for each state (f) or output (h).
            Without parameters there is no argument p. A Python function gets the parameter R as `p.R`. If it has one
            more argument, this is a namespace m of functions, with `m.sin` and `m.where`.
        states, inputs, outputs
            Layouts, or a "name:unit" for each number; a name without a unit fits every unit. Without h the outputs are
            states: the ones that `outputs` names, or all.
        p
            The parameters with their values: `layout(R=("ohm", 1.0))`.
        x0, u0
            Initial state (nx,) and initial inputs (nu,). The defaults are those of the layouts, usually zero.

        Raises
        ------
        ValueError
            If a function takes or gives other sizes, or cannot be computed with symbols in place of numbers.
        LookupError
            If an output without h is no state.
        """
        known, driven = _port("states", states, "x0", x0), _port("inputs", inputs, "u0", u0)
        own = p or Layout()
        t, x, u, theta = time_beside(known, driven, own), known.symbols(), driven.symbols(), own.symbols()
        numbers = {"p": Signals(own.view(theta))} if own.size else {}
        rate = _values_of("f", f, {"t": t, "x": x, "u": u, **numbers}, known)
        watched, output = _outputs(h, outputs, {"t": t, "x": x, **numbers}, known, x)
        text("OdePlant.of(name=...)", name)
        ode = Ode(name, known, own + driven, watched, t, x, ca.vertcat(theta, u), rate, output, inputs=driven.names)
        return OdePlant(ode)

    @property
    def ends(self) -> float:
        return self.ode.horizon

    @property
    def states(self) -> Layout:
        return self.ode.states

    @property
    def inputs(self) -> Layout:
        return Layout(tuple(self.ode.parameters[name] for name in self.ode.inputs))

    @property
    def outputs(self) -> Layout:
        return self.ode.outputs

    def measure(self, t: Number, x: States) -> Signals:
        ode = self.ode
        unused = {e.name: ca.SX.zeros(*e.shape) for e in self.inputs.entries}
        return Signals(ode.outputs.view(ode.h(t, ode.states.flatten(x), self._p(unused))))

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        ode = self.ode
        return ode.states.view(ode.f(t, ode.states.flatten(x), self._p(u)))

    def _p(self, u: Parts) -> ca.SX:
        """All parameters of the equation as one column."""
        own = self.own
        held = {e.name: ca.SX(e.default) for e in own.entries} if isinstance(own, Layout) else own
        return self.ode.parameters.flatten({**held, **u})


def _outputs(
    h: Callable[..., Values] | None, outputs: Port | None, arguments: Arguments, states: Layout, x: ca.SX
) -> tuple[Layout, ca.SX]:
    """The outputs with their expressions (ny, 1): the values of h or, without it, states."""
    if h is None:
        names = states.names if outputs is None else _port("outputs", outputs).names
        parts = (x[states.slice(name)] for name in names)
        return Layout(tuple(states[name] for name in names)), ca.vertcat(*parts)
    if outputs is None:
        raise ValueError("`OdePlant.of(outputs=...)` must name what h gives, as in ('y:V',); got None.")
    watched = _port("outputs", outputs)
    return watched, _values_of("h", h, arguments, watched)


def _port(what: str, port: Port, start: str = "", values: Array | None = None) -> Layout:
    """A layout from a "name:unit" for each number, without a colon of an unknown unit, that starts at `values`."""
    if not isinstance(port, Layout):
        if not port:
            raise ValueError(f"`OdePlant.of({what}=...)` must have a name for each number, as 'omega:rad/s'; got none.")
        parts = (name.partition(":") for name in port)
        port = Layout(tuple(Entry(name, np.array(0.0), unit if colon else ANY) for name, colon, unit in parts))
    if values is None:
        return port
    column = vector(f"OdePlant.of({start}=...)", values, port.size, "names")
    port.check(column[np.newaxis])
    numbers = port.unpack(column)
    return Layout(tuple(replace(entry, default=numbers[entry.name]) for entry in port.entries))


def _values_of(letter: str, function: Callable[..., Values], symbols: Arguments, of: Layout) -> ca.SX:
    """The value of a function for symbols: one expression for each number of a layout, (size, 1)."""
    call = f"OdePlant.of({letter}=...)"
    if isinstance(function, ca.Function):
        return _column(call, _of_casadi(call, function, symbols), of)
    arguments: list[object] = [
        _vector(part) if isinstance(part, ca.SX) and name in "xu" else part for name, part in symbols.items()
    ]
    if _takes(call, function, symbols) > len(arguments):
        arguments.append(FUNCTIONS)
    try:
        with symbols_are_no_numbers():
            values = function(*arguments)
    except Exception as error:  # whatever a function of a user's own does with a symbol
        raise ValueError(
            f"`{call}` must compute with symbols in place of numbers, as it is read once, derived and compiled; it "
            f"raised {error_text(error).rstrip('.')}{_remedy(error, function, symbols)}."
        ) from error
    return _column(call, values, of)


def _remedy(error: BaseException, function: Callable[..., Values], arguments: Arguments) -> str:
    """The advice for an error of a user's function: only where its cause is known."""
    if _met_a_symbol(error):
        return (
            ": take `m.sin`, `m.sqrt`, ... of its last argument m in place of `math.sin`, and `m.where(c, a, b)` in "
            "place of `if`"
        )
    more = [*inspect.signature(function).parameters][len(arguments) :]  # m, by that name or by another one
    unfit = "p" not in arguments and more not in ([], ["m"])
    if unfit and "FunctionNamespace" in f"{error} {getattr(error, 'obj', '')!r}":
        return (
            ": the last argument of a function without parameters is the namespace m; give parameters by "
            "`p=layout(R=('ohm', 1.0))`"
        )
    if isinstance(error, IndexError):
        vectors = {name: part for name, part in arguments.items() if isinstance(part, ca.SX) and name in "xu"}
        sizes = " and ".join(f"{part.numel()} in {name}" for name, part in vectors.items())
        return f": there is a number for each name, {sizes}"
    return ""


def _met_a_symbol(error: BaseException) -> bool:
    """True if a function of `math` or NumPy, or an `if`, met a symbol that it takes for a number."""
    by_attribute = isinstance(error, AttributeError) and isinstance(error.obj, ca.SX)
    by_type = isinstance(error, TypeError | NotImplementedError) and "SX" in str(error)
    return isinstance(error, SymbolError) or by_attribute or (by_type and "FunctionNamespace" not in str(error))


def _of_casadi(call: str, function: ca.Function, arguments: Arguments) -> ca.SX:
    """The value of a CasADi function for symbols, expanded into scalar operations if it is a graph of matrices."""
    columns = [ca.vertcat(*map(ca.vec, p.values())) if isinstance(p, Signals) else p for p in arguments.values()]
    sizes = [function.size_in(i) for i in range(function.n_in())]
    if sizes != [part.shape for part in columns]:
        wanted = ", ".join(f"{name} {part.shape}" for name, part in zip(arguments, columns, strict=True))
        raise ValueError(f"`{call}` must be a function of {wanted}; got one of {sizes}.")
    if function.n_out() != 1:
        raise ValueError(f"`{call}` must have one output, a column; got {function.n_out()} of them.")
    try:
        return function(*columns)
    except Exception as error:  # an interpolant or an integrator within it, say
        raise ValueError(
            f"`{call}` must consist of operations that CasADi expands; it raised {error_text(error)}."
        ) from error


def _vector(symbols: ca.SX) -> NDArray[np.object_]:
    """Symbols as a NumPy vector, which can be indexed, unpacked and multiplied as one of numbers can."""
    entries = np.empty(symbols.numel(), dtype=object)
    entries[:] = [symbols[i] for i in range(symbols.numel())]
    return entries


def _takes(call: str, function: Callable[..., Values], arguments: Arguments) -> int:
    """The number of arguments that a Python function requires by its signature: those given, with or without m."""
    letters = ", ".join(arguments)
    try:
        named = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        raise ValueError(f"`{call}` must be a Python function of {letters} or of {letters}, m.") from None
    placed = (part for part in named if part.kind in (part.POSITIONAL_ONLY, part.POSITIONAL_OR_KEYWORD))
    needed = [part.name for part in placed if part.default is part.empty]
    if len(needed) not in (len(arguments), len(arguments) + 1):
        more = " Parameters are given by `p=layout(R=('ohm', 1.0))`." if "p" in needed and "p" not in arguments else ""
        raise ValueError(
            f"`{call}` must be a function of {letters} or of {letters}, m; got one of {', '.join(needed)}.{more}"
        )
    return len(needed)


def _column(call: str, values: Values, of: Layout) -> ca.SX:
    """Values as a column, one for each number of a layout."""
    must = f"return {of.size} {'number' if of.size == 1 else 'numbers'}, for {', '.join(of.labels)}"
    try:
        parts = [values] if isinstance(values, ca.SX | ca.DM | np.ndarray) else list(map(ca.SX, values))
        column = ca.densify(ca.vertcat(*(ca.vec(ca.SX(part)) for part in parts)))
    except Exception:  # whatever it is that came
        raise ValueError(f"`{call}` must {must}; it returned {describe(values)}.") from None
    if column.numel() != of.size:
        raise ValueError(f"`{call}` must {must}; it returned {column.numel()}.")
    return column
