"""Numbers that describe linear systems: margins, norms, poles and zeros, responses, with their error bounds.

This package takes arrays and systems of python-control, also sampled ones; it knows no robot, law or loop by name. Read
`stability_margins.py` first for one loop, `hinf_norm.py` for norms, and `hold_loop.py` for a loop in a computer.

Examples
--------
>>> plant = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
>>> wb.frequency.bandwidth is wb.bandwidth
True
"""

from workbench.design.frequency.bandwidth import Bandwidth, LevelCrossing, bandwidth, sensitivity_bandwidth
from workbench.design.frequency.certified_values import CertifiedPeak, CertifiedValue
from workbench.design.frequency.channel_interaction import condition_number, relative_gains
from workbench.design.frequency.continuous_models import d2c
from workbench.design.frequency.discretization import c2d
from workbench.design.frequency.h2_norm import MeanGain, h2_norm
from workbench.design.frequency.hinf_norm import hinf_norm
from workbench.design.frequency.hold_loop import HoldLoop, HoldResponse, hold_loop
from workbench.design.frequency.margin_records import Crossover, StabilityMargins, StableMargins
from workbench.design.frequency.multirate import LiftedLoop, common_period, lift_rates
from workbench.design.frequency.period_poles import PeriodPoles
from workbench.design.frequency.pole_zero_structure import PoleZeroStructure, Roots, pole_zero_structure
from workbench.design.frequency.row_responses import RowResponses, row_responses
from workbench.design.frequency.stability_margins import stability_margins

__all__ = [
    "Bandwidth",
    "CertifiedValue",
    "Crossover",
    "HoldLoop",
    "HoldResponse",
    "LevelCrossing",
    "LiftedLoop",
    "MeanGain",
    "CertifiedPeak",
    "PeriodPoles",
    "PoleZeroStructure",
    "Roots",
    "RowResponses",
    "StabilityMargins",
    "StableMargins",
    "bandwidth",
    "c2d",
    "common_period",
    "condition_number",
    "d2c",
    "h2_norm",
    "hinf_norm",
    "hold_loop",
    "lift_rates",
    "pole_zero_structure",
    "relative_gains",
    "row_responses",
    "sensitivity_bandwidth",
    "stability_margins",
]
