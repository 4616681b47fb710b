"""Regulators with integral action, by states and by an estimator, with the gain of their anti-windup."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy import linalg

from workbench.core import Layout
from workbench.core.point import OperatingPoint
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, positive
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import Complex, DesignError, one_thread, pole_text
from workbench.design.riccati.algebraic_equation import distances
from workbench.design.riccati.kalman_gains import lqe
from workbench.design.riccati.regulators import lqr
from workbench.design.riccati.stabilising_solution import Riccati
from workbench.design.synthesis.plant_conditions import full_columns

if TYPE_CHECKING:
    import control

REFERENCE = "_ref"  # behind the name of an output: an input of the controller that is its reference
Matrices = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
@show
class IntegralRegulator:
    """The gains K (nu, n) and Ki (nu, nq) of u = -K x - Ki q, with q' = y - r for the outputs that follow references.

    `regulator` is the solution for the states and integrals together, with its certificate and poles. `outputs` are the
    indices of the outputs that are integrated.
    """

    K: Array
    Ki: Array
    outputs: tuple[int, ...]
    regulator: Riccati


@dataclass(frozen=True, eq=False)
@show
class LqgIntegral:
    """An LQG controller with integral action, from y and the references y_ref to u; the feedback sign is inside.

    `controller` runs in a `ClosedLoop` as it stands; its states are the n estimates and the nq integrals. `anti_windup`
    (n + nq, nu) is the gain M with which a `LimitedLaw` moves these states while the command is limited: it gives the
    estimator the limited command, and unwinds the integrals in the time Tt. `poles` are those of the closed loop.
    """

    controller: System
    anti_windup: Array
    regulator: IntegralRegulator
    estimator: Riccati
    poles: Complex


@check_arguments
def lqi(system: control.StateSpace, Q: Numbers, R: Numbers, outputs: Sequence[int] | None = None) -> IntegralRegulator:
    """The optimal gains of states and of integrals of output errors.

    The cost is the integral of [x; q]'Q[x; q] + u'Ru with q' = y - r. A sampled system has q+ = q + dt (y - r).

    Parameters
    ----------
    system
        The plant, a `StateSpace` with n states, nu inputs and ny outputs, nq of which are integrated.
    Q, R
        The weights of states and integrals (n + nq, n + nq), and of inputs (nu, nu).
    outputs
        The indices of the nq outputs that follow references; None for all.

    Raises
    ------
    ValueError
        If the system is no `StateSpace`, or has no such output.
    DesignError
        If the outputs cannot be held together, as the plant has a zero at s = 0 (z = 1) or too few inputs; or as `lqr`.

    References
    ----------
    Young, Willems (1972), An approach to the linear multivariable servomechanism problem, Int. J. Control 15.

    Examples
    --------
    >>> import control
    >>> answer = wb.synthesis.lqi(control.ss(-1.0, 1.0, 1.0, 0.0), Q=np.diag([1.0, 1.0]), R=[[1.0]])
    >>> answer.K.round(4), answer.Ki.round(4)
    (array([[1.]]), array([[1.]]))
    """
    call = "lqi(system, Q, R)"
    A, B, C, D = state_space(call, system)
    places = _places(call, outputs, len(C))
    n, period = len(A), float(system.dt) if system.dt else None
    E, F = C[list(places)], D[list(places)]
    _check_servo(call, (A, B, E, F), period)
    step = 1.0 if period is None else period
    whole = np.block([[A, np.zeros((n, len(E)))], [step * E, np.eye(len(E)) * (period is not None)]])
    answer = lqr(whole, np.vstack([B, step * F]), Q, R, discrete=period is not None)
    K = np.asarray(answer.K)
    return IntegralRegulator(K[:, :n], K[:, n:], places, answer)


@check_arguments
def lqg_integral(
    system: control.StateSpace,
    Q: Numbers,
    R: Numbers,
    Qn: Numbers,
    Rn: Numbers,
    outputs: Sequence[int] | None = None,
    Tt: float | None = None,
) -> LqgIntegral:
    """The controller u = -K x_hat - Ki q with a Kalman filter x_hat and integrals q' = y - r of the measured outputs.

    Parameters
    ----------
    system, Q, R, outputs
        As for `lqi`.
    Qn, Rn
        The intensities of the noises of states (n, n) and outputs (ny, ny), as for `lqg`.
    Tt
        The time in s in which the integrals follow the limits of a command; None for the time constant of the slowest
        pole of the regulator.

    Raises
    ------
    ValueError, DesignError
        As `lqi` and `lqg`; or if the closed loop is not stable.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> linear = wb.linearize(wb.open_loop(motor), 0.0, [0.0, 0.0])
    >>> answer = wb.lqg_integral(linear, Q=np.diag([1.0, 0.0, 400.0]), R=[[1.0]], Qn=np.eye(2), Rn=[[1e-3]])
    >>> wb.ClosedLoop(motor, controller=answer.controller, reference=wb.Step("omega", "rad/s", 1.0)).follows
    ('omega',)
    """
    call = "lqg_integral(system, Q, R, Qn, Rn)"
    plant = state_space(call, system)
    A, B, C, D = plant
    period = float(system.dt) if system.dt else None
    regulator = lqi(system, Q, R, outputs)
    estimator = lqe(A, np.eye(len(A)), C, Qn, Rn, discrete=period is not None)
    L, share = np.asarray(estimator.K), _share(regulator, Tt, period)
    with one_thread():
        matrices = _controller(plant, regulator, L, period)
        windup = np.vstack([B - L @ D, -share * np.linalg.pinv(regulator.Ki)])
        poles = _loop_poles(plant, matrices)
    margins = distances(poles, period is not None)
    if not margins.min() > 0:
        raise DesignError(
            f"`{call}`: the closed loop is not stable: its pole {pole_text(complex(poles[margins.argmin()]))} differs "
            "from those of its two halves by rounding. Choose other units, or milder weights."
        )
    return LqgIntegral(_system(system, matrices, regulator.outputs), windup, regulator, estimator, poles)


def _share(regulator: IntegralRegulator, Tt: float | None, period: float | None) -> float:
    """The rate 1/s at which integrals follow a limited command, or the share of the way in one period."""
    margin = float(distances(regulator.regulator.poles, period is not None).min())
    if Tt is None:
        return min(1.0, margin) if period is not None else margin
    time = positive("lqg_integral(Tt=...)", Tt)
    return 1 / time if period is None else min(1.0, period / time)


def _places(call: str, outputs: Sequence[int] | None, ny: int) -> tuple[int, ...]:
    places = tuple(range(ny)) if outputs is None else tuple(outputs)
    if not places or len(set(places)) != len(places) or not all(0 <= k < ny for k in places):
        raise ValueError(f"`{call}`: outputs must be different places from 0 to {ny - 1}, at least one; got {places}.")
    return places


def _check_servo(call: str, plant: Matrices, period: float | None) -> None:
    """Refuse outputs that no constant input holds at any value."""
    A, B, E, F = plant
    here = A if period is None else A - np.eye(len(A))
    if not full_columns(np.block([[here, B], [E, F]]).T):
        where = "s = 0" if period is None else "z = 1"
        raise DesignError(
            f"`{call}`: the plant has a zero at {where}, or more outputs to hold ({len(E)}) than inputs "
            f"({B.shape[1]}), so no constant input holds them at every reference. Integrate fewer outputs."
        )


def _controller(plant: Matrices, regulator: IntegralRegulator, L: Array, period: float | None) -> Matrices:
    """From y and the references of some to u; the states are x_hat and q."""
    A, B, C, D = plant
    K, Ki, places = regulator.K, regulator.Ki, list(regulator.outputs)
    nq, ny = len(places), len(C)
    chosen = np.eye(ny)[places] * (1.0 if period is None else period)
    into = B - L @ D
    hold = np.eye(nq) * (period is not None)
    inside = np.block([[A - L @ C - into @ K, -into @ Ki], [np.zeros((nq, len(A))), hold]])
    reads = np.block([[L, np.zeros((len(A), nq))], [chosen, -chosen[:, places]]])
    return inside, reads, -np.hstack([K, Ki]), np.zeros((len(K), ny + nq))


def _loop_poles(plant: Matrices, controller: Matrices) -> Complex:
    A, B, C, D = plant
    Ac, Bc, Cc, _ = controller
    By = Bc[:, : len(C)]
    loop = np.block([[A, B @ Cc], [By @ C, Ac + By @ D @ Cc]])
    return np.asarray(linalg.eigvals(loop), dtype=complex)


def _system(system: System, matrices: Matrices, places: tuple[int, ...]) -> System:
    """The controller with the names of the system, and its point if it has one."""
    import control  # takes seconds

    from workbench.design.linear.pointed_systems import PointedSpace, point_of

    outputs = list(system.output_labels)
    states = [f"{label}_hat" for label in system.state_labels] + [f"{outputs[k]}_integral" for k in places]
    controller = control.ss(
        *matrices,
        system.dt,
        name=f"lqg with integral action of {system.name}",
        states=states,
        inputs=outputs + [f"{outputs[k]}{REFERENCE}" for k in places],
        outputs=list(system.input_labels),
        remove_useless_states=False,
    )
    point = point_of(system)
    return controller if point is None else PointedSpace(controller, _point(point, states, places))


def _point(point: OperatingPoint, states: list[str], places: tuple[int, ...]) -> OperatingPoint:
    """The point of the controller: references rest where their outputs do, and its states are zero."""
    followed = point.part(list(places), range(len(point.u0)))
    integrals = [replace(e, name=f"{e.name}_integral", default=np.zeros(e.shape)) for e in followed.outputs.entries]
    hats = [replace(e, name=f"{e.name}_hat", default=np.zeros(e.shape)) for e in point.states.entries]
    references = [replace(e, name=f"{e.name}{REFERENCE}") for e in followed.outputs.entries]
    own = point.of_controller(Layout((*hats, *integrals)))
    return replace(
        own,
        x0=np.zeros(len(states)),
        inputs=point.outputs + Layout(tuple(references)),
        u0=np.concatenate([point.y0, followed.y0]),
    )
