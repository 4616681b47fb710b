"""Linear models along a path: A(t), B(t), Cy(t), D(t), their frozen eigenvalues, and the state-transition matrix."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.core import Ode, with_sensitivity
from workbench.design.linear.arguments import inputs_of, jacobians, row_of, vector_of
from workbench.design.linear.smoothness import refuse_jumps
from workbench.design.matrices import LARGEST, Complex
from workbench.validation.refusals import Array, as_array, described, numbers
from workbench.validation.signatures import door
from workbench.validation.views import show


@dataclass(frozen=True, eq=False)
@show
class LinearPath:
    """The linear system dx' = A(t) dx + B(t) du, dy = Cy(t) dx + D(t) du about a motion, at N times.

    Attributes
    ----------
    t, x
        (N,) in s, and (N, nx).
    A, B, Cy, D
        (N, nx, nx), (N, nx, nu), (N, ny, nx) and (N, ny, nu).
    states, inputs, outputs
        The names, number by number.
    """

    t: Array
    x: Array
    A: Array
    B: Array
    Cy: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def eigenvalues(self) -> Complex:
        """The eigenvalues of A at each frozen time, (N, nx), the slowest to decay first.

        They say how a small deviation begins to move, and prove nothing of how it ends: a system may grow though each
        of its frozen eigenvalues decays, and the other way round.
        """
        values = np.linalg.eigvals(self.A).astype(complex)
        order = np.lexsort((-values.imag, -np.round(values.real, 9)), axis=-1)
        return np.asarray(np.take_along_axis(values, order, axis=-1))

    def contraction(self, metric: Any = None) -> Array:
        """The greatest rate (N,), in 1/s, at which |x|_W of any deviation may grow at each time: the log norm of A.

        Where it stays below -c, all deviations shrink as exp(-c t) or faster.

        Parameters
        ----------
        metric
            W (nx, nx), symmetric and positive definite, of |x|_W = sqrt(x' W x); the identity unless given.

        Raises
        ------
        ValueError
            If W is not such a matrix.
        """
        root, inverse = _root(metric, self.A.shape[-1])
        A = root @ self.A @ inverse
        return np.asarray(np.linalg.eigvalsh((A + np.swapaxes(A, -1, -2)) / 2)[..., -1])


@door
def along(ode: Ode, t: Any, x: Any, p: Any = None, box: Mapping[str, tuple[float, float]] | None = None) -> LinearPath:
    """The linear models of an `Ode` at the states of a motion.

    Parameters
    ----------
    t, x
        Times (N,), increasing, in s, and states (N, nx): those of a simulation, say.
    p
        The parameters (np,), or (N, np) where inputs change along the path.
    box
        Low and high of states, by the name of a quantity or one of its numbers, that the path must not leave.

    Raises
    ------
    ValueError
        If times and states do not fit or are not finite, a Jacobian is not finite, or the path leaves the box: state,
        time and bound are named.
    LookupError
        If the box names no state.
    """
    times, states = numbers("along(t=...)", t), numbers("along(x=...)", x)
    if times.ndim != 1 or states.shape != (len(times), ode.states.size) or not len(times):
        raise ValueError(
            f"`along(t, x)` must be N times and states (N, {ode.states.size}); got shapes {times.shape} and "
            f"{states.shape}."
        )
    if not (np.isfinite(times).all() and np.isfinite(states).all() and (times[1:] > times[:-1]).all()):
        raise ValueError("`along(t, x)` must be finite numbers, and times that increase; a run may have diverged.")
    _refuse_to_leave(ode, times, states, box or {})
    table = as_array(p)
    table = table if table is not None and table.ndim == 2 else None
    if table is not None and len(table) != len(times):
        raise ValueError(f"`along(p=...)` must have a row for each of the {len(times)} times; got {len(table)}.")
    rows = [row_of(ode, row) for row in ([p] if table is None else table)]
    matrices = [
        jacobians("along", ode, float(time), state, rows[0 if table is None else k])
        for k, (time, state) in enumerate(zip(times, states, strict=True))
    ]
    A, B, Cy, D = (np.stack(kind) for kind in zip(*matrices, strict=True))
    names = (ode.states.labels, inputs_of(ode).labels, ode.outputs.labels)
    return LinearPath(times, states, A, B, Cy, D, *names)


def _refuse_to_leave(ode: Ode, t: Array, x: Array, box: Mapping[str, tuple[float, float]]) -> None:
    """Refuse a path at the first time that a state is beyond a bound."""
    first: tuple[int, int, float] | None = None
    for name, ends in box.items():
        low, high = _bounds(name, ends)
        for i in ode.states.indices(name):
            beyond = np.flatnonzero((x[:, i] < low) | (x[:, i] > high))
            if beyond.size and (first is None or beyond[0] < first[0]):
                first = int(beyond[0]), i, low if x[beyond[0], i] < low else high
    if first is not None:
        k, i, bound = first
        raise ValueError(
            f"`along(box=...)` must hold the whole path; '{ode.states.labels[i]}' = {x[k, i]:g} is beyond {bound:g} at "
            f"t = {t[k]:g} s. Widen the box, or end the path earlier."
        )


def _bounds(name: str, ends: Any) -> tuple[float, float]:
    low, high = ends
    if not low < high:
        raise ValueError(f"`along(box=...)`: '{name}' must be (low, high), low < high; got {described(ends)}.")
    return low, high


@dataclass(frozen=True, eq=False)
@show
class Transition:
    """The state-transition matrix Phi(t, 0) along a motion, at N times.

    Attributes
    ----------
    t, x, Phi
        (N,) in s, (N, nx), and (N, nx, nx): Phi(t, 0) is the derivative of x(t) by x(0).
    error
        (N,), the largest error of an entry of Phi by the estimate of the reference mode.
    """

    t: Array
    x: Array
    Phi: Array
    error: Array

    def contraction(self, metric: Any = None) -> Array:
        """The greatest factor (N,) by which |x|_W of a small deviation at time 0 has changed: the norm of Phi.

        Parameters
        ----------
        metric
            W (nx, nx), symmetric and positive definite, of |x|_W = sqrt(x' W x); the identity unless given.

        Raises
        ------
        ValueError
            If W is not such a matrix.
        """
        root, inverse = _root(metric, self.Phi.shape[-1])
        return np.asarray(np.linalg.norm(root @ self.Phi @ inverse, 2, axis=(-2, -1)))


@door
def transition(ode: Ode, times: Any, p: Any = None, x0: Any = None, *, rtol: float = 1e-9) -> Transition:
    """Phi(t, 0) along the solution from x0: Phi' = A(t) Phi, Phi(0) = I, by the reference mode.

    Across a corner of f, as that of a saturation, Phi is continuous and right. Where f jumps it would miss the jump
    that Phi has there, so such equations are refused.

    Parameters
    ----------
    times
        (N,), increasing, from 0 on, in s.
    rtol
        The relative tolerance of the integration.

    Raises
    ------
    ValueError
        If the rate may jump as the states change, or the reference mode refuses.
    """
    from workbench.reference import reference  # half a second, which few callers of this room need

    row = row_of(ode, p)
    refuse_jumps("transition", ode, row)
    start = ode.states.default if x0 is None else vector_of("x0", x0, ode.states)
    nx = ode.states.size
    both = with_sensitivity(ode, ode.states.names)
    extended = np.concatenate([start, np.eye(nx).ravel()])
    t = np.atleast_1d(numbers("transition(times=...)", times))
    if not (np.abs(t) < LARGEST).all():
        raise ValueError(f"`transition(times=...)` must be finite numbers of seconds; got {described(times)}.")
    run = reference(both, row, extended, times=t, rtol=rtol, atol=rtol * 1e-2)
    Phi = np.swapaxes(run.x[:, nx:].reshape(-1, nx, nx), -1, -2)
    return Transition(run.t, run.x[:, :nx], Phi, run.error[:, nx:].max(axis=1))


def _root(metric: Any, nx: int) -> tuple[Array, Array]:
    """A matrix L with W = L' L, and its inverse."""
    if metric is None:
        return np.eye(nx), np.eye(nx)
    W = as_array(metric)
    fits = W is not None and W.shape == (nx, nx) and np.abs(W).max() < LARGEST
    if W is None or not fits or np.abs(W - W.T).max() > 1e-12 * np.abs(W).max():
        raise ValueError(f"`contraction(metric=...)` must be a symmetric matrix ({nx}, {nx}); got {described(metric)}.")
    try:
        lower = np.linalg.cholesky(W)
    except np.linalg.LinAlgError:
        least = np.linalg.eigvalsh(W)[0]
        raise ValueError(
            "`contraction(metric=...)` must be positive definite, or it is no metric; its least eigenvalue is "
            f"{least:.3g}."
        ) from None
    return np.asarray(lower.T, dtype=float), np.asarray(np.linalg.inv(lower.T), dtype=float)
