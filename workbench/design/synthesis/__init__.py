"""Controllers from a generalized plant or a model: H-infinity, H2, coprime factors, least peaks, integral action.

This package takes matrices and systems of python-control; it knows no plant of the workbench. Read
`generalized_plant.py` first, then `hinf_controller.py`. Each controller is measured again by the proved norms of
`workbench.design.frequency`.

Examples
--------
>>> round(wb.synthesis.least_sensitivity([1.0, -4.0], [1.0, -1.0]).gamma, 9)
1.666666667
"""

from workbench.design.synthesis.coprime_margin import CoprimeMargin, coprime_margin
from workbench.design.synthesis.generalized_plant import GeneralizedPlant
from workbench.design.synthesis.h2_controller import H2Controller, h2_controller
from workbench.design.synthesis.hinf_controller import HinfController, hinf_controller
from workbench.design.synthesis.integral_action import IntegralRegulator, LqgIntegral, lqg_integral, lqi
from workbench.design.synthesis.least_sensitivity import (
    LeastPeak,
    least_complementary_sensitivity,
    least_sensitivity,
)
from workbench.design.synthesis.loop_recovery import LoopRecovery, loop_transfer_recovery
from workbench.design.synthesis.mixed_sensitivity import mixed_sensitivity

__all__ = [
    "CoprimeMargin",
    "GeneralizedPlant",
    "H2Controller",
    "HinfController",
    "IntegralRegulator",
    "LeastPeak",
    "LoopRecovery",
    "LqgIntegral",
    "coprime_margin",
    "h2_controller",
    "hinf_controller",
    "least_complementary_sensitivity",
    "least_sensitivity",
    "loop_transfer_recovery",
    "lqg_integral",
    "lqi",
    "mixed_sensitivity",
]
