"""The gain of one channel of a loop L while the others are closed, the sensitivity, and the largest gain of a system.

A loop L is a square system with negative feedback: u = -L u + w. S = (I + L)^-1 and T = I - S.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, numbers, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import Complex, DesignError

if TYPE_CHECKING:
    import control

TOLERANCE = 1e-6  # relative, between what is proved and what is reached
ROUNDS = 60


@check_arguments
def one_loop(loop: control.StateSpace, place: int) -> control.StateSpace:
    """The gain of one channel of a loop L while all others are closed.

    Raises
    ------
    ValueError
        If `loop` is not a square, continuous `StateSpace`.
    LookupError
        If there is no such channel; the first is 0.
    """
    import control

    A, B, C, D = square_loop("one_loop", loop)
    if place not in range(loop.ninputs):
        raise LookupError(f"`one_loop(place=...)` counts from 0 to {loop.ninputs - 1}; got {place!r}.")
    own, rest = [place], [j for j in range(loop.ninputs) if j != place]
    E = np.linalg.inv(np.eye(len(rest)) + D[np.ix_(rest, rest)])
    B_rest, C_rest = B[:, rest] @ E, C[rest]
    across = D[np.ix_(own, rest)] @ E
    return control.ss(
        A - B_rest @ C_rest,
        B[:, own] - B_rest @ D[np.ix_(rest, own)],
        C[own] - across @ C_rest,
        D[np.ix_(own, own)] - across @ D[np.ix_(rest, own)],
        states=loop.state_labels,
        inputs=[loop.input_labels[place]],
        outputs=[loop.output_labels[place]],
    )


@check_arguments
def sensitivity(loop: control.StateSpace) -> control.StateSpace:
    """S = (I + L)^-1, from disturbances added at the inputs to the inputs; its poles are those of the closed loop.

    Raises
    ------
    ValueError
        If `loop` is not a square, continuous `StateSpace`, or I + D is singular.
    """
    import control

    A, B, C, D = square_loop("sensitivity", loop)
    eye = np.eye(len(D))
    if np.linalg.cond(eye + D) > 1e12:
        raise ValueError("A loop L must have a regular I + D to be closed; that of this one is singular.")
    E = np.asarray(np.linalg.inv(eye + D), dtype=float)
    names = {"states": loop.state_labels, "inputs": loop.input_labels, "outputs": loop.input_labels}
    return control.ss(A - B @ E @ C, B @ E, -E @ C, E, **names)


def complementary_sensitivity(loop: control.StateSpace | control.TransferFunction) -> System:
    """T = L (I + L)^-1 of a square system L of python-control, continuous or discrete, in the form that L has."""
    import control

    if loop.ninputs != loop.noutputs:
        raise ValueError(
            f"A loop gain L must be square to be closed; got {loop.noutputs} outputs and {loop.ninputs} inputs."
        )
    return control.feedback(loop, np.eye(loop.ninputs) if loop.ninputs > 1 else 1)


@check_arguments
def frequency_response(system: control.StateSpace, frequencies: Array) -> Complex:
    """The response of a system at frequencies (N,) in rad/s, by python-control: (N, ny, nu).

    Examples
    --------
    >>> import control
    >>> from workbench.design.linear import frequency_response
    >>> frequency_response(control.ss(-1.0, 1.0, 1.0, 0.0), [1.0, 2.0]).ravel().round(3)
    array([0.5-0.5j, 0.2-0.4j])
    """
    import control

    state_space("frequency_response", system)
    omega = numbers("frequency_response(frequencies=...)", frequencies, 1)
    if not np.isfinite(omega).all():
        raise refusal("frequency_response(frequencies=...)", "a vector of finite numbers", frequencies)
    response = control.frequency_response(system, omega, squeeze=False)
    return np.moveaxis(np.asarray(response.frdata), -1, 0)


def square_loop(call: str, loop: control.StateSpace) -> tuple[Array, Array, Array, Array]:
    """The matrices of a square system in continuous time; anything else is refused."""
    matrices = state_space(call, loop)
    if loop.isdtime(strict=True) or loop.ninputs != loop.noutputs:
        raise ValueError(
            f"`{call}(loop)` must be a square `StateSpace` in continuous time, one output for each input; got "
            f"{loop.noutputs} by {loop.ninputs}, dt = {loop.dt}."
        )
    return matrices


def response_at(G: control.StateSpace, frequencies: Array) -> Complex:
    """C (i omega - A)^-1 B + D at many frequencies (N,) in rad/s at once: (N, ny, nu)."""
    points = 1j * np.asarray(frequencies)[:, np.newaxis, np.newaxis] * np.eye(len(G.A)) - G.A
    return np.asarray(G.C @ np.linalg.solve(points, np.broadcast_to(G.B, (len(points), *G.B.shape))) + G.D)


def pole_frequencies(G: control.StateSpace, count: int) -> Array:
    """Frequencies in rad/s, spread by powers from far below the slowest pole to far above the fastest."""
    sizes = np.abs(np.linalg.eigvals(G.A))
    sizes = sizes[sizes > 1e-9 * sizes.max(initial=0.0)]
    low, high = (float(sizes.min()), float(sizes.max())) if sizes.size else (1.0, 1.0)
    return np.geomspace(low / 100, 100 * high, count)


@dataclass(frozen=True)
@show
class PeakGain:
    """The largest gain of a system: it is reached, `below`, at a frequency in rad/s, and nowhere beyond `above`."""

    below: float
    above: float
    frequency: float


def largest_gain(G: control.StateSpace, response: Callable[[Array], Complex] | None = None) -> PeakGain:
    """The H-infinity norm of a stable system: the largest singular value of G(i omega), which `response` may give.

    References
    ----------
    Bruinsma and Steinbuch (1990), Systems & Control Letters 14, section 3.
    """
    response = response or (lambda frequencies: response_at(G, frequencies))
    seen = np.concatenate([[0.0], pole_frequencies(G, 60), np.abs(np.linalg.eigvals(G.A).imag)])
    below, frequency = _highest(response, seen)
    at_infinity = float(np.linalg.norm(G.D, 2))
    if at_infinity > below:
        below, frequency = at_infinity, float("inf")
    if not below:
        return PeakGain(0.0, 0.0, 0.0)
    for _ in range(ROUNDS):
        gamma = (1 + TOLERANCE) * below
        crossings = crossings_of(G, gamma)
        middles = np.concatenate([crossings, (crossings[1:] + crossings[:-1]) / 2])
        found, at = _highest(response, middles) if len(middles) else (0.0, 0.0)
        if found <= gamma:
            return PeakGain(below, gamma, frequency)
        below, frequency = found, at
    raise DesignError("The largest gain over all frequencies was not found: the eigenvalues are too rough.")


def largest_state_gain(A: Array, B: Array) -> PeakGain:
    """The largest gain over all frequencies from u to x of the stable system x' = A x + B u."""
    import control  # takes seconds

    return largest_gain(control.ss(A, B, np.eye(len(A)), np.zeros_like(B)))


def _highest(response: Callable[[Array], Complex], frequencies: Array) -> tuple[float, float]:
    sizes = np.linalg.norm(response(frequencies), 2, axis=(-2, -1))
    best = int(np.argmax(sizes))
    return float(sizes[best]), float(frequencies[best])


def crossings_of(G: control.StateSpace, gamma: float) -> Array:
    """The frequencies at which a singular value of G may equal gamma, in order, perhaps with some others."""
    A, B, C, D = G.A, G.B, G.C, G.D
    R = np.linalg.inv(gamma**2 * np.eye(D.shape[1]) - D.T @ D)
    F = A + B @ R @ D.T @ C
    H = np.block([[F, B @ R @ B.T], [-C.T @ (np.eye(len(C)) + D @ R @ D.T) @ C, -F.T]])
    values = np.linalg.eigvals(H)
    # a double eigenvalue on the axis may be moved off it by the root of rounding
    near = np.abs(values.real) <= 1e-6 * (np.abs(values) + 1e-3 * np.abs(values).max(initial=0.0))
    return np.unique(np.abs(values.imag[near]))
