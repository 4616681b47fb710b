"""Linear-quadratic regulators, estimators, and both together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg

from workbench.core import Ode
from workbench.design.linear.operating_point import jacobians, row_of, vector_of
from workbench.design.matrices import (
    Certificate,
    Complex,
    definite,
    indefinite,
    matrix,
    semidefinite,
    square,
)
from workbench.design.riccati.algebraic_equation import distances, norm
from workbench.design.riccati.stabilising_solution import ESTIMATOR, Riccati, checked_data, stabilising
from workbench.validation.notebook_display import show
from workbench.validation.refusals import Array, seconds
from workbench.validation.signatures import door


@door
def lqr(A: Any, B: Any = None, Q: Any = None, R: Any = None, N: Any = None, discrete: bool = False) -> Riccati:
    """The gain K of u = -K x that makes the integral, or sum, of x'Qx + 2 x'Nu + u'Ru smallest.

    The system is x' = A x + B u, or x+ = A x + B u if it is `discrete`. A python-control `StateSpace` takes the place
    of A and B, as in `lqr(system, Q, R)`, and says itself whether it is sampled.

    Parameters
    ----------
    A, B
        (n, n) and (n, m).
    Q, R, N
        The weights of states (n, n) and inputs (m, m), positive definite, and between them (n, m), such that [Q N; N'
        R] is positive semidefinite.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, of its shape, or not as definite as it must be.
    Refused
        If no gain stabilises, or none can be trusted; the message names the mode that is to blame.

    References
    ----------
    Anderson, Moore (1990), Optimal Control: Linear Quadratic Methods, chapters 2 and 3.

    Examples
    --------
    >>> answer = wb.lqr([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], Q=np.diag([1.0, 0.0]), R=[[1.0]])
    >>> answer.K.round(4), answer.certificate.residual < 1e-15
    (array([[1.    , 1.4142]]), True)
    """
    call = "lqr(A, B, Q, R)"
    if is_system(A):
        call, discrete = "lqr(system, Q, R)", is_discrete(A)
        if B is not None:  # weights in the places of matrices, the rest of them by name
            Q, R, N = (B, R, N) if Q is None else (B, Q, R if N is None else N)
        A, B = A.A, A.B
    d = checked_data(call, A, B, Q, R, N)
    semidefinite(call, "Q", d.Q)
    _check_joint(call, d.Q, d.S, d.R)
    return stabilising(call, d, discrete)


@door
def lqe(A: Any, G: Any, C: Any, Qn: Any, Rn: Any, discrete: bool = False) -> Riccati:
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
    ValueError, Refused
        As `lqr`.
    """
    call = "lqe(A, G, C, Qn, Rn)"
    a = square(call, "A", A)
    g = matrix(call, "G", G, rows=len(a))
    c = matrix(call, "C", C, columns=len(a))
    q, r = semidefinite(call, "Qn", Qn, g.shape[1]), definite(call, "Rn", Rn, len(c))
    driven = g @ q @ g.T
    d = checked_data(call, a.T, c.T, (driven + driven.T) / 2, r)  # the equation of the transposed system
    dual = stabilising(call, d, discrete, ESTIMATOR)
    return replace(dual, K=dual.K.T)


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

    Without a period K is that of x_hat' = f + K (y - h), for readings at all times. With one it is that of x_hat+ =
    x_hat + K (y_k - h) at each reading, between which x_hat' = f: X is then P before a reading. `poles` are those of
    the error.

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
    ValueError, Refused
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
    state = ode.states.default if x is None else vector_of("x", x, ode.states)
    A, _, Cy, _ = jacobians("steady_kalman", ode, 0.0, state, row_of(ode, p, u))
    C = Cy[[place for name in outputs or ode.outputs.names for place in ode.outputs.indices(name)]]
    q, r = semidefinite(call, "Q", Q, len(A)), definite(call, "R", R, len(C))
    if period is None:
        return lqe(A, np.eye(len(A)), C, q, r)
    Phi, Qd = _sampled(A, q, seconds("steady_kalman(period=...)", period))
    answer = lqe(Phi, np.eye(len(A)), C, Qd, r, discrete=True)
    K = np.asarray(np.linalg.solve(C @ answer.X @ C.T + r, C @ answer.X).T, dtype=float)
    return replace(answer, K=K)


def _sampled(A: Array, Q: Array, period: float) -> tuple[Array, Array]:
    """exp(A period), and the covariance that white noise of intensity Q gathers over the period (Van Loon 1978)."""
    n = len(A)
    block = scipy.linalg.expm(np.block([[-A, Q], [np.zeros((n, n)), A.T]]) * period)
    Phi = block[n:, n:].T
    Qd = Phi @ block[:n, n:]
    return Phi, (Qd + Qd.T) / 2


@dataclass(frozen=True)
@show
class Lqg:
    """A linear-quadratic-Gaussian controller from y to u, a python-control `StateSpace` with the feedback sign inside.

    The poles (2 n,) of the closed loop are computed from the loop and not from its two halves. The certificate is that
    of the loop: the worse figure of both halves, and how far its poles lie from theirs (`residual`).
    """

    controller: Any
    regulator: Riccati
    estimator: Riccati
    poles: Complex
    certificate: Certificate


@door
def lqg(system: Any, Q: Any, R: Any, Qn: Any, Rn: Any, N: Any = None, G: Any = None) -> Lqg:
    """The controller u = -K x_hat, x_hat' = A x_hat + B u + L (y - C x_hat - D u), as a python-control `StateSpace`.

    It makes the mean of x'Qx + 2 x'Nu + u'Ru smallest for x' = A x + B u + G w, y = C x + D u + v, with white w
    and v. A sampled system gives a sampled controller, in the form of the predictor. Such a loop has no guaranteed
    margins (Doyle 1978).

    Parameters
    ----------
    system
        The python-control `StateSpace` with n states.
    Q, R, N
        The weights, as for `lqr`.
    Qn, Rn
        The intensities of w (nw, nw) and v (ny, ny), as for `lqe`.
    G
        (n, nw), where w enters; without it, at each state.

    Raises
    ------
    ValueError, Refused
        If `system` is no `StateSpace`, or as `lqr` and `lqe`.

    References
    ----------
    Athans (1971), IEEE Trans. Autom. Control 16. Doyle (1978), the same, 23.

    Examples
    --------
    >>> motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    >>> answer = wb.lqg(motor, Q=np.diag([100.0, 0.0]), R=[[1.0]], Qn=np.eye(2), Rn=[[1e-3]])
    >>> wb.ClosedLoop(wb.DCMotor(), controller=answer.controller).controller.drives.names
    ('v',)
    """
    if not is_system(system):
        kind = type(system).__name__
        raise ValueError(f"`lqg(system, Q, R, Qn, Rn)`: system must be a python-control `StateSpace`; got {kind}.")
    regulator = lqr(system, Q, R, N)
    entry = np.eye(len(system.A)) if G is None else G
    estimator = lqe(system.A, entry, system.C, Qn, Rn, discrete=is_discrete(system))
    controller = _controller(system, regulator.K, estimator.K)
    loop, apart = _loops(system, controller, regulator.K, estimator.K)
    poles = np.asarray(np.linalg.eigvals(loop), dtype=complex)
    certificate = Certificate(
        residual=norm(apart) / norm(loop),
        error=max(regulator.certificate.error, estimator.certificate.error),
        condition=max(regulator.certificate.condition, estimator.certificate.condition),
        margin=float(distances(poles, is_discrete(system)).min()),
        refined=max(regulator.certificate.refined, estimator.certificate.refined),
        warnings=tuple(_warnings(system, controller, regulator, estimator)),
    )
    return Lqg(controller, regulator, estimator, poles, certificate)


def is_system(value: Any) -> bool:
    """True if a value is a linear system by its matrices, as python-control's `StateSpace`."""
    return all(hasattr(value, name) for name in ("A", "B", "C", "D", "dt"))


def is_discrete(system: Any) -> bool:
    """True if a system is sampled: python-control writes 0 or None for one that is not."""
    return system.dt not in (0, None)


def _check_joint(call: str, Q: Array, N: Array, R: Array) -> None:
    # measured by the roots of the diagonals, in which the rounding of eigenvalues means something
    whole = np.block([[Q, N], [N.T, R]])
    root = np.sqrt(np.maximum(np.diag(whole), np.finfo(float).tiny))
    scaled = whole / root[:, None] / root
    if indefinite(scaled):
        least = np.linalg.eigvalsh(scaled)[0]
        raise ValueError(
            f"`{call}`: [Q N; N' R] must be positive semidefinite, or the cost has no minimum; its least eigenvalue, "
            f"with its diagonal scaled to one, is {least:.3g}. Weigh less across, or more on the diagonal."
        )


def _controller(system: Any, K: Array, L: Array) -> Any:
    import control  # takes seconds, and only this function needs it

    inside = system.A - system.B @ K - L @ (system.C - system.D @ K)
    return control.ss(
        inside,
        L,
        -K,
        np.zeros((len(K), L.shape[1])),
        system.dt,
        name=f"lqg of {system.name}",
        states=[f"{label}_hat" for label in system.state_labels],
        inputs=list(system.output_labels),
        outputs=list(system.input_labels),
    )


def _warnings(system: Any, controller: Any, regulator: Riccati, estimator: Riccati) -> Iterator[str]:
    for name, half in (("regulator", regulator), ("estimator", estimator)):
        yield from (f"{name}: {warning}" for warning in half.certificate.warnings)
    if not distances(np.linalg.eigvals(controller.A), is_discrete(system)).min() > 0:
        yield "the controller is unstable by itself: the loop must be closed before it runs"


def _loops(system: Any, controller: Any, K: Array, L: Array) -> tuple[Array, Array]:
    """The matrix (2 n, 2 n) of plant and controller, and its distance, in x and x - x_hat, from separation."""
    acting, seeing, n = system.B @ controller.C, controller.B @ system.C, len(system.A)
    loop = np.block([[system.A, acting], [seeing, controller.A + controller.B @ system.D @ controller.C]])
    change = np.block([[np.eye(n), np.zeros((n, n))], [np.eye(n), -np.eye(n)]])
    apart = np.block([[system.A - system.B @ K, system.B @ K], [np.zeros((n, n)), system.A - L @ system.C]])
    return loop, change @ loop @ change - apart
