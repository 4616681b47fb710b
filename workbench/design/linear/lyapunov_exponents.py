"""Lyapunov exponents along a path: the mean rates at which small deviations grow or decay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Ode, rk4, with_quadrature, with_sensitivity
from workbench.design.linear.arguments import row_of, smooth, vector_of
from workbench.validation.refusals import Array, multiple, positive, seconds
from workbench.validation.signatures import door
from workbench.validation.views import show

BATCHES = 10
STEPS_BETWEEN = 10  # steps of Runge and Kutta from one QR factorisation to the next


@dataclass(frozen=True, eq=False)
@show
class LyapunovExponents:
    """Mean rates of growth of nx orthogonal deviations over a finite time: an estimate, not a bound.

    Attributes
    ----------
    values
        (nx,), in 1/s, the largest first.
    error
        (nx,): the change from twice the step, plus twice the standard error of the means of ten batches.
    imbalance
        The distance of their sum from the mean trace of A, in 1/s, which it equals by Liouville's formula.
    span
        The time they were taken over, in s.
    """

    values: Array
    error: Array
    imbalance: float
    span: float


@door
def lyapunov_exponents(
    ode: Ode, until: float, h: float, p: Any = None, x0: Any = None, *, skip: float = 0.0
) -> LyapunovExponents:
    """The Lyapunov exponents along the solution from x0, by QR factorisations of Phi from piece to piece of the path.

    The solution and Phi are those of Runge and Kutta with half the step h; a run with h says what the step does.

    Parameters
    ----------
    until, h
        The end of the path and the step, in s; `until` - `skip` is a multiple of 200 h.
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
    from workbench.reference.surfaces import Switched  # half a second, which few callers of this room need

    for surface in Switched.of(ode, p).surfaces:
        if surface.jumps and ca.depends_on(surface.sigma, ode.x):
            raise ValueError(
                "`lyapunov_exponents(ode=...)` must have a rate that is continuous in the states; that of "
                f"'{ode.name}' may jump where {surface.name} = 0. Hold what moves slowly by `freeze`, or take "
                f"{smooth(ode)}."
            )
