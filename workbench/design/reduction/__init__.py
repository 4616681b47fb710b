"""Models of lower order, each with the H-infinity norm of its error and the bound that a theorem promises.

This package takes stable systems of python-control and gives such systems. Read `balanced_realization.py` first, then
`balanced_reduction.py`.

Examples
--------
>>> import control
>>> lags = control.ss(control.tf([1.0], [1.0, 4.0, 6.0, 4.0, 1.0]))
>>> wb.reduction.balanced_truncation(lags, tolerance=0.1).order
2
"""

from workbench.design.reduction.balanced_realization import HankelValues, hankel_values
from workbench.design.reduction.balanced_reduction import balanced_truncation, singular_perturbation
from workbench.design.reduction.hankel_reduction import hankel_norm_reduction
from workbench.design.reduction.reduced_model import ReducedModel
from workbench.design.reduction.stable_part import StableSplit, stable_part

__all__ = [
    "HankelValues",
    "ReducedModel",
    "StableSplit",
    "balanced_truncation",
    "hankel_norm_reduction",
    "hankel_values",
    "singular_perturbation",
    "stable_part",
]
