"""The largest margin of normalised coprime factors, and the controller that nearly reaches it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.certified_values import CertifiedValue, widen
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import Certificate, Complex, DesignError, one_thread
from workbench.design.riccati.algebraic_equation import Data
from workbench.design.riccati.stabilising_solution import Riccati, stabilising_solution
from workbench.design.synthesis.closed_loop_norm import closed_loop_norm
from workbench.design.synthesis.controller_systems import controller_system, loop_poles
from workbench.design.synthesis.generalized_plant import (
    GeneralizedPlant,
    sampled_matrices,
)
from workbench.design.synthesis.normal_plant import Controller
from workbench.design.synthesis.plant_conditions import hidden_modes, mode_text

if TYPE_CHECKING:
    import control

CALL = "coprime_margin(system)"
FRACTION = 0.95
SHORT = 1e-6  # relative, by which rounding may keep a controller below its asked margin


@dataclass(frozen=True, eq=False)
@show
class CoprimeMargin:
    """The largest margin `b_opt` of a system, and a controller from y to u with the feedback sign inside.

    A controller with margin b stabilises each plant whose normalised coprime factors differ by less than b in the
    H-infinity norm. `margin` is the certified margin of the `controller`, 1 / ||[I; K] (I - G K)^-1 [I, G]||, and
    `poles` are those of its loop. X and Z (n, n) solve the two Riccati equations; of each number of their certificates,
    the `certificate` has the worse one.
    """

    b_opt: float
    controller: System
    margin: CertifiedValue
    poles: Complex
    X: Array
    Z: Array
    certificate: Certificate


@check_arguments
def coprime_margin(system: control.StateSpace, fraction: float = FRACTION) -> CoprimeMargin:
    """The margin b_opt = (1 + lambda_max(X Z))^-1/2 of a system, and a controller with a `fraction` of it.

    X and Z solve the Riccati equations of the regulator and of the filter of a normalised coprime factorisation. No
    controller has a larger margin. If b_opt is below about 0.2, the shaped plant cannot be made robust: choose other
    weights, with a lower crossover. A sampled system is designed by its bilinear transform, which keeps the margin.

    Parameters
    ----------
    system
        The plant with its shaping weights in series, a `StateSpace`. The controller belongs to both together: the law
        of the plant alone is the controller in series with the weights.
    fraction
        The margin of the controller over b_opt, above 0 and below 1; near 1 the controller has a very fast mode.

    Raises
    ------
    ValueError
        If the system is no `StateSpace`, or the fraction not between 0 and 1.
    DesignError
        If an unstable mode is not stabilisable or not detectable, or no solution can be trusted.

    References
    ----------
    Glover, McFarlane (1989), Robust stabilization of normalized coprime factor plant descriptions, IEEE Trans. Autom.
    Control 34. Skogestad, Postlethwaite (2005), Multivariable Feedback Control, section 9.4.

    Examples
    --------
    >>> import control
    >>> answer = wb.coprime_margin(control.ss(0.0, 1.0, 1.0, 0.0))
    >>> round(answer.b_opt, 12), answer.margin.low > 0.94 * answer.b_opt
    (0.707106781187, True)
    """
    share = finite("coprime_margin(fraction=...)", fraction, low=0.0, high=1.0)
    if not 0 < share < 1:
        raise ValueError(f"`coprime_margin(fraction=...)` must lie between 0 and 1, and not on them; got {share:g}.")
    plant = four_block_plant(system)
    with one_thread():
        parts = plant.parts if plant.dt is None else plant.parts.bilinear(CALL)
        A, B, C, D = parts.A, parts.B2, parts.C2, parts.D22
        _check_modes(A, B, C, plant.dt)
        x, z = _equations(A, B, C, D)
        b_opt = _margin(x.X, z.X)
        matrices = _controller(A, B, C, D, x.X, z.X, 1 / (share * b_opt))
    matrices = matrices if plant.dt is None else sampled_matrices(*matrices)
    controller = controller_system(plant, matrices, f"coprime controller of {system.name}")
    loop = plant.close(controller)
    norm = closed_loop_norm(plant, controller).gain
    margin = widen(1 / norm.value, 1 / norm.high, 1 / norm.low)
    if not margin.low >= share * b_opt * (1 - SHORT):
        raise DesignError(
            f"`{CALL}`: the controller for the margin {share * b_opt:.6g} has the margin {margin.value:.6g} only, by "
            "rounding. Choose a smaller fraction, or other units."
        )
    return CoprimeMargin(b_opt, controller, margin, loop_poles(loop), x.X, z.X, _worse(x, z))


def four_block_plant(system: System) -> GeneralizedPlant:
    """The generalized plant of [I; K] (I - G K)^-1 [I, G]: disturbances at y and u, with both as errors."""
    from workbench.design.linear.pointed_systems import point_of

    A, B, C, D = state_space("coprime_margin", system)
    n, nu, ny = len(A), B.shape[1], len(C)
    if not n:
        raise ValueError(f"`{CALL}`: the system must have at least one state; '{system.name}' has none.")
    return GeneralizedPlant(
        A=A,
        B1=np.hstack([np.zeros((n, ny)), B]),
        B2=B,
        C1=np.vstack([C, np.zeros((nu, n))]),
        C2=C,
        D11=np.block([[np.eye(ny), D], [np.zeros((nu, ny + nu))]]),
        D12=np.vstack([D, np.eye(nu)]),
        D21=np.hstack([np.eye(ny), D]),
        D22=D,
        dt=float(system.dt) if system.dt else None,
        measurements=tuple(system.output_labels),
        controls=tuple(system.input_labels),
        point=point_of(system),
    )


def _check_modes(A: Array, B: Array, C: Array, period: float | None) -> None:
    for pair, verb, other, moves in (
        ("(A, B)", "stabilisable", (A, B), "no input moves"),
        ("(C, A)", "detectable", (A.T, C.T), "no output shows"),
    ):
        for mode in hidden_modes(*other):
            raise DesignError(
                f"`{CALL}`: the pair {pair} is not {verb}: {moves} the mode {mode_text(mode.value, period)} of A "
                f"(relative distance {mode.margin:.1e}), so no controller stabilises the system and its margin is zero."
            )


def _equations(A: Array, B: Array, C: Array, D: Array) -> tuple[Riccati, Riccati]:
    """The solutions of both equations of the normalised coprime factors."""
    regulator = Data(A, B, C.T @ C, np.eye(B.shape[1]) + D.T @ D, C.T @ D, None)
    estimator = Data(A.T, C.T, B @ B.T, np.eye(len(C)) + D @ D.T, B @ D.T, None)
    return stabilising_solution(CALL, regulator, False), stabilising_solution(CALL, estimator, False)


def _margin(X: Array, Z: Array) -> float:
    """(1 + lambda_max(X Z))^-1/2, from the symmetric matrix with the same eigenvalues."""
    values, vectors = np.linalg.eigh(Z)
    root = vectors * np.sqrt(np.maximum(values, 0))
    largest = float(np.linalg.eigvalsh(root.T @ X @ root)[-1])
    return float((1 + max(largest, 0.0)) ** -0.5)


def _controller(A: Array, B: Array, C: Array, D: Array, X: Array, Z: Array, gamma: float) -> Controller:
    """The central controller for 1 / gamma, by Skogestad and Postlethwaite (2005), equation 9.71."""
    F = -np.linalg.solve(np.eye(B.shape[1]) + D.T @ D, D.T @ C + B.T @ X)
    W = (1 - gamma**2) * np.eye(len(A)) + Z @ X
    entering = np.asarray(gamma**2 * np.linalg.solve(W, Z @ C.T))
    return A + B @ F + entering @ (C + D @ F), entering, B.T @ X, -D.T


def _worse(x: Riccati, z: Riccati) -> Certificate:
    a, b = x.certificate, z.certificate
    return Certificate(
        residual=max(a.residual, b.residual),
        error=max(a.error, b.error),
        condition=max(a.condition, b.condition),
        decay_rate=min(a.decay_rate, b.decay_rate),
        newton_steps=max(a.newton_steps, b.newton_steps),
        warnings=(*a.warnings, *b.warnings),
    )
