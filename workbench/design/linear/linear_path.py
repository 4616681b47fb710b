"""Linear models along a path, equations of which some states are frozen, and Lyapunov exponents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode, rk4, with_quadrature, with_sensitivity
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, as_array, multiple, numbers, positive, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.operating_point import inputs_of, jacobians, places_of, row_of, smooth, vector_of
from workbench.design.linear.switching_functions import (
    SwitchingFunctions,
    corner_entries,
    pieces_ahead,
    refuse_corner,
    rows_of,
    split,
)
from workbench.design.matrices import Complex

BATCHES = 10
STEPS_BETWEEN = 10  # steps of Runge and Kutta from one QR factorisation to the next


@dataclass(frozen=True, eq=False)
@show
class LinearPath:
    """The linear system dx' = A(t) dx + B(t) du, dy = Cy(t) dx + D(t) du about a motion x (N, nx) at times t (N,) in s.

    Each model is of the motion frozen at its time. A is (N, nx, nx), B (N, nx, nu), Cy (N, ny, nx) and D (N, ny, nu); u
    (N, nu) and y (N, ny) are inputs and outputs on the motion; states, inputs and outputs are names, number by number.
    """

    t: Array
    x: Array
    u: Array
    y: Array
    A: Array
    B: Array
    Cy: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def eigenvalues(self) -> Complex:
        """The eigenvalues of A at each frozen time, (N, nx), the slowest first; they prove nothing about the motion."""
        values = np.linalg.eigvals(self.A).astype(complex)
        order = np.lexsort((-values.imag, -np.round(values.real, 9)), axis=-1)
        return np.asarray(np.take_along_axis(values, order, axis=-1))


@check_arguments
def along(ode: Ode, t: Numbers, x: Numbers, p: Numbers | None = None) -> LinearPath:
    """The linear models of an `Ode` at the states of a motion, frozen at each.

    On a corner, of a saturation or of |s|, they are those of the piece into which the motion goes.

    Parameters
    ----------
    t, x
        Times (N,), increasing, in s, and states (N, nx).
    p
        The parameters (np,), or (N, np) where inputs change along the path.

    Raises
    ------
    ValueError
        If times and states do not fit or are not finite, a Jacobian is not finite, or the motion stays on a corner.

    Examples
    --------
    >>> from workbench.design.linear import along
    >>> plant = wb.open_loop(wb.DCMotor())
    >>> along(plant, [0.0, 1.0], np.zeros((2, plant.states.size))).eigenvalues().round(2)
    array([[ -2.+0.j, -10.+0.j],
           [ -2.+0.j, -10.+0.j]])
    """
    times, states = numbers("along(t=...)", t), numbers("along(x=...)", x)
    if times.ndim != 1 or states.shape != (len(times), ode.states.size) or not len(times):
        raise ValueError(
            f"`along(t, x)` must be N times and states (N, {ode.states.size}); got shapes {times.shape} and "
            f"{states.shape}."
        )
    if not (np.isfinite(times).all() and np.isfinite(states).all() and (times[1:] > times[:-1]).all()):
        raise ValueError("`along(t, x)` must be finite numbers, and times that increase; a run may have diverged.")
    table = as_array(p)
    table = table if table is not None and table.ndim == 2 else None
    if table is not None and len(table) != len(times):
        raise ValueError(f"`along(p=...)` must have a row for each of the {len(times)} times; got {len(table)}.")
    rows = [row_of(ode, row) for row in ([p] if table is None else table)]
    corners, points = SwitchingFunctions.of(ode), []
    for k, (time, state) in enumerate(zip(times, states, strict=True)):
        points.append((float(time), state, rows[0 if table is None else k]))
    matrices = [_on_motion(corners, *point) for point in points]
    A, B, Cy, D = (np.stack(kind) for kind in zip(*matrices, strict=True))
    u = np.stack([row[places_of(ode)] for _, _, row in points])
    y = np.stack([np.array(ode.h(*point)).ravel() for point in points])
    names = (ode.states.labels, inputs_of(ode).labels, ode.outputs.labels)
    return LinearPath(times, states, u, y, A, B, Cy, D, *names)


def _on_motion(corners: SwitchingFunctions, t: float, x: Array, p: Array) -> tuple[Array, Array, Array, Array]:
    """A, B, Cy and D at a state of a motion; on a corner, of the piece that lies ahead."""
    corners = corners.at(t, x, p)
    ode, pieces = corners.ode, corners.pieces(t, x, p)
    if not pieces:
        return jacobians("along", ode, t, x, p)
    ahead = pieces_ahead(corners, pieces, (t, x, p))
    odd = corner_entries(ahead)
    if odd.any():
        refuse_corner("along", corners, ahead, odd, rows_of(ode), "Leave this time out, or start beside the corner.")
    return split(ahead[0].near, len(x))


@check_arguments
def freeze(ode: Ode, names: Sequence[str]) -> Ode:
    """The same equation with the named states frozen: parameters of the same names take their places.

    Raises
    ------
    ValueError
        If no name is given, or no state would be left.
    LookupError
        If a name is not that of a state; the message names the nearest.

    Examples
    --------
    >>> from workbench.design.linear import freeze
    >>> freeze(wb.open_loop(wb.DCMotor()), ("omega",)).states.names
    ('i',)
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


@dataclass(frozen=True, eq=False)
@show
class LyapunovExponents:
    """Mean rates of growth of nx orthogonal deviations over a finite time: an estimate, not a bound.

    The `values` (nx,) are in 1/s, the largest first. Their `error` (nx,) is the change from twice the step, plus twice
    the standard error of the means of ten batches. By Liouville's formula the sum of the values equals the mean trace
    of A; `imbalance` is the difference that was found. `span` is the time in s over which they were taken.
    """

    values: Array
    error: Array
    imbalance: float
    span: float


@check_arguments
def lyapunov_exponents(
    ode: Ode, until: float, h: float, p: Numbers | None = None, x0: Numbers | None = None, *, skip: float = 0.0
) -> LyapunovExponents:
    """The Lyapunov exponents along the solution from x0, by QR factorisations of Phi from piece to piece of the path.

    The solution and Phi are computed by Runge-Kutta steps of h / 2; a run with h shows the effect of the step.

    Parameters
    ----------
    until, h
        The end of the path and the step, in s; `until` - `skip` is a multiple of 200 h.
    p, x0
        The parameters (np,) and the initial state (nx,); the defaults of `ode` if not given.
    skip
        The time left out at the start, in s, while the path and the directions settle: a multiple of 20 h.

    Raises
    ------
    ValueError
        If times are not as above, the rate may jump as the states change, or the solution or Phi is not finite.

    References
    ----------
    Benettin, Galgani, Giorgilli and Strelcyn (1980), Meccanica 15; Dieci and Van Vleck (1995), Applied Numerical
    Mathematics 17.

    Examples
    --------
    >>> from workbench.design.linear import lyapunov_exponents
    >>> lyapunov_exponents(wb.open_loop(wb.DCMotor()), 2.0, 0.01, skip=0.0).values.round(1)
    array([-5., -7.])
    """
    call = "lyapunov_exponents"
    seconds(f"{call}(h=...)", h)
    if skip != 0:
        multiple(f"{call}(skip=...)", seconds(f"{call}(skip=...)", skip), 2 * STEPS_BETWEEN * h, "20 steps, together")
    span = positive(f"{call}(until=...)", until, " of seconds") - skip
    multiple(f"{call}(until - skip)", span, BATCHES * 2 * STEPS_BETWEEN * h, "200 steps, together")
    start = ode.states.default if x0 is None else vector_of("x0", x0, ode.states)
    row = row_of(ode, p)
    _refuse_jumps(ode, row)
    coarse, _ = _logarithms(ode, start, row, h, until, skip)
    fine, trace = _logarithms(ode, start, row, h / 2, until, skip)
    batches = fine.reshape(BATCHES, -1, ode.states.size).sum(axis=1) * (BATCHES / span)
    values = fine.sum(axis=0) / span
    scatter = 2 * batches.std(axis=0, ddof=1) / np.sqrt(BATCHES)
    error = np.abs(values - coarse.sum(axis=0) / span) + scatter
    order = np.argsort(-values)
    return LyapunovExponents(values[order], error[order], float(abs(values.sum() - trace / span)), span)


def _logarithms(ode: Ode, x0: Array, p: Array, h: float, until: float, skip: float) -> tuple[Array, float]:
    """log |R_ii| of each piece after `skip`, (pieces, nx), and the integral of the trace of A over these."""
    nx = ode.states.size
    both = with_sensitivity(ode, ode.states.names)
    both = with_quadrature(both, {"trace": ca.trace(ca.jacobian(ode.rate, ode.x))})
    rule = rk4(both, h).rule
    step = ca.Function("step", [rule.x, rule.k, rule.p, rule.h], [rule.next], {"cse": True})
    piece = step.mapaccum("piece", STEPS_BETWEEN)
    x, Q, kept, trace = x0, np.eye(nx), [], 0.0
    pieces, first = round(until / h / STEPS_BETWEEN), round(skip / h / STEPS_BETWEEN)
    for j in range(pieces):
        steps = np.arange(j * STEPS_BETWEEN, (j + 1) * STEPS_BETWEEN)[np.newaxis]
        start = np.concatenate([x, np.eye(nx).ravel(), [0.0]])
        end = np.array(piece(start, steps, p, h))[:, -1]
        if not np.isfinite(end).all():
            raise ValueError(
                f"`lyapunov_exponents(...)`: the solution of '{ode.name}' is not finite at t = "
                f"{steps[0, -1] * h + h:g} s; take a shorter step or an earlier end."
            )
        x = end[:nx]
        Q, R = np.linalg.qr(end[nx:-1].reshape(nx, nx).T @ Q)
        if j >= first:
            with np.errstate(divide="ignore"):
                kept.append(np.log(np.abs(np.diag(R))))
            trace += float(end[-1])
    logarithms = np.array(kept)
    if not np.isfinite(logarithms).all():
        raise ValueError(
            f"`lyapunov_exponents(...)`: a direction of '{ode.name}' shrinks to nothing within {STEPS_BETWEEN} steps "
            f"of {h:g} s, so it has no finite exponent; take a shorter step."
        )
    return logarithms, trace


def _refuse_jumps(ode: Ode, p: Array) -> None:
    from workbench.engine.reference.surfaces import SwitchedRate  # half a second, which few callers of this room need

    for surface in SwitchedRate.of(ode, p).surfaces:
        if surface.jumps and ca.depends_on(surface.sigma, ode.x):
            raise ValueError(
                "`lyapunov_exponents(ode=...)` must have a rate that is continuous in the states; that of "
                f"'{ode.name}' may jump where {surface.name} = 0. Hold what moves slowly by `freeze`, or take "
                f"{smooth(ode)}."
            )
