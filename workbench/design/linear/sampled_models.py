"""Sampled state spaces with names, units and an operating point, from matrices that were computed elsewhere."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from workbench.core import Entry, Layout
from workbench.core.point import OperatingPoint
from workbench.core.validation.refusals import Array, matrix, seconds, vector
from workbench.core.validation.signatures import check_arguments

if TYPE_CHECKING:
    import control


@check_arguments
def sampled_model(
    A: Array,
    B: Array,
    Cy: Array,
    D: Array,
    period: float,
    inputs: Layout,
    outputs: Layout,
    u0: Array,
    y0: Array,
    name: str = "model",
) -> control.StateSpace:
    """The system x+ = A x + B (u - u0), y = y0 + Cy x + D (u - u0) of python-control, with its operating point.

    Parameters
    ----------
    A, B, Cy, D
        (nx, nx), (nx, nu), (ny, nx) and (ny, nu).
    period
        The period in s.
    inputs, outputs
        Names and units of u and y.
    u0, y0
        (nu,) and (ny,), the inputs and outputs at which x = 0 rests.
    name
        The name of the system.

    Raises
    ------
    ValueError
        If a shape does not fit, or a number is not finite.

    Examples
    --------
    >>> u, y = (wb.Layout((wb.core.Entry(name, np.zeros(()), "V"),)) for name in ("u", "y"))
    >>> wb.linear.sampled_model([[0.5]], [[1.0]], [[1.0]], [[0.0]], 0.1, u, y, [2.0], [4.0]).dt
    0.1
    """
    import control

    from workbench.design.linear.pointed_systems import PointedSpace

    call = "sampled_model({}=...)"
    a = matrix(call.format("A"), A)
    nx, nu, ny = len(a), inputs.size, outputs.size
    a = matrix(call.format("A"), A, nx, nx)
    b, c = matrix(call.format("B"), B, nx, nu), matrix(call.format("Cy"), Cy, ny, nx)
    d = matrix(call.format("D"), D, ny, nu)
    states = Layout((Entry("x", np.zeros(nx), "?"),)) if nx else Layout()
    names = {"states": list(states.labels), "inputs": list(inputs.labels), "outputs": list(outputs.labels)}
    space = control.ss(a, b, c, d, seconds(call.format("period"), period), name=name, **names)
    rest = vector(call.format("u0"), u0, nu, "inputs"), vector(call.format("y0"), y0, ny, "outputs")
    return PointedSpace(space, OperatingPoint(states, inputs, outputs, np.zeros(nx), *rest))
