"""The arguments of this room's calls: times, states, parameters and inputs of an `Ode`, and Jacobians."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode
from workbench.design.matrices import LARGEST
from workbench.notation.program import walk
from workbench.proofs.interval import jumps
from workbench.validation.refusals import Array, as_array, described, refusal, require

ON_IT = 1e-12  # a switching function smaller than this share of the state counts as zero
JUMP = 1e-9  # the least difference of two rates, relative to their size, that counts as a jump


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
    """The places of the numbers of u in p."""
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


def refuse_jump_at(call: str, ode: Ode, t: float, x: Array, p: Array) -> None:
    """Refuse a point at which a rate or an output jumps; one at which it only bends, as |s| does, is let pass."""
    n, driven = ode.states.size, places_of(ode)
    z = ca.vertcat(ode.x, ode.p[driven])
    both = ca.densify(ca.vertcat(ode.rate, ode.output))
    if not jumps(walk(both), [symbol.name() for symbol in ca.vertsplit(z)]):
        return
    function = ca.Function("both", [ode.t, ode.x, ode.p], [both, ca.densify(ca.jacobian(both, z))])
    at = np.concatenate([x, p[driven]])
    reach = ON_IT * (1 + np.abs(at))
    labels = [f"'{label}' changes" for label in (*ode.states.labels, *inputs_of(ode).labels)]
    # all at once too, in no special direction: sign(x1 x2) jumps along neither axis
    across = np.vstack([np.diag(reach), reach * np.cos(np.arange(1.0, len(at) + 1))])
    for direction, label in zip(across, [*labels, "all of them change"], strict=True):
        moves, heights, slopes = direction != 0, [], []
        for side in (-1, 0, 1):
            row, moved = p.copy(), at + side * direction
            row[driven] = moved[n:]
            height, slope = (np.array(part) for part in function(t, moved[:n], row))
            heights.append(height.ravel())
            slopes.append(np.abs(slope[:, moves]) @ np.abs(direction[moves]))
        change = np.ptp(heights, axis=0) - 4 * np.maximum(slopes[0], slopes[2])
        if change.max() > JUMP * (1 + np.abs(heights[0]).max()):
            names = (*(f"the rate of '{label}'" for label in ode.states.labels), *map(repr, ode.outputs.labels))
            raise ValueError(
                f"`{call}(...)`: {names[int(change.argmax())]} jumps by {change.max():.3g} as {label} at this state, "
                f"so it has no linear model there; take another state, another input or {smooth(ode)}."
            )


def smooth(ode: Ode) -> str:
    """The advice on smooth replacements of a jump."""
    friction = any(name.endswith(".coulomb") for name in ode.parameters.names)
    return f"a continuous saturation{' (of friction from a file: `friction_speed=...`)' if friction else ''}"


def state_space(call: str, system: Any) -> tuple[Array, Array, Array, Array]:
    """A, B, C and D of a `StateSpace` of python-control, all finite."""
    import control

    if not isinstance(system, control.StateSpace):
        raise refusal(f"{call}(system=...)", "a `StateSpace` of python-control, as `linearize` gives", system)
    A, B, C, D = (np.asarray(matrix, dtype=float) for matrix in (system.A, system.B, system.C, system.D))
    if not all(np.isfinite(matrix).all() for matrix in (A, B, C, D)):
        raise ValueError(f"`{call}(system=...)` must have finite matrices; '{system.name}' has not.")
    return A, B, C, D
