"""A second opinion on Sobol indices: SALib's own estimates and intervals from the same runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from workbench.core.layout import Array
from workbench.study.sampling import SobolDesign
from workbench.study.sampling.contract import seeded, whole
from workbench.study.sensitivity.indices import SobolIndices, sobol
from workbench.study.sensitivity.outputs import Estimate


def sobol_by_salib(
    design: SobolDesign,
    outputs: Any,
    names: Sequence[str] | None = None,
    *,
    factors: Sequence[str] | None = None,
    confidence: float = 0.95,
    resamples: int = 100,
    seed: int = 0,
) -> SobolIndices:
    """The indices that SALib finds in the same runs, with its bootstrap intervals; refused is what `sobol` refuses.

    SALib takes one output at a time, resamples the rows of a Sobol net as if they were independent draws, and answers
    failed runs with numbers: so it serves to be compared with, after our own look at the outputs.

    Parameters
    ----------
    outputs
        (N,) or (N, k) in the order of the design's points, which is SALib's.
    resamples, seed
        Of the bootstrap.

    Raises
    ------
    ValueError
        As `sobol` does, and if there are less than two resamples.

    References
    ----------
    Herman and Usher (2017), SALib, Journal of Open Source Software 2(9).
    """
    from SALib.analyze import sobol as analysis  # costs a second, and only those who ask for it

    whole("sobol_by_salib(resamples=...)", resamples, 2, "resamples")
    # SALib takes a seed of 0 for none, and would draw from NumPy's hidden state
    seed = seeded("sobol_by_salib(seed=...)", seed) + 1
    ours = sobol(design, outputs, names, factors=factors, confidence=confidence)
    d, columns = design.dimensions, np.reshape(np.asarray(outputs, dtype=float), (design.size, -1))
    shape = len(ours.names), d
    found = {key: np.full(shape, np.nan) for key in ("S1", "S1_conf", "ST", "ST_conf")}
    pairs: dict[str, Array] = {key: np.full((shape[0], d * (d - 1) // 2), np.nan) for key in ("S2", "S2_conf")}
    problem = {"num_vars": d, "names": list(ours.factors), "bounds": [[0.0, 1.0]] * d}
    for j in np.flatnonzero([name not in ours.refused for name in ours.names]):
        said = analysis.analyze(problem, columns[:, j], design.second_order, resamples, confidence, seed=seed)
        for key, rows in found.items():
            rows[j] = said[key]
        for key, rows in pairs.items() if design.second_order else ():
            rows[j] = said[key][np.triu_indices(d, 1)]
    return replace(
        ours,
        S1=Estimate(found["S1"], found["S1_conf"]),
        ST=Estimate(found["ST"], found["ST_conf"]),
        S2=Estimate(pairs["S2"], pairs["S2_conf"]) if design.second_order else None,
        remarks=(),
    )
