"""CasADi functions as functions of NumPy arrays, without the cost of their conversions."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.core.expressions import buffer_of, memory
from workbench.core.validation.refusals import Array


class CompiledFunction:
    """A CasADi function whose arguments and results are arrays; a result is valid until the next call."""

    def __init__(self, name: str, arguments: list[ca.SX], results: list[ca.SX], columns: int = 1) -> None:
        """With several columns, the first argument changes from column to column, and so does the one result."""
        dense = ca.Function(name, arguments, [ca.densify(result) for result in results], {"cse": True})
        if columns > 1:
            dense = dense.map(name, "serial", columns, list(range(1, len(arguments))), [])
        self._places = [np.zeros((dense.size2_in(i), dense.size1_in(i))) for i in range(dense.n_in())]
        self._results = [np.zeros((dense.size2_out(i), dense.size1_out(i))) for i in range(dense.n_out())]
        self._buffer, self._evaluate = buffer_of(dense)
        for i, place in enumerate(self._places):
            if place.size:
                self._buffer.set_arg(i, memory(place))
        for i, place in enumerate(self._results):
            if place.size:
                self._buffer.set_res(i, memory(place))
        self._flat = [place.reshape(-1) for place in self._places]
        self._views = tuple(result.T for result in self._results)

    def __call__(self, *arguments: Array) -> tuple[Array, ...]:
        """The results (rows, columns) at columns of numbers, or at matrices (rows, columns) in the first argument."""
        for place, argument in zip(self._flat, arguments, strict=False):
            place[:] = argument if argument.ndim == 1 else argument.T.reshape(-1)
        self._evaluate()
        return self._views
