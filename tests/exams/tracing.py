"""A plain function f(t, x) of numbers as an `Ode`: called with symbols, while the names it uses are CasADi's."""

from __future__ import annotations

import contextlib
import inspect
import math
import types
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode

from .arrays import Algebra, array, blank
from .branches import branched

Rate = Callable[[Any, Any], Any]
POINTS = 20  # states at which the traced function is held against the plain one


class UntraceableError(Exception):
    """Why a function has no graph."""


def _extreme(pick: Callable[[Any, Any], Any], plain: Callable[..., Any]) -> Callable[..., Any]:
    def of(*values: Any, **options: Any) -> Any:
        numbers = values if len(values) > 1 else tuple(values[0])
        if options or not any(isinstance(value, ca.SX) for value in numbers):
            return plain(*values, **options)
        result = numbers[0]
        for value in numbers[1:]:
            result = pick(result, value)
        return result

    return of


def _either(symbolic: Callable[..., Any], plain: Callable[..., Any]) -> Callable[..., Any]:
    """A function that is CasADi's for symbols and arrays of them, and for numbers what it was, to their last bit."""

    def of(*values: Any, **options: Any) -> Any:
        if any(isinstance(value, np.ndarray) and value.dtype == object for value in values):
            return np.frompyfunc(symbolic, len(values), 1)(*values)
        return (symbolic if any(isinstance(value, ca.SX) for value in values) else plain)(*values, **options)

    return of


SYMBOLIC: dict[str, Callable[..., Any]] = {
    name: getattr(ca, name)
    for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "sqrt", "log", "fabs", "floor", "ceil", "sign")
} | {
    "asin": ca.asin,
    "acos": ca.acos,
    "atan": ca.atan,
    "atan2": ca.atan2,
    "arcsin": ca.asin,
    "arccos": ca.acos,
    "arctan": ca.atan,
    "arctan2": ca.atan2,
    "hypot": lambda a, b: ca.sqrt(a * a + b * b),
    "pow": lambda a, b: a**b,
    "copysign": lambda a, b: ca.fabs(a) * ca.sign(b),
    "abs": ca.fabs,
    "absolute": ca.fabs,
    "maximum": ca.fmax,
    "minimum": ca.fmin,
    "where": ca.if_else,
    "float64": lambda a: a,
    "clip": lambda a, low, high: ca.fmax(low, ca.fmin(high, a)),
}
BUILTIN: dict[str, Callable[..., Any]] = {
    "max": _extreme(ca.fmax, max),
    "min": _extreme(ca.fmin, min),
    "abs": _either(ca.fabs, abs),
    "float": _either(lambda value: value, float),
}
ARRAYS = {"array": array(np.array), "asarray": array(np.asarray)} | {
    name: blank(getattr(np, name)) for name in ("zeros", "empty", "ones", "full", "zeros_like", "empty_like")
}


def trace(f: Rate, x0: Any, modules: Iterable[types.ModuleType]) -> Ode:
    """x' = f(t, x) from x0 as an `Ode`, where f was written in `modules`.

    Raises
    ------
    UntraceableError
        If f needs numbers where there are symbols, or its graph gives other numbers than f itself.
    """
    start = np.array(x0, dtype=float).ravel()
    states = Layout((Entry("x", start),))
    t, x = ca.SX.sym("t"), states.symbols()
    entries = np.empty(states.size, dtype=object)
    entries[:] = [x[i] for i in range(states.size)]
    try:
        with symbolic(f, modules):
            rate = branched(lambda: _column(f(t, entries)))
        ode = Ode.of("exam", states, Layout(), (t, x, ca.SX(0, 1)), {"x": rate}, {})
    except Exception as error:  # whatever a foreign function does with a symbol
        raise UntraceableError(f"its function has no graph ({str(error).splitlines()[0][:80]})") from error
    rng = np.random.default_rng(0)
    for _ in range(POINTS):
        at, where = rng.uniform(0.0, 3.0), start + rng.normal(size=start.size)
        try:
            plain = np.array(f(at, where), dtype=float)
        except (ArithmeticError, ValueError):  # where f itself has no value
            continue
        except Exception as error:
            raise UntraceableError(f"the function itself breaks ({type(error).__name__}: {error})") from error
        # rounding of reordered sums, and of CasADi's own elementary functions
        if not np.allclose(ode.rate_at(at, where), plain, rtol=1e-10, atol=1e-10, equal_nan=True):
            raise UntraceableError("its graph gives other numbers than the function itself")
    return ode


def _column(rate: Any) -> ca.SX:
    """What a function gave, (n, 1); an array and a symbol have a sum that is CasADi's."""
    return ca.vec(rate) if isinstance(rate, ca.SX) else ca.vertcat(*[ca.SX(part) for part in rate])


def chooses(ode: Ode) -> bool:
    """Whether a graph has ways to choose from."""
    rate = ca.Function("rate", [ode.t, ode.x], [ode.rate])
    return any(rate.instruction_id(i) == ca.OP_IF_ELSE_ZERO for i in range(rate.n_instructions()))


@contextlib.contextmanager
def symbolic(f: Rate, modules: Iterable[types.ModuleType]) -> Iterator[None]:
    """While this lasts, the functions of numbers that f and its modules use also take symbols."""
    with contextlib.ExitStack() as undo:
        for module in modules:
            _swap_globals(vars(module), module.__name__, undo)
        _swap_closure(f, undo, set())
        yield


def _swap_globals(names: dict[str, Any], module: str, undo: contextlib.ExitStack) -> None:
    for name, value in list(names.items()):
        if (inspect.isclass(value) and value.__module__ == module) or isinstance(value, types.SimpleNamespace):
            _swap_attributes(value, undo)
        elif (new := _counterpart(value)) is not None:
            names[name] = new
            undo.callback(names.__setitem__, name, value)
    for name, new in BUILTIN.items():
        if name not in names:
            names[name] = new
            undo.callback(names.__delitem__, name)


def _swap_attributes(space: Any, undo: contextlib.ExitStack) -> None:
    for name, value in list(vars(space).items()):
        plain = value.__func__ if isinstance(value, staticmethod) else value
        new = _counterpart(plain)
        if new is not None:
            setattr(space, name, staticmethod(new) if inspect.isclass(space) else new)
            undo.callback(setattr, space, name, value)


def _swap_closure(f: Any, undo: contextlib.ExitStack, seen: set[int]) -> None:
    if id(f) in seen or not isinstance(f, types.FunctionType):
        return
    seen.add(id(f))
    for cell in f.__closure__ or ():
        try:
            value = cell.cell_contents
        except ValueError:  # a name that has no value yet
            continue
        _swap_closure(value, undo, seen)
        if isinstance(value, types.SimpleNamespace):
            _swap_attributes(value, undo)
        elif (new := _counterpart(value)) is not None:
            cell.cell_contents = new
            undo.callback(setattr, cell, "cell_contents", value)


def _counterpart(value: Any) -> Any:
    """What stands for a module, a function of numbers, or a switch while there are symbols; None for all else."""
    if value is math or value is np:
        return _Namespace(value)
    if isinstance(value, types.BuiltinFunctionType | np.ufunc):
        if value in (max, min):
            return BUILTIN[value.__name__]
        return _either(SYMBOLIC[value.__name__], value) if value.__name__ in SYMBOLIC else None
    if isinstance(value, types.FunctionType) and (levels := _levels(value)) is not None:
        return _either(_switch(*levels), value)
    return None


def _levels(f: Callable[..., Any]) -> tuple[float, float, float] | None:
    """The values below, at and above zero of a function of one number that only asks for its sign; else None."""
    code = f.__code__
    if code.co_argcount != 1 or code.co_kwonlyargcount or f.__closure__:
        return None
    try:
        values = [f(x) for x in (-2.0, -1e-9, 0.0, 1e-9, 2.0)]
    except Exception:  # it takes something else
        return None
    plain = all(isinstance(value, int | float) for value in values)
    if not plain or values[0] != values[1] or values[3] != values[4] or values[0] == values[4]:
        return None
    return float(values[0]), float(values[2]), float(values[4])


def _switch(below: float, at: float, above: float) -> Callable[[ca.SX], ca.SX]:
    if (below, at, above) == (-1.0, 0.0, 1.0):
        return ca.sign
    return lambda x: ca.if_else(x < 0, below, ca.if_else(x > 0, above, at))


class _Namespace:
    """The module `math` or `numpy` whose functions also take symbols."""

    def __init__(self, module: types.ModuleType) -> None:
        self.module = module

    def __getattr__(self, name: str) -> Any:
        value = getattr(self.module, name)
        if self.module is np and name in ARRAYS:
            return ARRAYS[name]
        if value is np.linalg:
            return Algebra()
        return _either(SYMBOLIC[name], value) if name in SYMBOLIC else value
