"""Figures of linear systems: norms, poles and zeros, each proved or with its error.

The room knows systems of python-control and matrices, and no robot, law or loop by name. Read `hinf_norm.py` first;
what is exact in it stands on `integer_polynomials.py` and `rational_matrices.py`.
"""

from workbench.design.frequency.channel_interaction import condition_number, relative_gains
from workbench.design.frequency.h2_norm import MeanGain, h2_norm
from workbench.design.frequency.hinf_norm import PeakGain, hinf_norm
from workbench.design.frequency.pole_zero_structure import PoleZeroStructure, Roots, pole_zero_structure

__all__ = [
    "MeanGain",
    "PeakGain",
    "PoleZeroStructure",
    "Roots",
    "condition_number",
    "h2_norm",
    "hinf_norm",
    "pole_zero_structure",
    "relative_gains",
]
