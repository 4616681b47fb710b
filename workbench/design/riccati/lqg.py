"""The steady Kalman filter of an equation, and the linear-quadratic-Gaussian controller."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg

from workbench.core import Ode
from workbench.design.linear.arguments import jacobians, row_of, vector_of
from workbench.design.matrices import Certificate, Complex, definite, semidefinite
from workbench.design.riccati.algebraic_equation import norm
from workbench.design.riccati.regulators import is_discrete, is_system, lqe, lqr
from workbench.design.riccati.stabilisation import Riccati
from workbench.validation.refusals import Array, seconds
from workbench.validation.signatures import door
from workbench.validation.views import show


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
    A, C, q, r = _linear_model(ode, Q, R, outputs, x, row_of(ode, p, u))
    if period is None:
        return lqe(A, np.eye(len(A)), C, q, r)
    Phi, Qd = _sampled(A, q, seconds("steady_kalman(period=...)", period))
    answer = lqe(Phi, np.eye(len(A)), C, Qd, r, discrete=True)
    K = np.asarray(np.linalg.solve(C @ answer.X @ C.T + r, C @ answer.X).T, dtype=float)
    return replace(answer, K=K)


def _linear_model(
    ode: Ode, Q: Any, R: Any, outputs: Sequence[str], x: Any, row: Array
) -> tuple[Array, Array, Array, Array]:
    """A and C at a point, and the two intensities."""
    state = ode.states.default if x is None else vector_of("x", x, ode.states)
    A, _, Cy, _ = jacobians("steady_kalman", ode, 0.0, state, row)
    C = Cy[[place for name in outputs or ode.outputs.names for place in ode.outputs.indices(name)]]
    call = "steady_kalman(ode, Q, R)"
    return A, C, semidefinite(call, "Q", Q, len(A)), definite(call, "R", R, len(C))


def _sampled(A: Array, Q: Array, period: float) -> tuple[Array, Array]:
    """exp(A period), and the covariance that white noise of intensity Q gathers over the period, by Van Loon (1978)."""
    n = len(A)
    block = scipy.linalg.expm(np.block([[-A, Q], [np.zeros((n, n)), A.T]]) * period)
    Phi = block[n:, n:].T
    Qd = Phi @ block[:n, n:]
    return Phi, (Qd + Qd.T) / 2


@dataclass(frozen=True)
@show
class Lqg:
    """A linear-quadratic-Gaussian controller from y to u.

    Parameters
    ----------
    controller
        The python-control `StateSpace` with the inputs y and the outputs u; its feedback sign is already inside,
        so the loop is closed by u = controller(y) without another minus.
    regulator, estimator
        The two Riccati solutions of which it is made.
    poles
        The eigenvalues (2 n,) of the closed loop, computed from the loop and not from its two halves.
    certificate
        Of the loop: the worse figure of both halves, and how far its poles lie from theirs (`residual`).
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
    and v. A sampled system gives a sampled controller, in the form of the predictor. Such a loop has no margins
    of its own accord (Doyle 1978): look at them.

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
    ValueError
        If `system` is no `StateSpace`, or as `lqr` and `lqe`.
    Refused
        As `lqr` and `lqe`.

    References
    ----------
    Athans (1971), The role and use of the stochastic linear-quadratic-Gaussian problem in control system design,
    IEEE Trans. Autom. Control 16. Doyle (1978), Guaranteed margins for LQG regulators, the same, 23.

    Examples
    --------
    >>> motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    >>> answer = wb.lqg(motor, Q=np.diag([100.0, 0.0]), R=[[1.0]], Qn=np.eye(2), Rn=[[1e-3]])
    >>> wb.ClosedLoop(wb.DCMotor(), controller=answer.controller).controller.drives.names
    ('v',)
    """
    if not is_system(system):
        raise ValueError(
            f"`lqg(system, Q, R, Qn, Rn)`: system must be a python-control `StateSpace`; got {type(system).__name__}."
        )
    A, C = np.asarray(system.A, dtype=float), np.asarray(system.C, dtype=float)
    regulator = lqr(system, Q, R, N)
    entry = np.eye(len(A)) if G is None else G
    estimator = lqe(A, entry, C, Qn, Rn, discrete=is_discrete(system))
    controller = _controller(system, regulator.K, estimator.K)
    loop, apart = _loops(system, controller, regulator.K, estimator.K)
    poles = np.asarray(np.linalg.eigvals(loop), dtype=complex)
    certificate = Certificate(
        residual=norm(apart) / norm(loop),
        error=max(regulator.certificate.error, estimator.certificate.error),
        condition=max(regulator.certificate.condition, estimator.certificate.condition),
        margin=_distance(system, poles),
        refined=max(regulator.certificate.refined, estimator.certificate.refined),
        warnings=tuple(_warnings(system, controller, regulator, estimator)),
    )
    return Lqg(controller, regulator, estimator, poles, certificate)


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
    if not _distance(system, np.linalg.eigvals(controller.A)) > 0:
        yield "the controller is unstable by itself: the loop must be closed before it runs"


def _loops(system: Any, controller: Any, K: Array, L: Array) -> tuple[Array, Array]:
    """The matrix (2 n, 2 n) of plant and controller as they are handed out, and how it differs from separation.

    In the states x and x - x_hat it is [A - B K, B K; 0, A - L C] if the principle of separation holds.
    """
    acting, seeing, n = system.B @ controller.C, controller.B @ system.C, len(system.A)
    loop = np.block([[system.A, acting], [seeing, controller.A + controller.B @ system.D @ controller.C]])
    change = np.block([[np.eye(n), np.zeros((n, n))], [np.eye(n), -np.eye(n)]])
    apart = np.block([[system.A - system.B @ K, system.B @ K], [np.zeros((n, n)), system.A - L @ system.C]])
    return loop, change @ loop @ change - apart


def _distance(system: Any, poles: Any) -> float:
    """The distance of the slowest pole from instability."""
    return float(1 - np.abs(poles).max() if is_discrete(system) else -poles.real.max())
