"""The gain L of a loop that is cut, that of one of its channels, and the sensitivities of the closed loop.

A loop L is a square system with negative feedback: u = -L u + w. S = (I + L)^-1 and T = I - S.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from workbench.core import Ode
from workbench.design.linear.arguments import finite, names_of, state_space
from workbench.design.linear.linear_path import LinearPath
from workbench.design.linear.linearization import linearize
from workbench.design.linear.peak_gain import Realisation
from workbench.design.matrices import Complex
from workbench.validation.refusals import Array
from workbench.validation.signatures import door

if TYPE_CHECKING:
    import control


@door
def broken_loop(ode: Ode, t: float, x: Any, p: Any = None, u: Any = None) -> control.StateSpace:
    """The loop gain L about a state of a loop that is cut: from its inputs to its outputs, with the sign turned.

    The outputs of `ode`, in their order, were its inputs before the cut, as `ClosedLoop.broken()` gives it.

    Raises
    ------
    ValueError
        As `linearize`, or if there are not as many outputs as inputs.
    """
    import control

    G = linearize(ode, t, x, p, u)
    if G.ninputs != G.noutputs:
        raise ValueError(
            f"`broken_loop(ode)` must have an output for each input, which it was before the cut; '{ode.name}' has "
            f"{G.ninputs} inputs and {G.noutputs} outputs."
        )
    return control.ss(G.A, G.B, -G.C, -G.D, name=ode.name, **names_of(ode))


@door
def broken_loops(path: LinearPath) -> tuple[control.StateSpace, ...]:
    """The loop gain L at each time of a path of a loop that is cut; it must have an output for each input."""
    import control

    if len(path.inputs) != len(path.outputs):
        raise ValueError(
            "`broken_loops(path)` must have an output for each input, which it was before the cut; got "
            f"{len(path.inputs)} inputs and {len(path.outputs)} outputs."
        )
    frozen = zip(path.A, path.B, path.Cy, path.D, strict=True)
    return tuple(control.ss(A, B, -Cy, -D) for A, B, Cy, D in frozen)


@door
def one_loop(loop: control.StateSpace, place: int) -> control.StateSpace:
    """The gain of one channel of a loop L while all others are closed.

    Raises
    ------
    ValueError
        If `loop` is no square, continuous `StateSpace`.
    LookupError
        If there is no such channel; the first is 0.
    """
    import control

    L = matrices_of("one_loop", loop)
    if place not in range(loop.ninputs):
        raise LookupError(f"`one_loop(place=...)` counts from 0 to {loop.ninputs - 1}; got {place!r}.")
    own = alone(L, place)
    names = {"states": loop.state_labels, "inputs": [loop.input_labels[place]], "outputs": [loop.output_labels[place]]}
    return control.ss(own.A, own.B, own.C, own.D, **names)


@door
def sensitivity(loop: control.StateSpace) -> control.StateSpace:
    """S = (I + L)^-1, from disturbances added at the inputs to the inputs; its poles are those of the closed loop.

    Raises
    ------
    ValueError
        If `loop` is no square, continuous `StateSpace`, or I + D is singular.
    """
    import control

    S = closed(matrices_of("sensitivity", loop))
    names = {"states": loop.state_labels, "inputs": loop.input_labels, "outputs": loop.input_labels}
    return control.ss(S.A, S.B, S.C, S.D, **names)


@door
def frequency_response(system: control.StateSpace, frequencies: Array) -> Complex:
    """The response of a system at frequencies (N,) in rad/s, by python-control: (N, ny, nu)."""
    import control

    state_space("frequency_response", system)
    omega = finite("frequencies", frequencies, (np.size(frequencies),))
    response = control.frequency_response(system, omega, squeeze=False)
    return np.moveaxis(np.asarray(response.frdata), -1, 0)


def closed(L: Realisation) -> Realisation:
    """S = (I + L)^-1."""
    eye = np.eye(L.D.shape[0])
    if np.linalg.cond(eye + L.D) > 1e12:
        raise ValueError("A loop L must have a regular I + D to be closed; that of this one is singular.")
    E = np.asarray(np.linalg.inv(eye + L.D), dtype=float)
    return Realisation(L.A - L.B @ E @ L.C, L.B @ E, -E @ L.C, E)


def alone(L: Realisation, i: int) -> Realisation:
    """Channel i of the loop while all others are closed."""
    rest = [j for j in range(L.B.shape[1]) if j != i]
    E = np.linalg.inv(np.eye(len(rest)) + L.D[np.ix_(rest, rest)])
    B, C, own = L.B[:, rest] @ E, L.C[rest], [i]
    return Realisation(
        L.A - B @ C,
        L.B[:, own] - B @ L.D[np.ix_(rest, own)],
        L.C[own] - L.D[np.ix_(own, rest)] @ E @ C,
        L.D[np.ix_(own, own)] - L.D[np.ix_(own, rest)] @ E @ L.D[np.ix_(rest, own)],
    )


def matrices_of(call: str, loop: control.StateSpace) -> Realisation:
    """The matrices of a square system in continuous time; anything else is refused."""
    matrices = state_space(call, loop)
    if loop.isdtime(strict=True) or loop.ninputs != loop.noutputs:
        raise ValueError(
            f"`{call}(loop)` must be a square `StateSpace` in continuous time, one output for each input; got "
            f"{loop.noutputs} by {loop.ninputs}, dt = {loop.dt}."
        )
    return Realisation(*matrices)
