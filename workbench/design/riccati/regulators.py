"""Linear-quadratic regulators, and controllers that hold one and an estimator."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeGuard

import numpy as np

from workbench.core import Entry, Layout
from workbench.core.point import OperatingPoint, PointedGain
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import (
    Certificate,
    Complex,
    DesignError,
    indefinite,
    pole_text,
    semidefinite,
)
from workbench.design.riccati.algebraic_equation import distances, norm
from workbench.design.riccati.kalman_gains import lqe
from workbench.design.riccati.stabilising_solution import Riccati, checked_data, stabilising_solution


@check_arguments
def lqr(
    A: Numbers | System,
    B: Numbers | None = None,
    Q: Numbers | None = None,
    R: Numbers | None = None,
    N: Numbers | None = None,
    discrete: bool = False,
) -> Riccati:
    """The gain K of u = -K x that makes the integral, or sum, of x'Qx + 2 x'Nu + u'Ru smallest.

    The system is x' = A x + B u, or x+ = A x + B u if `discrete`. A python-control `StateSpace` can take the place of A
    and B, as in `lqr(system, Q, R)`; it says itself whether it is sampled. For a linearised system the answer carries
    the operating point, at which `StateFeedback.of(plant, answer)` holds the plant.

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
    DesignError
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
    call, point = "lqr(A, B, Q, R)", None
    if is_system(A):
        point = _point_of(A)
        call, discrete = "lqr(system, Q, R)", is_discrete(A)
        if B is not None:  # weights in the places of matrices, the rest of them by name
            Q, R, N = (B, R, N) if Q is None else (B, Q, R if N is None else N)
        A, B = A.A, A.B
    d = checked_data(call, A, B, Q, R, N)
    semidefinite(call, "Q", d.Q)
    _check_weights(call, d.Q, d.S, d.R)
    answer = stabilising_solution(call, d, discrete)
    return replace(answer, K=PointedGain.of(answer.K, point), point=point)


@dataclass(frozen=True)
@show
class Lqg:
    """A linear-quadratic-Gaussian controller from y to u, a python-control `StateSpace` with the feedback sign inside.

    For a linearised system, `controller` is relative to the operating point: in a `ClosedLoop` it reads y - y0 and adds
    u0. Its states are estimates of x - x0, zero at rest.

    `regulator` and `estimator` are the two halves. The `poles` (2 n,) are computed from the closed loop and not from
    its halves. The `certificate` has the worse number of both halves; its `residual` is the distance of the loop's
    poles from the poles of the halves.
    """

    controller: System
    regulator: Riccati
    estimator: Riccati
    poles: Complex
    certificate: Certificate


@check_arguments
def lqg(
    system: System, Q: Numbers, R: Numbers, Qn: Numbers, Rn: Numbers, N: Numbers | None = None, G: Numbers | None = None
) -> Lqg:
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
        (n, nw), where w enters; by default w enters at each state.

    Raises
    ------
    ValueError, DesignError
        If `system` is no `StateSpace`, the closed loop is not stable, or as `lqr` and `lqe`.

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
    estimator = replace(estimator, point=regulator.point)
    controller = _controller(system, regulator.K, estimator.K)
    loop, apart = _loops(system, controller, regulator.K, estimator.K)
    poles = np.asarray(np.linalg.eigvals(loop), dtype=complex)
    margins = _stable_margins(system, poles)
    certificate = Certificate(
        residual=norm(apart) / norm(loop),
        error=max(regulator.certificate.error, estimator.certificate.error),
        condition=max(regulator.certificate.condition, estimator.certificate.condition),
        decay_rate=float(margins.min()),
        newton_steps=max(regulator.certificate.newton_steps, estimator.certificate.newton_steps),
        warnings=tuple(_warnings(system, controller, regulator, estimator)),
    )
    return Lqg(controller, regulator, estimator, poles, certificate)


def _stable_margins(system: System, poles: Complex) -> Array:
    """The distance of each pole of the closed loop from instability; a loop that is not stable is refused."""
    margins = distances(poles, is_discrete(system))
    if not margins.min() > 0:
        raise DesignError(
            f"`lqg(system, Q, R, Qn, Rn)`: the loop of '{system.name}' and its controller is not stable: its pole "
            f"{pole_text(complex(poles[margins.argmin()]))} differs from those of its two halves by rounding. Choose "
            "other units, or milder weights."
        )
    return margins


def is_system(value: object) -> TypeGuard[System]:
    """True if a value is a linear system by its matrices, as python-control's `StateSpace`."""
    return all(hasattr(value, name) for name in ("A", "B", "C", "D", "dt"))


def _point_of(system: System) -> OperatingPoint | None:
    point = getattr(system, "point", None)
    return point if isinstance(point, OperatingPoint) else None


def is_discrete(system: System) -> bool:
    """True if a system is sampled: python-control writes 0 or None for one that is not."""
    return system.dt not in (0, None)


def _check_weights(call: str, Q: Array, N: Array, R: Array) -> None:
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


def _controller(system: System, K: Array, L: Array) -> System:
    import control  # takes seconds, and only this function needs it

    from workbench.design.linear.pointed_systems import PointedSpace, point_of

    inside = system.A - system.B @ K - L @ (system.C - system.D @ K)
    states = [f"{label}_hat" for label in system.state_labels]
    controller = control.ss(
        inside,
        L,
        -K,
        np.zeros((len(K), L.shape[1])),
        system.dt,
        name=f"lqg of {system.name}",
        states=states,
        inputs=list(system.output_labels),
        outputs=list(system.input_labels),
    )
    point = point_of(system)
    if point is None:
        return controller
    units = (unit for entry in point.states.entries for unit in entry.units)
    estimates = (Entry(name, np.zeros(()), unit) for name, unit in zip(states, units, strict=True))
    return PointedSpace(controller, point.of_controller(Layout(tuple(estimates))))


def _warnings(system: System, controller: System, regulator: Riccati, estimator: Riccati) -> Iterator[str]:
    for name, half in (("regulator", regulator), ("estimator", estimator)):
        yield from (f"{name}: {warning}" for warning in half.certificate.warnings)
    if not distances(np.linalg.eigvals(controller.A), is_discrete(system)).min() > 0:
        yield "the controller is unstable by itself: the loop must be closed before it runs"


def _loops(system: System, controller: System, K: Array, L: Array) -> tuple[Array, Array]:
    """The matrix (2 n, 2 n) of plant and controller, and its distance, in x and x - x_hat, from separation."""
    acting, seeing, n = system.B @ controller.C, controller.B @ system.C, len(system.A)
    loop = np.block([[system.A, acting], [seeing, controller.A + controller.B @ system.D @ controller.C]])
    change = np.block([[np.eye(n), np.zeros((n, n))], [np.eye(n), -np.eye(n)]])
    apart = np.block([[system.A - system.B @ K, system.B @ K], [np.zeros((n, n)), system.A - L @ system.C]])
    return loop, change @ loop @ change - apart
