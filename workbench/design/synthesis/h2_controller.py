"""H2 controllers: two Riccati equations, and a closed loop whose H2 norm is computed exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.h2_norm import MeanGain, h2_norm
from workbench.design.matrices import Complex, DesignError, one_thread
from workbench.design.riccati.algebraic_equation import Data
from workbench.design.riccati.stabilising_solution import Riccati, stabilising_solution
from workbench.design.synthesis.controller_systems import controller_system, loop_poles
from workbench.design.synthesis.generalized_plant import GeneralizedPlant, PlantParts
from workbench.design.synthesis.normal_plant import Controller, without_direct_path
from workbench.design.synthesis.plant_conditions import check_conditions

CALL = "h2_controller(plant)"
APART = 1e-6  # relative: most that the exact norm may lie above the optimum of the Riccati equations


@dataclass(frozen=True, eq=False)
@show
class H2Controller:
    """The H2-optimal controller of a plant from y to u, with the feedback sign inside.

    `norm` is the certified H2 norm of the closed loop from w to z. `least` is the optimum by the Riccati equations; the
    two differ by at most 1e-6 of it. `control` and `filter` are the solutions of these equations, and `poles` are those
    of the closed loop.
    """

    controller: System
    norm: MeanGain
    least: float
    poles: Complex
    control: Riccati
    filter: Riccati


@check_arguments
def h2_controller(plant: GeneralizedPlant) -> H2Controller:
    """The controller that makes the H2 norm from w to z least: the root mean square of z under unit white noise w.

    In continuous time D11 must be zero, or white noise passes to z with infinite power. A sampled plant has its own
    Riccati equations, and its controller has a direct term.

    Raises
    ------
    DesignError
        If the plant breaks a condition, which is named, D11 is not zero, or no solution can be trusted.

    References
    ----------
    Zhou, Doyle, Glover (1996), Robust and Optimal Control, sections 14.5 and 21.7. Doyle, Glover, Khargonekar, Francis
    (1989), IEEE Trans. Autom. Control 34.

    Examples
    --------
    >>> plant = wb.synthesis.GeneralizedPlant(
    ...     A=[[0.0]], B1=[[1.0, 0.0]], B2=[[1.0]], C1=[[1.0], [0.0]], C2=[[1.0]],
    ...     D11=[[0.0, 0.0], [0.0, 0.0]], D12=[[0.0], [1.0]], D21=[[0.0, 1.0]], D22=[[0.0]],
    ... )
    >>> answer = wb.h2_controller(plant)
    >>> round(answer.norm.gain.value, 9), answer.poles.real.round(6)
    (1.414213562, array([-1., -1.]))
    """
    p = plant.parts
    discrete = plant.dt is not None
    with one_thread():
        check_conditions(CALL, p.bilinear(CALL) if discrete else p, plant.dt)
        if not discrete and p.D11.any():
            raise DesignError(
                f"`{CALL}`: D11 must be zero in continuous time, or white noise passes straight to the errors with "
                f"infinite power; its largest entry is {np.abs(p.D11).max():.3g}. Give that path the lag that it has."
            )
        control = stabilising_solution(CALL, _regulator(p), discrete)
        estimator = stabilising_solution(CALL, _regulator(p.dual()), discrete)
        design = _sampled if discrete else _continuous
        matrices, square = design(p, control, estimator)
        matrices = without_direct_path(CALL, matrices, p.D22)
    controller = controller_system(plant, matrices, "H2 controller")
    loop = plant.close(controller)
    norm, least = h2_norm(loop), float(np.sqrt(max(square, 0.0)))
    if norm.reason or not norm.gain.value <= least * (1 + APART) + 1e-150:
        raise DesignError(
            f"`{CALL}`: the closed loop has the H2 norm {norm.gain.value:.6g}, and {least:.6g} is the optimum by the "
            "Riccati equations. Rounding spoils this design: choose other units."
        )
    return H2Controller(controller, norm, least, loop_poles(loop), control, estimator)


def _regulator(p: PlantParts) -> Data:
    """The Riccati equation of the control half; that of the dual plant is the filter's."""
    return Data(p.A, p.B2, p.C1.T @ p.C1, p.D12.T @ p.D12, p.C1.T @ p.D12, None)


def _continuous(p: PlantParts, control: Riccati, estimator: Riccati) -> tuple[Controller, float]:
    """The controller without D22, and the square of the least norm."""
    F, L = -np.asarray(control.K), -np.asarray(estimator.K).T
    A = p.A + p.B2 @ F + L @ p.C2
    weighted = p.D12 @ F
    square = np.trace(p.B1.T @ control.X @ p.B1) + np.trace(weighted @ estimator.X @ weighted.T)
    return (A, -L, F, np.zeros((len(F), L.shape[1]))), float(square)


def _sampled(p: PlantParts, control: Riccati, estimator: Riccati) -> tuple[Controller, float]:
    """The sampled controller without D22, which uses the latest measurement, and the square of its norm."""
    X, Y = control.X, estimator.X
    R, S = p.D12.T @ p.D12 + p.B2.T @ X @ p.B2, p.D21 @ p.D21.T + p.C2 @ Y @ p.C2.T
    F, L = -np.asarray(control.K), -np.asarray(estimator.K).T
    F0 = -np.linalg.solve(R, p.B2.T @ X @ p.B1 + p.D12.T @ p.D11)
    L0 = np.asarray(np.linalg.solve(S, (F @ Y @ p.C2.T + F0 @ p.D21.T).T).T)
    A = p.A + p.B2 @ F + L @ p.C2 - p.B2 @ L0 @ p.C2
    K = A, -(L - p.B2 @ L0), F - L0 @ p.C2, L0
    full = p.D11.T @ p.D11 + p.B1.T @ X @ p.B1
    known = np.trace(full) - np.trace(F0.T @ R @ F0)
    unknown = np.trace(R @ (F @ Y @ F.T + F0 @ F0.T)) - np.trace(R @ L0 @ S @ L0.T)
    return K, float(known + unknown)
