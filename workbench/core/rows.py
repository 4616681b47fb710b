"""Rows: a CasADi function at many points, through buffers, which cost a quarter of CasADi's own matrices."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from workbench.core.numbers import Array


def rows(function: ca.Function, *arguments: Array) -> Array:
    """The values of a function at n points, each flat, column by column: (n, size).

    Parameters
    ----------
    arguments
        (n, size) each; one of a single row serves all points.
    """
    n = max(map(len, arguments))
    if function.nnz_out(0) < function.numel_out(0):  # a buffer would get what is not zero alone
        symbols = function.sx_in()
        function = ca.Function(function.name(), symbols, [ca.densify(function(*symbols))])
    values = np.zeros((n, function.numel_out(0)))
    if n == 0 or values.size == 0:
        return values
    buffer: Any
    buffer, evaluate = function.map(n).buffer()
    held = [np.array(np.broadcast_to(a, (n, a.shape[1])), dtype=float, order="C") for a in arguments]
    for i, part in enumerate(held):
        if part.size:
            buffer.set_arg(i, memory(part))
    buffer.set_res(0, memory(values))
    evaluate()
    return values


def memory(place: Any) -> Any:
    """An array as CasADi's buffers take it; whoever hands it over must hold it."""
    return memoryview(place)
