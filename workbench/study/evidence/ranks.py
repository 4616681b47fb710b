"""Ranks: how probable each law's place among all is in a draw, and that one law is below another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.study.evidence.bootstrap import Intervals
from workbench.study.evidence.paired import Paired
from workbench.study.uncertainty.outputs import Flags, t_quantile
from workbench.study.uncertainty.quantiles import share
from workbench.validation.signatures import door


@dataclass(frozen=True, eq=False)
@door
class Ranks:
    """Shares of the draws, each with the interval of Clopper and Pearson.

    Attributes
    ----------
    ranks
        (L, L), in which the law of the row has the rank of the column, from the first: the least value. Equal laws
        share the worse rank, so that all failed runs rank last.
    below
        (L, L), in which the law of the row is below the law of the column.
    """

    paired: Paired
    confidence: float
    ranks: Intervals
    below: Intervals

    def __post_init__(self) -> None:
        laws = len(self.paired.laws)
        for name in ("ranks", "below"):
            if (shape := getattr(self, name).value.shape) != (laws, laws):
                raise ValueError(f"`Ranks({name}=...)` must have shape {(laws, laws)}; got {shape}.")


@door
def ranks(paired: Paired, confidence: float = 0.95) -> Ranks:
    """The rank of each law in each draw, counted. Intervals are those of one share at a time.

    Raises
    ------
    ValueError
        If these are no paired values, or the confidence is none.
    """
    t_quantile("ranks", confidence, 1)  # refuses what is no confidence
    y = paired.values
    places = (y[:, :, None] >= y[:, None, :]).sum(axis=2)  # how many are not above, the law itself among them
    laws = len(paired.laws)
    at = places[:, :, None] == np.arange(1, laws + 1)
    below = y[:, :, None] < y[:, None, :]
    return Ranks(paired, confidence, _shares(at, confidence), _shares(below, confidence))


def _shares(holds: Flags, confidence: float) -> Intervals:
    """Of flags (N, L, L)."""
    found = [[share(column, confidence) for column in row.T] for row in np.moveaxis(holds, 1, 0)]
    value, low, high = (np.array([[getattr(s, end) for s in row] for row in found]) for end in ("value", "low", "high"))
    return Intervals(value, low, high)
