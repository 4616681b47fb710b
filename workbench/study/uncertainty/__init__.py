"""Uncertain numbers: their distributions, the designs that sample them, and the indices and quantiles that follow.

The room knows factors and samples of runs, and nothing of the loops behind them. Read `factors` first, then
`design` and
`indices`.
"""

from workbench.study.uncertainty.design import AbstractDesign
from workbench.study.uncertainty.effects import MorrisEffects, morris
from workbench.study.uncertainty.explicit import Listed
from workbench.study.uncertainty.indices import SobolIndices, sobol
from workbench.study.uncertainty.monte_carlo import LatinHypercube, MonteCarlo
from workbench.study.uncertainty.morris import MorrisDesign
from workbench.study.uncertainty.one_at_a_time import OneAtATime
from workbench.study.uncertainty.outputs import Estimate
from workbench.study.uncertainty.quantiles import Quantiles, Share, quantiles, share
from workbench.study.uncertainty.salib import sobol_by_salib
from workbench.study.uncertainty.saltelli import SobolDesign
from workbench.study.uncertainty.tornado import Tornado, tornado

__all__ = [
    "AbstractDesign",
    "LatinHypercube",
    "Listed",
    "MonteCarlo",
    "MorrisDesign",
    "OneAtATime",
    "SobolDesign",
    "Estimate",
    "MorrisEffects",
    "Quantiles",
    "Share",
    "SobolIndices",
    "Tornado",
    "morris",
    "quantiles",
    "share",
    "sobol",
    "sobol_by_salib",
    "tornado",
]
