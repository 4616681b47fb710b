"""Sobol indices by SALib (Herman and Usher 2017, Journal of Open Source Software 2(9)), in the same runs as ours."""

from typing import Any, NamedTuple

import numpy as np
from SALib.analyze import sobol as analysis

from workbench.core.validation.refusals import Array
from workbench.study.uncertainty import Estimate, SobolDesign


class SalibIndices(NamedTuple):
    """Indices of one output, each with the half-width of the bootstrap's interval."""

    S1: Estimate
    ST: Estimate
    S2: Estimate | None


def sobol_by_salib(design: SobolDesign, y: Array, seed: int = 0) -> SalibIndices:
    """The indices of y (N,), with intervals as if the rows of a Sobol net were independent draws."""
    d = design.dimensions
    problem = {"num_vars": d, "names": [f"x{i}" for i in range(d)], "bounds": [[0.0, 1.0]] * d}
    # SALib takes a seed of 0 for none, and would draw from NumPy's hidden state
    told: Any = analysis.analyze(problem, y, design.second_order, seed=seed + 1)
    pairs = np.triu_indices(d, 1)
    second = Estimate(*(told[key][pairs][np.newaxis] for key in ("S2", "S2_conf"))) if design.second_order else None
    first, total = (Estimate(told[key][np.newaxis], told[f"{key}_conf"][np.newaxis]) for key in ("S1", "ST"))
    return SalibIndices(first, total, second)
