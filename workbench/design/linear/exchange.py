"""An `Ode` as a system of python-control, and a linear system of python-control as an `Ode`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.core.linear import layout_of
from workbench.design.linear.arguments import names_of, places_of, row_of, time_of, vector_of
from workbench.validation.refusals import Array, described
from workbench.validation.signatures import door

if TYPE_CHECKING:
    import control


@door
def to_control(ode: Ode, p: Any = None, name: str | None = None) -> control.NonlinearIOSystem:
    """The system x' = f(t, x, u), y = h(t, x, u) of python-control, with the names of `ode`.

    The equations are evaluated by their own CasADi functions, so nothing is approximated. States,
    inputs and outputs are named number by number, as in `q[0]`; the inputs are the declared ones.

    Parameters
    ----------
    p
        The parameters (np,), each in its unit; those of the inputs are overwritten by u.
    name
        What python-control calls the system.

    Raises
    ------
    ValueError
        If p does not hold np finite numbers within their bounds.
    """
    import control

    row = row_of(ode, p)
    driven = places_of(ode)

    def with_input(u: Array) -> Array:
        values = row.copy()
        values[driven] = u
        return values

    def update(t: float, x: Array, u: Array, params: object) -> Array:
        return np.array(ode.f(t, x, with_input(u))).ravel()

    def output(t: float, x: Array, u: Array, params: object) -> Array:
        return np.array(ode.h(t, x, with_input(u))).ravel()

    return control.nlsys(update, output, name=name or ode.name, **names_of(ode))


@door
def forward_differences(ode: Ode, t: float, x: Any, p: Any = None, u: Any = None) -> control.StateSpace:
    """What python-control's own `linearize` makes of the equations, by forward differences: to be held beside ours."""
    import control

    row = row_of(ode, p, u)
    state = vector_of("x", x, ode.states)
    return control.linearize(to_control(ode, row), state, row[places_of(ode)], t=time_of(t))


@door
def from_control(system: control.StateSpace) -> Ode:
    """The linear system x' = A x + B u, y = Cy x + D u of python-control as an `Ode` with its names.

    The entries of the four matrices are parameters, and `linearize` gives them back bit by bit. Labels that count
    from zero, as q[0] and q[1], become one quantity q of that shape.

    Raises
    ------
    ValueError
        If `system` is no continuous-time `StateSpace`, if a matrix is not finite, or if a name stands for two
        quantities.
    """
    import control

    _refuse_what_is_not_linear(system, control)
    matrices = {"A": system.A, "B": system.B, "Cy": system.C, "D": system.D}
    for letter, matrix in matrices.items():
        if not np.isfinite(matrix).all():
            raise ValueError(f"`from_control(system)` must have finite matrices; {letter} of '{system.name}' is not.")
    states, inputs, outputs = map(layout_of, (system.state_labels, system.input_labels, system.output_labels))
    held = Layout(tuple(Entry(f"{system.name}.{letter}", matrix) for letter, matrix in matrices.items()))
    parameters = held + inputs
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    A, B, Cy, D = (held.view(p[: held.size])[name] for name in held.names)
    u = p[held.size :]
    ode = Ode(system.name, states, parameters, outputs, t, x, p, A @ x + B @ u, Cy @ x + D @ u)
    return replace(ode, inputs=inputs.names)


def _refuse_what_is_not_linear(system: Any, control: Any) -> None:
    if isinstance(system, control.StateSpace):
        if system.isdtime(strict=True):
            raise ValueError(
                f"`from_control(system)` must be a system in continuous time, as an `Ode` is; '{system.name}' moves in "
                f"steps of {system.dt}."
            )
        return
    if isinstance(system, control.NonlinearIOSystem):
        raise ValueError(
            "`from_control(system)` reads matrices, and a nonlinear system of python-control holds Python functions, "
            f"in which no equation can be seen; got '{system.name}'. Write its equations as an `Ode`."
        )
    if isinstance(system, control.TransferFunction | control.FrequencyResponseData):
        raise ValueError(
            f"`from_control(system)` must be a `StateSpace`, which has states; got {type(system).__name__} "
            f"'{system.name}'. Take `control.ss(system)` first."
        )
    raise ValueError(f"`from_control(system)` must be a `StateSpace` of python-control; got {described(system)}.")
