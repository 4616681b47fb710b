"""Bounded loop: a body that is passed a fixed number of times, in an equation one call that nothing unrolls.

An equation of CasADi's SX has no loops. It can call a function, though, and here the function is a loop: the graph of
the batch engine reads it as one (`engine/kernel/loop_reading.py`), and CasADi itself can evaluate and differentiate it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from workbench.core.fingerprints import fingerprint_of
from workbench.core.validation.refusals import describe, whole
from workbench.core.validation.signatures import check_arguments

NAME = re.compile(r"bounded_loop_(\d+)_(forward|backward)_([0-9a-f]{16})")
BODY = "bounded_loop_body_"
STEPS = {ca.OP_SIGN, ca.OP_FLOOR, ca.OP_CEIL, ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_AND, ca.OP_OR, ca.OP_NOT}


@check_arguments
def bounded_loop(
    count: int,
    body: Callable[..., tuple[ca.SX, ...]],
    carry: ca.SX,
    *rows: ca.SX,
    constants: tuple[ca.SX, ...] = (),
    backward: bool = False,
) -> tuple[ca.SX, ...]:
    """The values that a body carries through `count` passes, and the rows that it makes in them:

        c[i + 1], y[i], ... = body(c[i], r[i], ...),   i = 0, ..., count - 1

    Parameters
    ----------
    count
        The number N of passes, at least 1.
    body
        A function of c (nc, 1), of a column r (m, 1) of each of `rows`, and of all `constants`, which returns the next
        c (nc, 1) and any number of columns y (n, 1). It is called once, with symbols, and may use all other symbols of
        the equation.
    carry
        The values c[0] (nc, 1).
    rows
        Matrices (m, N), of which each pass gets one column.
    constants
        Values that all passes get, of any shape. A body may use an expression of the equation without it, but then the
        expression is a part of the body: hand over the results of another loop.
    backward
        True to take the columns from the last to the first. The column y[i] belongs to r[i] then, too.

    Returns
    -------
    The values c at the end (nc, 1), and a matrix (n, N) for each column that the body makes.

    Raises
    ------
    ValueError
        If `count` is below 1, a matrix of `rows` has another number of columns, or the next c another size.

    Examples
    --------
    >>> import casadi as ca
    >>> x = ca.SX.sym("x")
    >>> end, powers = wb.bounded_loop(3, lambda c: (c * x, c * x), ca.SX(1))
    >>> ca.Function("f", [x], [powers])(2.0).elements()
    [2.0, 4.0, 8.0]
    """
    N, start = whole("bounded_loop(count=...)", count, least=1), ca.vec(ca.densify(carry))
    given, handed = ([ca.densify(ca.SX(part)) for part in parts] for parts in (rows, constants))
    if wrong := [part.shape for part in given if part.shape[1] != N]:
        raise ValueError(f"`bounded_loop(*rows)` must have a column for each of {N} passes; got the shape {wrong[0]}.")
    full = [part for part in given if part.shape[0]]
    if len(full) < len(given):
        body = _with_empty_columns(body, [part.shape[0] for part in given])
    function, others = _body(body, start.numel(), full, handed)
    return tuple(loop_function(function, N, backward).call([start, *full, ca.veccat(ca.SX(0, 1), *handed, *others)]))


def _with_empty_columns(body: Callable[..., tuple[ca.SX, ...]], sizes: list[int]) -> Callable[..., tuple[ca.SX, ...]]:
    """A body that gets the columns with entries alone, for one that also takes empty columns, of these sizes."""

    def whole_body(c: ca.SX, *parts: ca.SX) -> tuple[ca.SX, ...]:
        left = iter(parts)
        return body(c, *(next(left) if size else ca.SX(0, 1) for size in sizes), *left)

    return whole_body


def _body(
    body: Callable[..., tuple[ca.SX, ...]], size: int, rows: list[ca.SX], constants: list[ca.SX]
) -> tuple[ca.Function, list[ca.SX]]:
    """The body as a function (c, r, ..., shared), and the symbols of the equation behind its constants in `shared`."""
    c, r = ca.SX.sym("c", size), [ca.SX.sym("r", part.shape[0]) for part in rows]
    s = [ca.SX.sym("s", *part.shape) for part in constants]
    answer = body(c, *r, *s)
    if not isinstance(answer, tuple) or not answer:
        raise ValueError(
            "The body of a `bounded_loop` must return a tuple, the next carried values and its columns, as `(c,)`; got "
            f"{describe(answer)}."
        )
    following, *columns = (ca.densify(ca.vec(ca.SX(part))) for part in answer)
    if following.numel() != size:
        raise ValueError(
            f"The body of a `bounded_loop` must return as many carried values as it takes, {size}; "
            f"got {following.numel()}."
        )
    own = {symbol.element_hash() for symbol in ca.vertsplit(ca.veccat(c, *r, *s))}
    others = [s for s in ca.symvar(ca.vertcat(following, *columns)) if s.element_hash() not in own]
    return ca.Function("body", [c, *r, ca.veccat(ca.SX(0, 1), *s, *others)], [following, *columns]), others


@dataclass(frozen=True)
class LoopBody:
    """A bounded loop as it is read: its passes, their direction, and the body (c, r, ..., shared) -> (c, y, ...).

    Its name is a digest of all of it.
    """

    name: str
    count: int
    backward: bool
    function: ca.Function

    @property
    def carry_size(self) -> int:
        """The number of carried values."""
        return int(self.function.numel_in(0))

    @property
    def row_sizes(self) -> tuple[int, ...]:
        """The numbers of entries of the columns that a pass gets."""
        return tuple(self.function.numel_in(i) for i in range(1, self.function.n_in() - 1))

    @property
    def result_sizes(self) -> tuple[int, ...]:
        """The numbers of entries of the columns that a pass makes."""
        return tuple(self.function.numel_out(i) for i in range(1, self.function.n_out()))


def called_loop(function: ca.Function) -> LoopBody | None:
    """The bounded loop that a called function is; None if it is another function."""
    match = NAME.fullmatch(function.name())
    if match is None:
        return None
    count, way, digest = match.groups()
    return LoopBody(function.name(), int(count), way == "backward", function.find_function(f"{BODY}{digest}"))


def operation_count(function: ca.Function, of_passes: bool = True) -> int:
    """The number of operations of an SX function with those of its loops: of each pass, or as they are written."""
    inner = (operation_count(loop.function, of_passes) * (loop.count if of_passes else 1) for loop in _loops(function))
    return int(function.n_instructions()) + sum(inner)


def operation_codes(function: ca.Function) -> list[int]:
    """CasADi's codes of the operations of an SX function, in order, and behind them those of its loops."""
    own = [function.instruction_id(line) for line in range(function.n_instructions())]
    return [*own, *(code for loop in _loops(function) for code in operation_codes(loop.function))]


def _loops(function: ca.Function) -> list[LoopBody]:
    """The loops that an SX function calls itself."""
    calls = [line for line in range(function.n_instructions()) if function.instruction_id(line) == ca.OP_CALL]
    loops = (called_loop(function.instructions_sx()[line].which_function()) for line in calls)
    return [loop for loop in loops if loop is not None]


@check_arguments
def loop_function(body: ca.Function, count: int, backward: bool) -> ca.Function:
    """The function of (c, rows, ..., shared) that passes a body; by its name `called_loop` knows it again."""
    sizes = [body.numel_in(i) for i in range(body.n_in())]
    digest = fingerprint_of(repr(sizes).encode(), body)[:16]
    symbols = body.sx_in()
    body = ca.Function(f"{BODY}{digest}", symbols, body.call(symbols, True, False))
    c, shared = ca.MX.sym("c", sizes[0]), ca.MX.sym("shared", sizes[-1])
    rows = [ca.MX.sym("rows", size, count) for size in sizes[1:-1]]
    order = list(range(count))[:: -1 if backward else 1]
    every, *made = body.mapaccum("passes", count).call(
        [c, *(part[:, order] for part in rows), ca.repmat(shared, 1, count)]
    )
    results = [every[:, -1], *(part[:, order] for part in made)]
    name = f"bounded_loop_{count}_{'backward' if backward else 'forward'}_{digest}"
    if c.numel() and _is_stepwise(body):
        zero = ca.sum1(4 * c - 2 * c - 2 * c)  # whose slope is zero: without one CasADi reads what nobody wrote
        results = [part + zero for part in results]
    return ca.Function(name, [c, *rows, shared], results, {"never_inline": True})


def _is_stepwise(body: ca.Function) -> bool:
    """True if no result of a body has a slope, as of `sign`."""
    if STEPS.isdisjoint(operation_codes(body)):
        return False
    ahead = body.forward(1)
    return all(slope.is_zero() for slope in ahead.call(ahead.sx_in()))
