"""What the calls of this room are given: times, states, parameters and inputs of an `Ode`, checked by name."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.core import Layout, Ode
from workbench.design.matrices import LARGEST
from workbench.validation.refusals import Array, as_array, described, require


def names_of(ode: Ode) -> dict[str, list[str]]:
    """The names of states, inputs and outputs, number by number; a column of one number goes by its own name."""
    ports = {"states": ode.states, "inputs": inputs_of(ode), "outputs": ode.outputs}
    return {
        port: [n for e in own.entries for n in (e.labels() if e.size > 1 else [e.name])] for port, own in ports.items()
    }


def inputs_of(ode: Ode) -> Layout:
    """The declared inputs, in their order."""
    return Layout(tuple(ode.parameters[name] for name in ode.inputs))


def places_of(ode: Ode) -> list[int]:
    """Where the numbers of u lie in p."""
    return [place for name in ode.inputs for place in ode.parameters.indices(name)]


def row_of(ode: Ode, p: Any, u: Any = None) -> Array:
    """A copy of p (np,), the defaults if it is None, with u (nu,) in its places unless that is None."""
    require("ode", ode, Ode)
    row = ode.parameters.default if p is None else vector_of("p", p, ode.parameters)
    if u is not None:
        row[places_of(ode)] = vector_of("u", u, inputs_of(ode))
    ode.parameters.check(row[np.newaxis])
    return row


def vector_of(what: str, value: Any, layout: Layout) -> Array:
    """A vector with a number for each label of the layout."""
    return finite(what, value, (layout.size,), f": {', '.join(layout.labels)}" if layout.size < 9 else "")


def time_of(t: Any) -> float:
    """A finite time in s."""
    return float(finite("t", t, ()))


def finite(what: str, value: Any, shape: tuple[int, ...], hint: str = "") -> Array:
    """The value as a new array of that shape, every number finite and its square too."""
    want = f"{shape[0]} finite numbers{hint}" if shape else "a finite number of seconds"
    array = as_array(value)
    if array is None:
        raise ValueError(f"`{what}` must be {want}; got {described(value)}.")
    if array.shape != shape or not (np.abs(array) < LARGEST).all():
        size = f" below {LARGEST:g} in size" if np.isfinite(array).all() and array.shape == shape else ""
        raise ValueError(f"`{what}` must be {want}{size}; got {described(array.tolist())} of shape {array.shape}.")
    return array


def jacobians(call: str, ode: Ode, t: float, x: Array, p: Array) -> tuple[Array, Array, Array, Array]:
    """A, B, Cy and D at a point, or a refusal where the equations have no derivative."""
    matrices = tuple(np.array(J(t, x, p)) for J in (ode.A, ode.B, ode.Cy, ode.D))
    rates = [f"the rate of '{label}'" for label in ode.states.labels]
    rows, columns = (rates, [repr(label) for label in ode.outputs.labels]), (ode.states.labels, inputs_of(ode).labels)
    for k, (letter, matrix) in enumerate(zip(("A", "B", "Cy", "D"), matrices, strict=True)):
        for i, j in np.argwhere(~np.isfinite(matrix))[:1]:
            raise ValueError(
                f"`{call}(...)`: {letter} is not finite at t = {t:g}, x = {x.tolist()}: {rows[k // 2][i]} has no "
                f"derivative by '{columns[k % 2][j]}' there; linearise at another state."
            )
    A, B, Cy, D = matrices
    return A, B, Cy, D
