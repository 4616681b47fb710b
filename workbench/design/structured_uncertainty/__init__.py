"""Structured singular values: how large a structured perturbation a loop bears, between two proved bounds.

This package takes matrices and stable systems of python-control, and blocks of a perturbation. Read
`structured_singular_value.py` first, then `robustness_over_frequency.py`, then `dk_iteration.py`.

Examples
--------
>>> mu = wb.structured_uncertainty
>>> mu.structured_singular_value([[0.0, 2.0], [0.5, 0.0]], [mu.ComplexScalar(1), mu.ComplexScalar(1)]).residual < 1e-12
True
"""

from workbench.design.structured_uncertainty.dk_iteration import DkIteration, DkRound, dk_iteration
from workbench.design.structured_uncertainty.robustness_over_frequency import (
    ScaledBand,
    StructuredPeak,
    robustness_over_frequency,
)
from workbench.design.structured_uncertainty.structured_singular_value import (
    StructuredSingularValue,
    structured_singular_value,
)
from workbench.design.structured_uncertainty.uncertainty_blocks import ComplexScalar, FullBlock, RealScalar

__all__ = [
    "ComplexScalar",
    "DkIteration",
    "DkRound",
    "FullBlock",
    "RealScalar",
    "ScaledBand",
    "StructuredPeak",
    "StructuredSingularValue",
    "dk_iteration",
    "robustness_over_frequency",
    "structured_singular_value",
]
