"""Kalman filters and smoothers over a log, in square-root form, with their likelihoods and tests of consistency.

Read `array_steps.py` first, then `forward_pass.py`; `matrix_filter.py` is for matrices, `nonlinear_filters.py` for
equations.

Examples
--------
>>> y = [[0.9], [1.1], [1.0]]
>>> level = wb.filters.kalman_filter(y, A=[[1]], C=[[1]], Q=[[0.01]], R=[[0.04]], x0=[0], P0=[[1]])
>>> level.smooth().x[:, 0].round(2)
array([0.97, 1.  , 1.  ])
"""

from workbench.identification.filters.consistency_test import ChiSquareBand, Consistency
from workbench.identification.filters.discrete_model import DiscreteModel
from workbench.identification.filters.filter_estimate import FilterEstimate, consistency
from workbench.identification.filters.matrix_filter import kalman_filter
from workbench.identification.filters.noise_covariances import NoiseCovariances, noise_covariances
from workbench.identification.filters.nonlinear_filters import (
    SigmaPoints,
    extended_kalman_filter,
    unscented_kalman_filter,
)
from workbench.identification.filters.parameter_walk import ParameterWalk
from workbench.identification.filters.smoothing import SmoothedEstimate
from workbench.identification.filters.stochastic_model import StochasticModel

__all__ = [
    "ChiSquareBand",
    "Consistency",
    "DiscreteModel",
    "FilterEstimate",
    "NoiseCovariances",
    "ParameterWalk",
    "SigmaPoints",
    "SmoothedEstimate",
    "StochasticModel",
    "consistency",
    "extended_kalman_filter",
    "kalman_filter",
    "noise_covariances",
    "unscented_kalman_filter",
]
