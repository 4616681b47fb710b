"""Nonlinear predictive control: the design of a law that linearises the plant anew in each period.

This package takes linear systems, and knows no plant: `wb.NonlinearPredictive` is the block. Read
`nonlinear_design.py` first.
"""

from workbench.planning.nonlinear_mpc.nonlinear_design import NonlinearPredictiveDesign, nonlinear_predictive_design

__all__ = ["NonlinearPredictiveDesign", "nonlinear_predictive_design"]
