"""Loop transfer recovery: an LQG controller whose loop comes near to the loop of state feedback, or of a filter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, describe, positive
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.certified_values import CertifiedPeak
from workbench.design.frequency.hinf_norm import hinf_norm
from workbench.design.frequency.pole_zero_structure import pole_zero_structure
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import Complex, DesignError, matrix, pole_text
from workbench.design.riccati.kalman_gains import lqe
from workbench.design.riccati.regulators import lqr
from workbench.design.riccati.stabilising_solution import Riccati
from workbench.design.synthesis.controller_systems import controller_system, loop_poles
from workbench.design.synthesis.coprime_margin import four_block_plant

if TYPE_CHECKING:
    import control

CALL = "loop_transfer_recovery(system, gain, recovery)"


@dataclass(frozen=True, eq=False)
@show
class LoopRecovery:
    """A controller from y to u whose loop, cut at the plant's input or output (`at`), is near to the target loop.

    The feedback sign is inside. `distance` is the certified H-infinity norm of T - T0, where T is the complementary
    sensitivity at that cut and T0 the target. It goes to zero as the recovery grows. `solution` is the Riccati solution
    of the half that is designed here: the filter for "input", the regulator for "output". `poles` are those of the
    closed loop.
    """

    controller: System
    at: str
    distance: CertifiedPeak
    solution: Riccati
    poles: Complex


@check_arguments
def loop_transfer_recovery(
    system: control.StateSpace, gain: Numbers, recovery: float, at: str = "input"
) -> LoopRecovery:
    """The LQG controller that recovers the loop K (s I - A)^-1 B at the input, or C (s I - A)^-1 L at the output.

    At the input, `gain` is K of u = -K x, and the filter is designed for noise of intensity recovery^2 at the plant's
    inputs and unit noise at its outputs. At the output, `gain` is L of a filter, and the regulator weighs outputs by
    recovery^2 and inputs by one.

    Parameters
    ----------
    system
        The plant, a square `StateSpace` in continuous time without a direct term.
    gain
        K (nu, nx) or L (nx, ny), with A - B K or A - L C stable.
    recovery
        A positive number. A larger one recovers more of the loop, and amplifies more noise.
    at
        "input" or "output".

    Raises
    ------
    ValueError
        If the system is sampled or has a direct term D, or an argument is none of the above.
    DesignError
        If the plant has a zero in the right half-plane or on its edge, or is not square: the loop is not recovered.

    References
    ----------
    Doyle, Stein (1981), Multivariable feedback design: concepts for a classical/modern synthesis, IEEE Trans. Autom.
    Control 26. Stein, Athans (1987), The LQG/LTR procedure for multivariable feedback control design, the same, 32.

    Examples
    --------
    >>> import control
    >>> plant = control.ss([[0.0, 1.0], [0.0, -1.0]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    >>> K = wb.lqr(plant, np.diag([10.0, 1.0]), [[1.0]]).K
    >>> far, near = (wb.synthesis.loop_transfer_recovery(plant, K, q).distance.gain.value for q in (10.0, 1000.0))
    >>> near < far / 5
    True
    """
    if at not in ("input", "output"):
        raise ValueError(f'`{CALL}`: at must be "input" or "output"; got {describe(at)}.')
    A, B, C, D = state_space(CALL, system)
    if system.dt:
        raise ValueError(f"`{CALL}`: the system must be continuous; '{system.name}' has the period {system.dt}.")
    if D.any():
        raise ValueError(f"`{CALL}`: the system must have D = 0; its largest entry is {np.abs(D).max():.3g}.")
    q = positive("loop_transfer_recovery(recovery=...)", recovery)
    _check_zeros(system)
    K, L, solution = _halves((A, B, C), gain, q, at)
    plant = four_block_plant(system)
    inside, none = A - B @ K - L @ C, np.zeros((len(K), len(C)))
    controller = controller_system(plant, (inside, L, -K, none), f"ltr of {system.name}")
    loop = plant.close(controller)
    distance = hinf_norm(_difference(A, B, C, K, L, at))
    if distance.reason:
        raise DesignError(f"`{CALL}`: the closed loop is not stable by rounding. Choose a smaller recovery.")
    return LoopRecovery(controller, at, distance, solution, loop_poles(loop))


def _halves(plant: tuple[Array, Array, Array], gain: Numbers, q: float, at: str) -> tuple[Array, Array, Riccati]:
    """K and L, one as given and the other designed."""
    A, B, C = plant
    n, nu, ny = len(A), B.shape[1], len(C)
    if at == "input":
        K = matrix(CALL, "gain", gain, nu, n)
        solution = lqe(A, B, C, q**2 * np.eye(nu), np.eye(ny))
        L = np.asarray(solution.K)
    else:
        L = matrix(CALL, "gain", gain, n, ny)
        solution = lqr(A, B, q**2 * C.T @ C, np.eye(nu))
        K = np.asarray(solution.K)
    _check_target(A - B @ K if at == "input" else A - L @ C, at)
    return K, L, solution


def _check_zeros(system: System) -> None:
    """Refuse a plant whose inverse is unstable, or that has none."""
    structure = pole_zero_structure(system)
    ny, nu = system.noutputs, system.ninputs
    if ny != nu or structure.normal_rank < nu:
        raise DesignError(
            f"`{CALL}`: the plant must have as many outputs as inputs, all independent; it has {ny} and {nu}, of rank "
            f"{structure.normal_rank}. Take a square part of it."
        )
    for zero in structure.invariant_zeros.values:
        if zero.real >= 0:
            raise DesignError(
                f"`{CALL}`: the plant is not minimum-phase: its zero {pole_text(complex(zero))} does not lie "
                "left of the imaginary axis, and no controller recovers the loop there. Use `hinf_controller`."
            )


def _check_target(closed: Array, at: str) -> None:
    poles = np.linalg.eigvals(closed)
    if poles.real.max() >= 0:
        matrices = "A - B K" if at == "input" else "A - L C"
        raise ValueError(
            f"`{CALL}`: gain must make {matrices} stable; it has the eigenvalue "
            f"{pole_text(complex(poles[poles.real.argmax()]))}."
        )


def _difference(A: Array, B: Array, C: Array, K: Array, L: Array, at: str) -> System:
    """T - T0 at the input or the output, with the states x, x - x_hat and those of the target loop.

    At the input T is K x_hat by the reference of u. The loop u = r - K x_hat has x' = (A - B K) x + B K e + B r, and
    the error e = x - x_hat obeys e' = (A - L C) e + B r as the estimator does not know r; T0 has e = 0. So T - T0 needs
    two states only: d' = (A - B K) d + B K e, with the output K d - K e. The output's loop is its dual.
    """
    import control  # takes seconds

    n, zero = len(A), np.zeros_like(A)
    if at == "output":
        A, B, C, K, L = A.T, C.T, B.T, L.T, K.T
    whole = np.block([[A - B @ K, B @ K], [zero, A - L @ C]])
    entry = np.vstack([np.zeros((n, B.shape[1])), B])
    return control.ss(whole, entry, np.hstack([K, -K]), 0.0, remove_useless_states=False)
