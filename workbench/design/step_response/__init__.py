"""The step response of a linear system: rise, settling, overshoot and peak, found beyond any grid, with their bounds.

The room knows systems of python-control, and no loop or law. Read `step_info.py` first, then `response_modes.py` for
the sum of exponentials and `response_pieces.py` for how it is searched.
"""

from workbench.design.step_response.step_info import StepInfo, exact_figures, step_info

__all__ = ["StepInfo", "exact_figures", "step_info"]
