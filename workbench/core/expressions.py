"""Expressions of CasADi: checks of their symbols and shapes, their operations, and their values at many points."""

from __future__ import annotations

import contextlib
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol, TypeVar

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments

T = TypeVar("T")
ONE_AT_A_TIME = threading.RLock()  # for `symbols_are_no_numbers`, which changes CasADi's class for all threads
AT_ONCE = 64  # points of one call: for thousands CasADi takes longer to write down their pattern than their values


class SymbolError(TypeError):
    """The error of a symbol taken for a number."""


@contextlib.contextmanager
def symbols_are_no_numbers() -> Iterator[None]:
    """Within this context a symbol refuses to become a number, and rounds as a number does.

    Else CasADi makes it NaN, in silence, and rounds halves away from zero.
    """

    def guard(convert: Callable[[ca.SX], T]) -> Callable[[ca.SX], T]:
        def to_number(symbol: ca.SX) -> T:
            if not symbol.is_constant():
                raise SymbolError(f"the symbol '{symbol}' is no number")
            return convert(symbol)

        return to_number

    with ONE_AT_A_TIME, warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)  # of CasADi's, on NumPy's functions of its symbols
        plain = {name: getattr(ca.SX, name) for name in ("__float__", "__int__", "__bool__")}
        methods = {name: guard(method) for name, method in plain.items()}
        methods |= {"__round__": _round, "rint": round_half_even}
        methods |= {name: _rounding_method(getattr(ca.SX, name)) for name in ("__array_ufunc__", "__array_function__")}
        with _replace_methods(ca.SX, methods):
            yield


@contextlib.contextmanager
def _replace_methods(owner: type, methods: Mapping[str, object]) -> Iterator[None]:
    """Within this context a class has these methods."""
    plain = {name: vars(owner).get(name) for name in methods}
    try:
        for name, method in methods.items():
            setattr(owner, name, method)
        yield
    finally:
        for name, own in plain.items():
            if own is None:
                delattr(owner, name)
            else:
                setattr(owner, name, own)


def round_half_even(x: ca.SX) -> ca.SX:
    """The nearest whole number, of two that are as near the even one, as of NumPy's `rint` and Python's `round`."""
    low = ca.floor(x)
    above, odd = x - low, low - 2 * ca.floor(low / 2)  # both exact: of a large number there is nothing above
    return low + ca.if_else(above == 0.5, odd, ca.if_else(above > 0.5, 1, 0))


def _round(x: ca.SX, digits: int | None = None) -> ca.SX:
    if digits is not None:
        raise SymbolError(f"`round(x, {digits})` of the symbol '{x}' has no equation, as it rounds decimal digits")
    return round_half_even(x)


def _numpy_round(a: ca.SX, decimals: int = 0) -> ca.SX:
    """NumPy's `round`: of a scaled number to a whole one."""
    scale = 10.0 ** abs(decimals)
    if decimals < 0:
        return round_half_even(a / scale) * scale
    return round_half_even(a * scale) / scale if decimals else round_half_even(a)


def _rounding_method(plain: Callable[..., object]) -> Callable[..., object]:
    """A method of CasADi that answers NumPy's functions, but for those that round, which CasADi answers otherwise."""

    def answer(symbol: ca.SX, function: object, *how: Any, **options: object) -> object:
        if function is np.rint and how[0] == "__call__" and not options:
            return round_half_even(how[1])
        if function in (np.round, np.around):
            return _numpy_round(*how[1], **how[2])
        return plain(symbol, function, *how, **options)

    return answer


def refuse_unknown(owner: str, symbols: Mapping[str, ca.SX], **expressions: ca.SX) -> None:
    """Refuse an equation whose `symbols` are no plain symbols, or whose expressions `made` hold any others."""
    letters = ", ".join(symbols)
    if not all(part.is_valid_input() for part in symbols.values()):
        raise ValueError(
            f"`{owner}({letters})` must be plain symbols, as `Layout.symbols()` makes them; got an expression."
        )
    known = {entry.__hash__() for part in symbols.values() for entry in part.elements()}
    if len(known) < (size := sum(part.numel() for part in symbols.values())):
        raise ValueError(
            f"`{owner}({letters})` must be {size} symbols, each with one place; got {len(known)} different ones."
        )
    if all(symbol.__hash__() in known for symbol in ca.symvar(ca.veccat(*expressions.values()))):
        return
    for name, expression in expressions.items():
        for symbol in ca.symvar(expression):
            if symbol.__hash__() not in known:
                raise ValueError(
                    f"`{owner}({name}=...)` must be of {letters} alone, as nothing else gets a value; got the symbol "
                    f"'{symbol.name()}' beside them."
                )


def refuse_misfit(owner: str, name: str, value: ca.SX, rows: int, columns: int, why: str = "") -> None:
    """Refuse an expression of another shape than (rows, columns), unless both have no entries."""
    if value.shape != (rows, columns) and (rows * columns, value.numel()) != (0, 0):
        raise ValueError(
            f"`{owner}({name}=...)` must have shape ({rows}, {columns}){f', {why}' if why else ''}; got {value.shape}."
        )


@check_arguments
def rows(function: ca.Function, *arguments: Array) -> Array:
    """The values (n, size) of a function at n points, each column by column; an argument is (n, size) or one row."""
    sizes = [function.numel_in(i) for i in range(function.n_in())]
    n = max((len(a) for a in arguments if a.ndim == 2), default=0)
    if [a.shape[1:] for a in arguments] != [(size,) for size in sizes] or {len(a) for a in arguments} - {n, 1}:
        raise ValueError(
            f"`rows(function, ...)` takes arrays (n, {sizes}), or of a single row; got shapes "
            f"{[a.shape for a in arguments]}."
        )
    if function.nnz_out(0) < function.numel_out(0):  # a buffer would get the entries that are not zero alone
        symbols = function.sx_in()
        function = ca.Function(function.name(), symbols, [ca.densify(function(*symbols))])
    side = min(n, AT_ONCE)
    if n == 0 or function.numel_out(0) == 0:
        return np.zeros((n, function.numel_out(0)))
    places = np.minimum(np.arange(-(-n // side) * side), n - 1)
    values = np.zeros((len(places), function.numel_out(0)))
    held = [np.array(np.broadcast_to(a, (n, a.shape[1]))[places], dtype=float, order="C") for a in arguments]
    buffer, evaluate = buffer_of(function.map(side))
    for first in range(0, len(places), side):
        for i, part in enumerate(held):
            if part.size:
                buffer.set_arg(i, memory(part[first : first + side]))
        buffer.set_res(0, memory(values[first : first + side]))
        evaluate()
    return values[:n]


class Buffer(Protocol):
    """The places that a function of CasADi reads and writes, whose own types ask for a size that nobody gives."""

    def set_arg(self, i: int, place: memoryview) -> None:
        """Read an argument there."""

    def set_res(self, i: int, place: memoryview) -> None:
        """Write a result there."""


def buffer_of(function: ca.Function) -> tuple[Buffer, Callable[[], None]]:
    """The buffer of a function, to which the caller must hold a reference, and its evaluation."""
    buffer: Any
    buffer, evaluate = function.buffer()
    return buffer, evaluate


def memory(place: Array) -> memoryview:
    """An array as CasADi's buffers take it, to which the caller must hold a reference."""
    return place.data


def call_again(function: ca.Function, operands: Sequence[ca.SX]) -> list[ca.SX]:
    """The stored entries of all results of a called function, for `evaluate_sx` in CasADi's own expressions."""
    ends = np.cumsum([function.nnz_in(i) for i in range(function.n_in())])
    parts = [operands[end - function.nnz_in(i) : end] for i, end in enumerate(ends)]
    columns = (ca.vertcat(ca.SX(0, 1), *part) for part in parts)
    arguments = [ca.sparsity_cast(column, function.sparsity_in(i)) for i, column in enumerate(columns)]
    stored = (ca.sparsity_cast(part, ca.Sparsity.dense(part.nnz(), 1)) for part in function.call(arguments))
    return [entry for column in stored for entry in ca.vertsplit(column)]


def evaluate_sx(
    function: ca.Function,
    inputs: Callable[[int, int], T],
    constant: Callable[[float], T],
    operation: Callable[..., T],
    call: Callable[[ca.Function, Sequence[T]], Sequence[T]] | None = None,
) -> list[dict[int, T]]:
    """The stored entries of each result of an SX function, computed in an arithmetic of one's own.

    A `call` gives the stored entries of all results of a called function; without it a call is an `operation`.
    """
    registers, results = dict[int, T](), [dict[int, T]() for _ in range(function.n_out())]
    for line in range(function.n_instructions()):
        code = function.instruction_id(line)
        reads, writes = function.instruction_input(line), function.instruction_output(line)
        if code == ca.OP_OUTPUT:
            results[writes[0]][writes[1]] = registers[reads[0]]
        elif code == ca.OP_INPUT:
            registers[writes[0]] = inputs(reads[0], reads[1])
        elif code == ca.OP_CONST:
            registers[writes[0]] = constant(function.instruction_constant(line))
        elif code == ca.OP_CALL and call is not None:
            called = function.instructions_sx()[line].which_function()
            registers |= zip(writes, call(called, [registers[read] for read in reads]), strict=True)
        else:
            value = operation(code, *(registers[read] for read in reads))
            registers |= dict.fromkeys(writes, value)  # a call writes several, of which none is known here
    return results
