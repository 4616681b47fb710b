"""The door to python-control: an `Ode` as its nonlinear system, or linearised at a state."""

from __future__ import annotations

from typing import Any

import control
import numpy as np

from workbench.core import Layout, Ode
from workbench.core.layout import Array, numbers


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
    row = _parameters(ode, p)
    driven = _places(ode)

    def with_input(u: Array) -> Array:
        values = row.copy()
        values[driven] = u
        return values

    def update(t: float, x: Array, u: Array, params: object) -> Array:
        return np.array(ode.f(t, x, with_input(u))).ravel()

    def output(t: float, x: Array, u: Array, params: object) -> Array:
        return np.array(ode.h(t, x, with_input(u))).ravel()

    return control.nlsys(update, output, name=name or ode.name, **_names(ode))


def linearize(ode: Ode, t: float, x: Any, p: Any = None, u: Any = None) -> control.StateSpace:
    """The linear system dx' = A dx + B du, dy = Cy dx + D du about a state, with the names of `ode`.

    A, B, Cy and D are the exact Jacobians of the equations at (t, x, p, u), of shapes (nx, nx),
    (nx, nu), (ny, nx) and (ny, nu). Whether the state is an equilibrium is not asked. On the corner of a
    saturation or of |s| they are those of one of the smooth pieces that meet there.

    Parameters
    ----------
    t
        Time in s.
    x
        The state (nx,), each number in its unit.
    p
        The parameters (np,).
    u
        The inputs (nu,), which overwrite theirs in p.

    Raises
    ------
    ValueError
        If t, x, p or u is not of its size or not finite, if `ode` declares no inputs or has no outputs (a
        python-control `StateSpace` has at least one of each), or if a Jacobian is not finite.
    """
    for what, size in (("input", len(ode.inputs)), ("output", ode.outputs.size)):
        if size == 0:
            raise ValueError(
                f"`linearize(ode)` needs at least one {what}, as python-control's `StateSpace` does; "
                f"'{ode.name}' has none. Take `ode.A(t, x, p)` for the matrix A alone."
            )
    row, state = _parameters(ode, p), _vector("x", x, ode.states)
    if u is not None:
        row[_places(ode)] = _vector("u", u, _inputs(ode))
        ode.parameters.check(row[np.newaxis])
    time = float(_finite("t", t, ()))
    matrices = [np.array(J(time, state, row)) for J in (ode.A, ode.B, ode.Cy, ode.D)]
    for letter, matrix in zip(("A", "B", "Cy", "D"), matrices, strict=True):
        if not np.isfinite(matrix).all():
            raise ValueError(
                f"`linearize(...)`: {letter} is not finite at t = {time:g}, x = {state.tolist()}, so the equations "
                "have no derivative there; linearise at another state."
            )
    return control.ss(*matrices, name=ode.name, **_names(ode))


def _names(ode: Ode) -> dict[str, list[str]]:
    return {
        "states": list(ode.states.labels),
        "inputs": list(_inputs(ode).labels),
        "outputs": list(ode.outputs.labels),
    }


def _inputs(ode: Ode) -> Layout:
    """The declared inputs, in their order."""
    return Layout(tuple(ode.parameters[name] for name in ode.inputs))


def _places(ode: Ode) -> list[int]:
    """Where the numbers of u lie in p."""
    return [place for name in ode.inputs for place in ode.parameters.indices(name)]


def _parameters(ode: Ode, p: Any) -> Array:
    """A copy of p (np,), the defaults if it is None."""
    row = ode.parameters.default if p is None else _vector("p", p, ode.parameters)
    ode.parameters.check(row[np.newaxis])
    return row


def _vector(what: str, value: Any, layout: Layout) -> Array:
    return _finite(what, value, (layout.size,), f": {', '.join(layout.labels)}" if layout.size < 9 else "")


def _finite(what: str, value: Any, shape: tuple[int, ...], hint: str = "") -> Array:
    """The value as a new array of that shape, every number finite."""
    want = f"{shape[0]} finite numbers{hint}" if shape else "a finite number of seconds"
    try:
        array = numbers(value)
    except (TypeError, ValueError):
        raise ValueError(f"`{what}` must be {want}; got {value!r}.") from None
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError(f"`{what}` must be {want}; got {array.tolist()} of shape {array.shape}.")
    return array
