"""Indices and effects as a table for a notebook or a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from workbench.study.uncertainty.outputs import Estimate

if TYPE_CHECKING:
    import pandas as pd


def frame(
    names: Sequence[str], parts: Mapping[str, tuple[Sequence[str], Estimate]], refused: Mapping[str, str]
) -> pd.DataFrame:
    """One row an output, index and factor: its value, half of its interval, and why there is none.

    Parameters
    ----------
    parts
        By the name of the index: the names of the d factors, or of pairs of them, and estimates (k, d) or (d,).
    """
    import pandas as pd

    rows = [
        {"output": name, "index": index, "factor": factor, "value": value, "half": half, "refused": refused.get(name)}
        for index, (factors, estimate) in parts.items()
        for name, values, halves in zip(names, np.atleast_2d(estimate.value), np.atleast_2d(estimate.half), strict=True)
        for factor, value, half in zip(factors, values, halves, strict=True)
    ]
    return pd.DataFrame(rows, columns=["output", "index", "factor", "value", "half", "refused"])
