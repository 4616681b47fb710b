"""Uncertain numbers: the designs that sample them, and the indices and quantiles that follow.

This package takes factors and samples of runs, and knows of loops only their numbers; `local_sensitivity` alone
simulates, to differentiate. Read `engine/factors` first, then `designs` and `sobol_indices`.

Examples
--------
>>> wb.uncertainty.MonteCarlo(2, 100, seed=1).points().shape
(100, 2)
"""

from workbench.engine.distributions import (
    AbstractDistribution,
    LogNormal,
    LogUniform,
    Normal,
    Triangular,
    Uniform,
)
from workbench.engine.factors import Factor, FactorDirection, Space
from workbench.study.uncertainty.designs import (
    AbstractDesign,
    LatinHypercube,
    ListedPoints,
    MonteCarlo,
    MorrisDesign,
    OneAtATime,
)
from workbench.study.uncertainty.effects import MorrisEffects, Tornado, morris, tornado
from workbench.study.uncertainty.factor_table import factor_table
from workbench.study.uncertainty.local_sensitivity import LocalSensitivities, local_sensitivities
from workbench.study.uncertainty.outputs import Estimate, Flags
from workbench.study.uncertainty.quantiles import Quantiles, Share, quantiles, share
from workbench.study.uncertainty.sobol_design import SobolDesign
from workbench.study.uncertainty.sobol_indices import SobolIndices, least_base, sobol

__all__ = [
    "AbstractDesign",
    "AbstractDistribution",
    "Estimate",
    "Factor",
    "FactorDirection",
    "Flags",
    "LatinHypercube",
    "ListedPoints",
    "LocalSensitivities",
    "LogNormal",
    "LogUniform",
    "MonteCarlo",
    "MorrisDesign",
    "MorrisEffects",
    "Normal",
    "OneAtATime",
    "Quantiles",
    "Share",
    "SobolDesign",
    "SobolIndices",
    "Space",
    "Tornado",
    "Triangular",
    "Uniform",
    "factor_table",
    "least_base",
    "local_sensitivities",
    "morris",
    "quantiles",
    "share",
    "sobol",
    "tornado",
]
