"""The linear-quadratic-Gaussian controller: a regulator that acts on the estimate of a Kalman filter."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from workbench.design.certificates import Certificate
from workbench.design.riccati.answers import Lqg, Riccati
from workbench.design.riccati.equation import norm
from workbench.design.riccati.given import is_discrete, is_system
from workbench.design.riccati.regulators import lqe, lqr
from workbench.validation.refusals import Array
from workbench.validation.signatures import door


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
    A, C = _matrices(system)
    regulator = lqr(system, Q, R, N)
    entry = np.eye(len(A)) if G is None else G
    estimator = lqe(A, entry, C, Qn, Rn, discrete=is_discrete(system))
    controller = _controller(system, regulator.K, estimator.K)
    loop = _loop(system, controller)
    poles = np.asarray(np.linalg.eigvals(loop), dtype=complex)
    certificate = Certificate(
        residual=_mixed(system, loop, regulator.K, estimator.K),
        error=max(regulator.certificate.error, estimator.certificate.error),
        condition=max(regulator.certificate.condition, estimator.certificate.condition),
        margin=_margin(system, poles),
        refined=max(regulator.certificate.refined, estimator.certificate.refined),
        warnings=tuple(_warnings(system, controller, regulator, estimator)),
    )
    return Lqg(controller, regulator, estimator, poles, certificate)


def _matrices(system: Any) -> tuple[Array, Array]:
    if not is_system(system):
        raise ValueError(
            f"`lqg(system, Q, R, Qn, Rn)`: system must be a python-control `StateSpace`; got {type(system).__name__}. "
            "Make one by `control.ss(A, B, C, D)`."
        )
    return np.asarray(system.A, dtype=float), np.asarray(system.C, dtype=float)


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


def _loop(system: Any, controller: Any) -> Array:
    """The matrix (2 n, 2 n) of plant and controller as they are handed out, u = controller(y)."""
    acting = system.B @ controller.C
    seeing = controller.B @ system.C
    return np.block([[system.A, acting], [seeing, controller.A + controller.B @ system.D @ controller.C]])


def _mixed(system: Any, loop: Array, K: Array, L: Array) -> float:
    """How far the loop is from regulator and estimator one above the other, over its size.

    In the states x and x - x_hat it is [A - B K, B K; 0, A - L C] if the principle of separation holds.
    """
    n = len(system.A)
    change = np.block([[np.eye(n), np.zeros((n, n))], [np.eye(n), -np.eye(n)]])
    apart = np.block([[system.A - system.B @ K, system.B @ K], [np.zeros((n, n)), system.A - L @ system.C]])
    return norm(change @ loop @ change - apart) / norm(loop)


def _margin(system: Any, poles: Any) -> float:
    return float(1 - np.abs(poles).max() if is_discrete(system) else -poles.real.max())


def _warnings(system: Any, controller: Any, regulator: Riccati, estimator: Riccati) -> Iterator[str]:
    for name, half in (("regulator", regulator), ("estimator", estimator)):
        yield from (f"{name}: {warning}" for warning in half.certificate.warnings)
    if not _margin(system, np.linalg.eigvals(controller.A)) > 0:
        yield "the controller is unstable by itself: the loop must be closed before it runs"
