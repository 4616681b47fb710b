"""Figures of linear systems: sampled loops, discretisation, and frequency answers of many systems at once.

The room knows arrays and systems of python-control, and no robot, law or loop by name. Read `hold_loop.py` first for a
loop in a computer, `multirate.py` for one with several periods, and `discretization.py` for `c2d`.
"""

from workbench.design.frequency.discretization import c2d
from workbench.design.frequency.hold_loop import HoldLoop, HoldResponse, hold_loop
from workbench.design.frequency.multirate import LiftedLoop, common_period, lift_rates
from workbench.design.frequency.period_poles import PeriodPoles
from workbench.design.frequency.row_responses import RowResponses, row_responses

__all__ = [
    "HoldLoop",
    "HoldResponse",
    "LiftedLoop",
    "PeriodPoles",
    "RowResponses",
    "c2d",
    "common_period",
    "hold_loop",
    "lift_rates",
    "row_responses",
]
