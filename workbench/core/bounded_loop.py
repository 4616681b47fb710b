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
from workbench.core.validation.refusals import whole
from workbench.core.validation.signatures import check_arguments

Body = Callable[[ca.SX, ca.SX], tuple[ca.SX, ca.SX]]
NAME = re.compile(r"bounded_loop_(\d+)_(forward|backward)_([0-9a-f]{16})")
BODY = "bounded_loop_body_"


@check_arguments
def bounded_loop(
    count: int, body: Body, carried: ca.SX, rows: ca.SX | None = None, *, backward: bool = False
) -> tuple[ca.SX, ca.SX]:
    """The values that a body carries through `count` passes, and the row that it makes in each of them:

        c[i + 1], y[i] = body(c[i], r[i]),   i = 0, ..., count - 1

    Parameters
    ----------
    count
        The number N of passes, at least 1.
    body
        A function of c (nc, 1) and r (m, 1) that returns the next c (nc, 1) and a row y (n, 1). It is called once, with
        symbols, and may use all other symbols of the equation.
    carried
        The values c[0] (nc, 1).
    rows
        The rows r (m, N), each a column; by default none.
    backward
        True to take the rows from the last to the first. The row y[i] belongs to r[i] then, too.

    Returns
    -------
    The values c at the end (nc, 1), and the rows y (n, N).

    Raises
    ------
    ValueError
        If `count` is below 1, `rows` has another number of columns, or the next c another size.

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> end, powers = wb.bounded_loop(3, lambda c, r: (c * x, c * x), ca.SX(1))
    >>> [float(v) for v in ca.Function("f", [x], [powers])(2.0).elements()]
    [2.0, 4.0, 8.0]
    """
    N = whole("bounded_loop(count=...)", count, least=1)
    given = ca.SX(0, N) if rows is None else ca.densify(rows)
    if given.shape[1] != N:
        raise ValueError(f"`bounded_loop(rows=...)` must have a column for each of {N} passes; got {given.shape[1]}.")
    start = ca.densify(carried)
    c, r = ca.SX.sym("c", start.numel()), ca.SX.sym("r", given.shape[0])
    following, y = (ca.densify(ca.vec(ca.SX(part))) for part in body(c, r))
    if following.numel() != c.numel():
        raise ValueError(
            f"The body of a `bounded_loop` must return as many carried values as it takes, {c.numel()}; "
            f"got {following.numel()}."
        )
    own = {symbol.element_hash() for symbol in (*c.elements(), *r.elements())}
    others = [s for s in ca.symvar(ca.vertcat(following, y)) if s.element_hash() not in own]
    shared = ca.vertcat(ca.SX(0, 1), *others)
    end, made = _call(ca.Function("body", [c, r, shared], [following, y]), N, backward)(ca.vec(start), given, shared)
    return ca.SX(end), ca.SX(made)


@dataclass(frozen=True)
class LoopBody:
    """A bounded loop as it is read: its passes, their direction, and the body (c, r, shared) -> (c, y)."""

    name: str
    count: int
    backward: bool
    function: ca.Function

    @property
    def sizes(self) -> tuple[int, int, int, int]:
        """The numbers of carried values, of entries of a row, of shared values, and of entries of a row that it makes."""
        f = self.function
        return f.numel_in(0), f.numel_in(1), f.numel_in(2), f.numel_out(1)


def called_loop(function: ca.Function) -> LoopBody | None:
    """The bounded loop that a called function is; None if it is another function."""
    match = NAME.fullmatch(function.name())
    if match is None:
        return None
    count, way, digest = match.groups()
    return LoopBody(function.name(), int(count), way == "backward", function.find_function(f"{BODY}{digest}"))


def _call(body: ca.Function, count: int, backward: bool) -> ca.Function:
    """The function of (c, rows, shared) that passes a body; by its name `called_loop` knows it again."""
    sizes = repr([body.size_in(i) for i in range(body.n_in())])
    digest = fingerprint_of(sizes.encode(), body)[:16]
    symbols = body.sx_in()
    body = ca.Function(f"{BODY}{digest}", symbols, body.call(symbols, True, False))
    c, shared = ca.MX.sym("c", body.numel_in(0)), ca.MX.sym("shared", body.numel_in(2))
    rows = ca.MX.sym("rows", body.numel_in(1), count)
    order = list(range(count))[:: -1 if backward else 1]
    passes = body.mapaccum("passes", count)
    every, made = passes(c, rows[:, order], ca.repmat(shared, 1, count))
    name = f"bounded_loop_{count}_{'backward' if backward else 'forward'}_{digest}"
    return ca.Function(name, [c, rows, shared], [every[:, -1], made[:, order]], {"never_inline": True})
