"""A controller a little above the least gamma, for a search that measures its loops in its own way."""

from __future__ import annotations

import numpy as np

from workbench.design.matrices import EPS, DesignError
from workbench.design.synthesis.central_controller import central_controller
from workbench.design.synthesis.gamma_search import least_gamma
from workbench.design.synthesis.generalized_plant import PlantParts
from workbench.design.synthesis.normal_plant import Controller, NormalPlant
from workbench.design.synthesis.plant_conditions import check_conditions

FACTORS = 1.0, 4.0, 16.0  # times the distance above the optimum: where the first controller is spoiled by rounding


def nearly_least_controller(call: str, parts: PlantParts, above: float) -> tuple[Controller, float]:
    """The central controller at a relative distance above the least gamma, and its gamma, for a continuous plant.

    Its loop is stable by its computed poles; its norm is not measured here.
    """
    check_conditions(call, parts, None)
    normal = NormalPlant.of(parts)
    least = least_gamma(call, normal.parts)
    objection = "the least gamma is 0"
    for factor in FACTORS if least.value > 0 else ():
        level = max(least.value * (1 + factor * above), least.high * (1 + 8 * EPS))
        try:
            matrices = normal.controller(call, central_controller(call, normal.parts, level))
            A = parts.close(*matrices)[0]
        except (np.linalg.LinAlgError, DesignError) as error:
            objection = str(error)
            continue
        if np.isfinite(A).all() and np.linalg.eigvals(A).real.max() < 0:
            return matrices, level
        objection = f"its closed loop for gamma = {level:.6g} is not stable"
    raise DesignError(f"`{call}` finds no controller for the scaled plant: {objection}.")
