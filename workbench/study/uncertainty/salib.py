"""A second opinion on Sobol indices: SALib's own estimates and intervals from the same runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from workbench.study.uncertainty.indices import SobolIndices, sobol
from workbench.study.uncertainty.outputs import Estimate, columns_of
from workbench.study.uncertainty.sobol_design import SobolDesign
from workbench.validation.refusals import Array, whole
from workbench.validation.refusals import seed as as_seed
from workbench.validation.signatures import door


@door
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
    """The indices that SALib finds in the same runs, with its bootstrap intervals and the refusals of `sobol`.

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
        As `sobol` does, if there are less than two resamples, or if SALib is not installed.

    References
    ----------
    Herman and Usher (2017), SALib, Journal of Open Source Software 2(9).
    """
    try:
        from SALib.analyze import sobol as analysis  # costs a second, and only those who ask for it
    except ImportError:
        raise ValueError(
            "`sobol_by_salib(...)` needs the package SALib: install it by `pip install control-workbench[data]`."
        ) from None
    whole("sobol_by_salib(resamples=...)", resamples, 2)
    # SALib takes a seed of 0 for none, and would draw from NumPy's hidden state
    seed = as_seed("sobol_by_salib(seed=...)", seed) + 1
    ours = sobol(design, outputs, names, factors=factors, confidence=confidence)
    columns = columns_of("sobol_by_salib", design, outputs, names)[1]
    columns[:, [name in ours.refused for name in ours.names]] = np.nan
    found = [_by_salib(analysis, design, column, resamples, confidence, seed) for column in columns.T]
    orders = [[np.stack(part) for part in zip(*order, strict=True)] for order in zip(*found, strict=True)]
    S1, ST, S2 = (Estimate(value, half) for value, half in orders)
    return replace(ours, S1=S1, ST=ST, S2=S2 if design.second_order else None, remarks=())


def _by_salib(
    analysis: Any, design: SobolDesign, column: Array, resamples: int, confidence: float, seed: int
) -> list[tuple[Array, Array]]:
    """S1, ST and S2 with halves of their intervals, as SALib has them; NaN for a column of NaN."""
    d = design.dimensions
    pairs = np.triu_indices(d if design.second_order else 0, 1)
    if np.isnan(column).any():
        return [(np.full(size, np.nan), np.full(size, np.nan)) for size in (d, d, len(pairs[0]))]
    problem = {"num_vars": d, "names": [f"x{i}" for i in range(d)], "bounds": [[0.0, 1.0]] * d}
    said = analysis.analyze(problem, column, design.second_order, resamples, confidence, seed=seed)
    second = [said.get(key, np.empty((0, 0)))[pairs] for key in ("S2", "S2_conf")]
    return [(said["S1"], said["S1_conf"]), (said["ST"], said["ST_conf"]), (second[0], second[1])]
