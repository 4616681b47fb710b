"""Gains of stationary Kalman filters, of matrices and of equations linearised at a point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ldexp

import numpy as np
import scipy.linalg

from workbench.core import Ode
from workbench.core.point import OperatingPoint
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.linearization import motion
from workbench.design.linear.operating_point import inputs_of, places_of, row_of, vector_of
from workbench.design.linear.switching_functions import Sides, SwitchingFunctions, sure_jacobians
from workbench.design.matrices import definite, matrix, semidefinite, square
from workbench.design.riccati.stabilising_solution import ESTIMATOR, Riccati, checked_data, stabilising_solution


@check_arguments
def lqe(A: Numbers, G: Numbers, C: Numbers, Qn: Numbers, Rn: Numbers, discrete: bool = False) -> Riccati:
    """The gain K of the stationary Kalman filter of x' = A x + G w, y = C x + v, and X = P, its covariance.

    The estimate follows x_hat' = A x_hat + K (y - C x_hat), or x_hat+ if the system is discrete: then K is that of
    the predictor, with P before a measurement.

    Parameters
    ----------
    A, G, C
        (n, n), (n, nw) and (ny, n).
    Qn, Rn
        The intensities of w (nw, nw), positive semidefinite, and v (ny, ny), positive definite.

    Raises
    ------
    ValueError, DesignError
        As `lqr`.
    """
    call = "lqe(A, G, C, Qn, Rn)"
    a = square(call, "A", A)
    g = matrix(call, "G", G, rows=len(a))
    c = matrix(call, "C", C, columns=len(a))
    q, r = semidefinite(call, "Qn", Qn, g.shape[1]), definite(call, "Rn", Rn, len(c))
    driven = g @ q @ g.T
    d = checked_data(call, a.T, c.T, (driven + driven.T) / 2, r)  # the equation of the transposed system
    dual = stabilising_solution(call, d, discrete, ESTIMATOR)
    return replace(dual, K=dual.K.T)


@check_arguments
def steady_kalman(
    ode: Ode,
    Q: Numbers,
    R: Numbers,
    outputs: Sequence[str] = (),
    *,
    period: float | None = None,
    x: Numbers | None = None,
    u: Numbers | None = None,
    p: Numbers | None = None,
    side: Sides = None,
) -> Riccati:
    """The steady gain K of the Kalman filter of x' = f + w, y = h + v, linearised exactly at (x, p, u), t = 0.

    Without a `period`, in s, the filter is x_hat' = f + K (y - h), for readings at all times. With a period it is
    x_hat+ = x_hat + K (y_k - h) at each reading, and x_hat' = f in between; `X` of the answer is the covariance
    of the error; with a period, just before a reading. `poles` are those of the error.

    Parameters
    ----------
    Q, R
        The intensity of w (nx, nx), semidefinite; and that of v, with a period the covariance of one reading, (ny, ny).
    outputs
        The outputs that are read, or single numbers of them (`q[0]`); all by default.
    x, u, p
        (nx,), (nu,) and (np,); by default the initial state and the defaults of `ode`. The answer carries this point.
    side
        The side of a corner, as of `linearize`.

    Raises
    ------
    LookupError
        If an output has no such name.
    ValueError, DesignError
        As `lqe`.

    References
    ----------
    Simon (2006), Optimal State Estimation, sections 7.3 and 8.3.

    Examples
    --------
    >>> wb.steady_kalman(wb.open_loop(wb.DCMotor()), Q=np.eye(2), R=[[1e-2]], period=0.01).K.round(3)
    array([[0.581],
           [0.149]])
    """
    call = "steady_kalman(ode, Q, R)"
    A, C, point = _at_point(ode, outputs, x, row_of(ode, p, u), side)
    q, r = semidefinite(call, "Q", Q, len(A)), definite(call, "R", R, len(C))
    if period is None:
        return replace(lqe(A, np.eye(len(A)), C, q, r), point=point)
    Phi, Qd = _sampled_noise(A, q, seconds("steady_kalman(period=...)", period))
    answer = lqe(Phi, np.eye(len(A)), C, Qd, r, discrete=True)
    K = np.asarray(np.linalg.solve(C @ answer.X @ C.T + r, C @ answer.X).T, dtype=float)
    return replace(answer, K=K, point=point)


def _at_point(
    ode: Ode, outputs: Sequence[str], x: Numbers | None, row: Array, side: Sides
) -> tuple[Array, Array, OperatingPoint]:
    """A, the rows of Cy that are read, and the point at a state, with corners that touch neither let pass."""
    state, n = ode.states.default if x is None else vector_of("x", x, ode.states), ode.states.size
    read = [place for name in outputs or ode.outputs.names for place in ode.outputs.indices(name)]
    used = np.zeros((n + ode.outputs.size, n + len(places_of(ode))), dtype=bool)
    used[[*range(n), *(n + place for place in read)], :n] = True
    A, _, Cy, _ = sure_jacobians("steady_kalman", SwitchingFunctions.of(ode), 0.0, state, row, side, lambda _: used)
    y0, moving = np.array(ode.h(0.0, state, row)).ravel(), motion(ode, 0.0, state, row, A)
    point = OperatingPoint(ode.states, inputs_of(ode), ode.outputs, state, row[places_of(ode)], y0, moving)
    return A, Cy[read], point.part(read, range(len(point.u0)))


def _sampled_noise(A: Array, Q: Array, period: float) -> tuple[Array, Array]:
    """exp(A period), and the covariance that white noise of intensity Q gathers over the period.

    Van Loon (1978) over a part of the period that is short beside the motion of A, and then the sums over twice the
    span, Qd + Phi Qd Phi': over a long one exp(-A period) would leave no digit of the covariance.
    """
    n = len(A)
    with np.errstate(all="ignore"):  # what it leaves is refused below
        doublings = int(max(0.0, np.ceil(np.log2(np.linalg.norm(A, 1)) + np.log2(period)))) if A.any() else 0
        block = scipy.linalg.expm(np.block([[-A, Q], [np.zeros((n, n)), A.T]]) * ldexp(period, -doublings))
        Phi = block[n:, n:].T
        Qd = Phi @ block[:n, n:]
        for _ in range(doublings):
            Qd, Phi = Qd + Phi @ Qd @ Phi.T, Phi @ Phi
    if not np.isfinite(Phi).all() or not np.isfinite(Qd).all():
        raise ValueError(
            "`steady_kalman(period=...)` must be a period over which the states and the covariance of their noise stay "
            f"finite; got {period:g} s: take one nearer to the times in which the states move."
        )
    return Phi, (Qd + Qd.T) / 2
