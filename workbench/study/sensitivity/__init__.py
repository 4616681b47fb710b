"""What the runs of a design say of its factors: indices, effects and quantiles, each with its interval."""

from workbench.study.sensitivity.effects import MorrisEffects, morris
from workbench.study.sensitivity.indices import SobolIndices, sobol
from workbench.study.sensitivity.outputs import Estimate
from workbench.study.sensitivity.quantiles import Quantiles, Share, quantiles, share
from workbench.study.sensitivity.salib import sobol_by_salib
from workbench.study.sensitivity.tornado import Tornado, tornado

__all__ = [
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
