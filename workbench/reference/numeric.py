"""A CasADi function of (t, x) on arrays, through buffers: a tenth of the price of a call with CasADi's own types."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from workbench.core.expressions import memory
from workbench.validation.refusals import Array


class Numeric:
    """A function of (t, x) whose result is a dense matrix; each call gives a new array. Not for two threads at once."""

    def __init__(self, function: ca.Function) -> None:
        arguments = [ca.MX.sym("a", *function.size_in(i)) for i in range(2)]
        dense = ca.Function(function.name(), arguments, [ca.densify(function(*arguments))])
        self.shape = dense.size_out(0)
        self.arguments = [np.zeros(dense.numel_in(i)) for i in range(2)]
        self.result = np.zeros(dense.numel_out(0))
        # held by this object, as what runs the buffer does not keep it alive
        buffer: Any
        buffer, self.run = dense.buffer()
        for i, place in enumerate(self.arguments):
            buffer.set_arg(i, memory(place))
        buffer.set_res(0, memory(self.result))
        self.buffer = buffer

    def __call__(self, t: float | Array, x: Array) -> Array:
        """The value at (t, x)."""
        self.arguments[0][:] = np.ravel(t)
        self.arguments[1][:] = np.ravel(x, order="F")
        self.run()
        return self.result.reshape(self.shape, order="F").copy()
