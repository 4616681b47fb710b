"""Rows: a CasADi function at many points, through buffers, which cost a quarter of CasADi's own matrices."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from workbench.validation.doors import door
from workbench.validation.words import Array

AT_ONCE = 64  # points: CasADi writes down the pattern of all that are mapped, for thousands longer than their values


@door
def rows(function: ca.Function, *arguments: Array) -> Array:
    """The values of a function at n points, each flat, column by column: (n, size).

    Parameters
    ----------
    arguments
        (n, size) each; one of a single row serves all points.
    """
    sizes = [function.numel_in(i) for i in range(function.n_in())]
    n = max((len(a) for a in arguments if a.ndim == 2), default=0)
    if [a.shape[1:] for a in arguments] != [(size,) for size in sizes] or {len(a) for a in arguments} - {n, 1}:
        raise ValueError(
            f"`rows(function, ...)` takes arrays (n, {sizes}), or of a single row; got shapes "
            f"{[a.shape for a in arguments]}."
        )
    if function.nnz_out(0) < function.numel_out(0):  # a buffer would get what is not zero alone
        symbols = function.sx_in()
        function = ca.Function(function.name(), symbols, [ca.densify(function(*symbols))])
    side = min(n, AT_ONCE)
    if n == 0 or function.numel_out(0) == 0:
        return np.zeros((n, function.numel_out(0)))
    places = np.minimum(np.arange(-(-n // side) * side), n - 1)
    values = np.zeros((len(places), function.numel_out(0)))
    held = [np.array(np.broadcast_to(a, (n, a.shape[1]))[places], dtype=float, order="C") for a in arguments]
    buffer: Any
    buffer, evaluate = function.map(side).buffer()
    for first in range(0, len(places), side):
        for i, part in enumerate(held):
            if part.size:
                buffer.set_arg(i, memory(part[first : first + side]))
        buffer.set_res(0, memory(values[first : first + side]))
        evaluate()
    return values[:n]


def memory(place: Any) -> Any:
    """An array as CasADi's buffers take it; whoever hands it over must hold it."""
    return memoryview(place)
