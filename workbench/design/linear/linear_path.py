"""Linear models along a path, and equations of which some states are frozen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode
from workbench.design.linear.arguments import inputs_of, jacobians, row_of
from workbench.design.matrices import Complex
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
        """The eigenvalues of A at each frozen time, (N, nx), the slowest first; they prove nothing of the motion."""
        values = np.linalg.eigvals(self.A).astype(complex)
        order = np.lexsort((-values.imag, -np.round(values.real, 9)), axis=-1)
        return np.asarray(np.take_along_axis(values, order, axis=-1))


@door
def along(ode: Ode, t: Any, x: Any, p: Any = None, box: Mapping[str, tuple[float, float]] | None = None) -> LinearPath:
    """The linear models of an `Ode` at the states of a motion.

    Parameters
    ----------
    t, x
        Times (N,), increasing, in s, and states (N, nx).
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
        low, high = ends
        if not low < high:
            raise ValueError(f"`along(box=...)`: '{name}' must be (low, high), low < high; got {described(ends)}.")
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


@door
def freeze(ode: Ode, names: Sequence[str]) -> Ode:
    """The same equation with the named states frozen: parameters of the same names take their places.

    Raises
    ------
    ValueError
        If no name is given, or no state would be left.
    LookupError
        If a name is no state's; the message names the nearest.
    """
    if not names:
        raise ValueError("`freeze(names=...)` must be names of states, at least one; got none.")
    chosen = [ode.states[name] for name in names]
    rest = Layout(tuple(entry for entry in ode.states.entries if entry.name not in names))
    if not rest.size:
        raise ValueError(f"`freeze(names=...)` must leave a state that moves; '{ode.name}' has no other.")
    fixed = [place for entry in chosen for place in ode.states.indices(entry.name)]
    free = np.setdiff1d(np.arange(ode.states.size), fixed).tolist()
    return replace(
        ode,
        states=rest,
        parameters=ode.parameters + Layout(tuple(chosen)),
        x=ode.x[free],
        p=ca.vertcat(ode.p, ode.x[fixed]),
        rate=ode.rate[free],
    )
