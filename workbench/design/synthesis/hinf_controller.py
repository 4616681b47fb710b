"""H-infinity controllers: the least gamma from both sides, and a controller whose closed loop is proved to keep it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import positive
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.certified_values import CertifiedPeak, CertifiedValue
from workbench.design.matrices import Complex, DesignError, one_thread
from workbench.design.synthesis.central_controller import central_controller
from workbench.design.synthesis.closed_loop_norm import closed_loop_norm
from workbench.design.synthesis.controller_systems import controller_system, is_stable, likely_gain, loop_poles
from workbench.design.synthesis.game_conditions import Game
from workbench.design.synthesis.gamma_search import LeastGamma, least_gamma
from workbench.design.synthesis.generalized_plant import GeneralizedPlant, sampled_matrices
from workbench.design.synthesis.normal_plant import NormalPlant
from workbench.design.synthesis.plant_conditions import check_conditions

CALL = "hinf_controller(plant)"
ABOVE = (5e-7, 4e-6, 4e-5, 4e-4, 4e-3)  # relative distances above the optimum at which a controller is built
ATTAINED = 2.0  # times such a distance: the norm that is still accepted
WIDEST = 1e-6  # relative: a least gamma that is known no better is refused
ROUNDING = 1e-9  # relative, by which a norm may exceed its level


@dataclass(frozen=True, eq=False)
@show
class HinfController:
    """An H-infinity controller of a plant from y to u, a python-control `StateSpace` with the feedback sign inside.

    `gamma` encloses the infimum over all stabilising controllers: at `gamma.low` the condition `limit` fails; without
    an asked level `gamma.high` is the norm that the controller attains, and otherwise a level at which all conditions
    hold. `level` is the gamma for which the controller is the central one. `norm` is the certified H-infinity norm from
    w to z of the loop of the plant and the controller as they are written, without rounding between them; it may differ
    in the sixth digit from that of `plant.close(controller)`, which is rounded. `poles` are the loop's poles.
    """

    controller: System
    gamma: CertifiedValue
    limit: str
    level: float
    norm: CertifiedPeak
    poles: Complex


@check_arguments
def hinf_controller(plant: GeneralizedPlant, gamma: float | None = None) -> HinfController:
    """The central controller that makes the H-infinity norm from w to z smaller than gamma, or nearly the least.

    The least gamma is found by the conditions of Glover and Doyle with a full D11. Without `gamma` the controller is
    built just above the optimum, where its fastest mode may be some 1e6 times faster than the plant; a gamma one
    percent larger gives a slower controller. A sampled plant is designed by its bilinear transform, which keeps every
    norm.

    Parameters
    ----------
    gamma
        The level that the norm must stay below; None for nearly the least.

    Raises
    ------
    ValueError
        If gamma is not a positive number.
    DesignError
        If the plant breaks a condition, which is named, if gamma is below the least one, or if no controller passes
        the check by its closed loop's norm.

    References
    ----------
    Doyle, Glover, Khargonekar, Francis (1989), State-space solutions to standard H2 and H-infinity control problems,
    IEEE Trans. Autom. Control 34. Glover, Doyle (1988), Systems Control Lett. 11. Zhou, Doyle, Glover (1996), chapter
    17.

    Examples
    --------
    >>> plant = wb.synthesis.GeneralizedPlant(
    ...     A=[[0.0]], B1=[[1.0, 0.0]], B2=[[1.0]], C1=[[1.0], [0.0]], C2=[[1.0]],
    ...     D11=[[0.0, 0.0], [0.0, 0.0]], D12=[[0.0], [1.0]], D21=[[0.0, 1.0]], D22=[[0.0]],
    ... )
    >>> answer = wb.hinf_controller(plant)
    >>> round(answer.gamma.value, 9), answer.limit[:29]
    (1.414213562, 'the spectral radius of X Y is')
    """
    level = None if gamma is None else positive("hinf_controller(gamma=...)", gamma)
    with one_thread(), np.errstate(all="ignore"):
        parts = plant.parts if plant.dt is None else plant.parts.bilinear(CALL)
        check_conditions(CALL, parts, plant.dt)
        normal = NormalPlant.of(parts)
        least = least_gamma(CALL, normal.parts)
        _check_level(normal, least, level)
        levels = [least.value * (1 + above) for above in ABOVE] if level is None else [level]
        return _first_that_passes(plant, normal, least, levels, asked=level is not None)


def _check_level(normal: NormalPlant, least: LeastGamma, level: float | None) -> None:
    """Refuse a level that no controller reaches, and the least one where it is not known."""
    if level is None and least.value == 0:
        raise DesignError(
            f"`{CALL}`: the least gamma is 0: controllers of ever larger gain make z as small as you like. Ask for "
            "a gamma, or add noise or a weight that limits the gain."
        )
    if level is None and least.width > WIDEST:
        raise DesignError(
            f"`{CALL}`: the least gamma is about {least.value:.6g}, and rounding of the plant's numbers moves it "
            f"by a part of {least.width:.1e}. Ask for a gamma above {least.high:.6g}, or choose other units."
        )
    if level is not None and level <= least.low:
        failure = Game.of(normal.parts).judge(level)
        raise DesignError(
            f"`{CALL}`: gamma = {level:.9g} is infeasible, as it is below the least one, {least.value:.9g}: there "
            f"{failure.text}. Ask for a larger gamma, or weigh less."
        )


def _first_that_passes(
    plant: GeneralizedPlant, normal: NormalPlant, least: LeastGamma, levels: list[float], asked: bool
) -> HinfController:
    """The answer for the first level whose controller stabilises and keeps to it, as is proved."""
    objection = ""
    for level in levels:
        try:
            matrices = normal.controller(CALL, central_controller(CALL, normal.parts, level))
            matrices = matrices if plant.dt is None else sampled_matrices(*matrices)
            controller = controller_system(plant, matrices, "hinf controller")
            loop = plant.close(controller)
        except (np.linalg.LinAlgError, DesignError) as error:
            objection = objection or str(error)
            continue
        if not is_stable(loop):
            objection = objection or "its closed loop is not stable"
            continue
        allowed = (level if asked else level + ATTAINED * (level - least.value)) * (1 + ROUNDING)
        if (gain := likely_gain(loop)) > allowed:
            objection = objection or f"its closed loop has the norm {gain:.9g}"
            continue
        norm = closed_loop_norm(plant, controller)
        if not norm.gain.high <= allowed:
            objection = objection or f"its closed loop has the norm {norm.gain.value:.9g}"
            continue
        if norm.gain.high < least.low:
            raise DesignError(
                f"`{CALL}`: rounding decides the conditions, as they fail at gamma = {least.low:.6g} and a controller "
                f"reaches {norm.gain.high:.6g}. The least gamma may be 0; ask for a gamma, or choose other units."
            )
        high = max(least.high, least.value) if asked else norm.gain.high
        enclosure = CertifiedValue(least.value, least.low, high)
        return HinfController(controller, enclosure, least.failure.text, level, norm, loop_poles(loop))
    raise DesignError(
        f"`{CALL}`: no controller for gamma = {levels[0]:.9g} passes the check by its closed loop: {objection}. Ask "
        "for a larger gamma, or choose other units."
    )
