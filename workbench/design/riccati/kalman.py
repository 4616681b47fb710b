"""The gain at which the Kalman filter of an equation settles, at a point of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg

from workbench.core import Ode
from workbench.design.linear.arguments import jacobians, row_of, vector_of
from workbench.design.matrices import definite, semidefinite
from workbench.design.riccati.answers import Riccati
from workbench.design.riccati.regulators import lqe
from workbench.validation.refusals import Array, seconds
from workbench.validation.signatures import door


@door
def steady_kalman(
    ode: Ode,
    Q: Any,
    R: Any,
    outputs: Sequence[str] = (),
    *,
    period: float | None = None,
    x: Any = None,
    u: Any = None,
    p: Any = None,
) -> Riccati:
    """The steady gain K of the Kalman filter of x' = f + w, y = h + v, linearised exactly at (x, p, u), t = 0.

    Without a period K is that of x_hat' = f + K (y - h), for readings at all times, of the continuous Riccati equation.
    With one it is that of x_hat+ = x_hat + K (y_k - h) at each reading, between which x_hat' = f: X is then P before a
    reading, of the discrete equation of the plant held over the period, where w gathers the covariance

        Q_d = integral of exp(A s) Q exp(A' s) from 0 to the period.

    `poles` are those of the error. `open_loop(plant)` is such an `ode`.

    Parameters
    ----------
    Q, R
        The intensity of w (nx, nx), semidefinite; and that of v, with a period the covariance of one reading, (ny, ny).
    outputs
        The outputs that are read, or single numbers of them (`q[0]`); all where none is named.
    x, u, p
        (nx,), (nu,) and (np,); the starts and defaults of `ode` where none is given.

    Raises
    ------
    LookupError
        If an output has no such name.
    ValueError
        If a matrix is not real, finite, of its shape, or not as definite as it must be.
    Refused
        If no gain is steady, as no output sees a mode that does not decay; or if none can be trusted.

    References
    ----------
    Simon (2006), Optimal State Estimation, sections 7.3 and 8.3.

    Examples
    --------
    >>> wb.steady_kalman(wb.open_loop(wb.DCMotor()), Q=np.eye(2), R=[[1e-2]], period=0.01).K.round(3)
    array([[0.581],
           [0.149]])
    """
    A, C, q, r = _given(ode, Q, R, outputs, x, row_of(ode, p, u), 0.0)
    if period is None:
        return lqe(A, np.eye(len(A)), C, q, r)
    Phi, Qd = _held(A, q, seconds("steady_kalman(period=...)", period))
    answer = lqe(Phi, np.eye(len(A)), C, Qd, r, discrete=True)
    K = np.asarray(np.linalg.solve(C @ answer.X @ C.T + r, C @ answer.X).T, dtype=float)
    return replace(answer, K=K)


def _given(
    ode: Ode, Q: Any, R: Any, outputs: Sequence[str], x: Any, row: Array, t: float
) -> tuple[Array, Array, Array, Array]:
    """A and C at a point, and the two intensities."""
    state = ode.states.default if x is None else vector_of("x", x, ode.states)
    A, _, Cy, _ = jacobians("steady_kalman", ode, t, state, row)
    C = Cy[[place for name in outputs or ode.outputs.names for place in ode.outputs.indices(name)]]
    call = "steady_kalman(ode, Q, R)"
    return A, C, semidefinite(call, "Q", Q, len(A)), definite(call, "R", R, len(C))


def _held(A: Array, Q: Array, period: float) -> tuple[Array, Array]:
    """exp(A period), and the covariance that white noise of intensity Q gathers over the period, by Van Loon (1978)."""
    n = len(A)
    block = scipy.linalg.expm(np.block([[-A, Q], [np.zeros((n, n)), A.T]]) * period)
    Phi = block[n:, n:].T
    Qd = Phi @ block[:n, n:]
    return Phi, (Qd + Qd.T) / 2
