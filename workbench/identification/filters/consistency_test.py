"""The tests of a filter by chi-square: are its errors and innovations as large as its covariances say?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import gammaincinv

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array


class ChiSquareBand(NamedTuple):
    """A mean over the runs, and the ends of the band in which it lies with the stated probability."""

    mean: float
    low: float
    high: float

    @property
    def holds_mean(self) -> bool:
        """True if the mean lies in its band."""
        return self.low <= self.mean <= self.high

    def __str__(self) -> str:
        return f"{self.mean:.4g} ({'in' if self.holds_mean else 'OUTSIDE'} [{self.low:.4g}, {self.high:.4g}])"


@dataclass(frozen=True, eq=False, repr=False)
@show
class Consistency:
    """The means of NIS and NEES over M runs, with their bands of chi-square.

    A mean above its band says that the filter trusts itself too much: Q or R is too small, or the model is wrong. A
    mean below it says that Q or R is too large.

    Parameters
    ----------
    t
        (N,), the times of the samples.
    runs
        The number M of runs.
    level
        The probability of each band.
    nis
        The sum of all normalised innovations squared of a run, with as many degrees of freedom as samples.
    nees
        The normalised estimation error squared after the last sample, with n degrees of freedom; None if the true
        states are not known. Errors at different times of one run are not independent, so that only one is tested.
    nis_means, nees_means
        (N,), the means over the runs at each sample. `nis_means` is NaN where there is no sample.
    nis_inside, nees_inside
        The share of the samples at which this mean lies in the band of its instant.
    """

    t: Array
    runs: int
    level: float
    nis: ChiSquareBand
    nees: ChiSquareBand | None
    nis_means: Array
    nees_means: Array | None
    nis_inside: float
    nees_inside: float | None

    @property
    def is_consistent(self) -> bool:
        """True if the means of NIS and NEES lie in their bands."""
        return self.nis.holds_mean and (self.nees is None or self.nees.holds_mean)

    def __repr__(self) -> str:
        errors = "" if self.nees is None else f", NEES {self.nees}"
        return f"<Consistency over {self.runs} run{'s' if self.runs > 1 else ''}: NIS {self.nis}{errors}>"


def chi_square_bands(t: Array, nis: Array, counts: Array, nees: Array | None, n: int, level: float) -> Consistency:
    """The tests of NIS (M, N) with their degrees of freedom (M, N), and of NEES (M, N) with n of them."""
    M = len(nis)
    ends = np.array([(1 - level) / 2, (1 + level) / 2])

    def band(values: Array, freedom: float) -> ChiSquareBand:
        low, high = _quantiles(ends, np.array(freedom)) / M
        return ChiSquareBand(float(values.sum() / M), float(low), float(high))

    def inside(values: Array, freedom: Array) -> float:
        sums = values.sum(axis=0)
        low, high = (_quantiles(end, np.maximum(freedom, 1)) for end in ends)
        return float(((sums >= low) & (sums <= high))[freedom > 0].mean())

    squares = np.nan_to_num(nis, nan=0.0) if not np.isnan(nis[counts > 0]).any() else nis
    at_each, M_n = counts.sum(axis=0), np.full(len(t), float(M * n))
    with np.errstate(invalid="ignore"):
        nis_means = np.where(at_each > 0, squares.sum(axis=0) / M, np.nan)
    return Consistency(
        *(t, M, level),
        band(squares, float(counts.sum())),
        None if nees is None else band(nees[:, -1], float(M * n)),
        nis_means,
        None if nees is None else nees.mean(axis=0),
        inside(squares, at_each),
        None if nees is None else inside(nees, M_n),
    )


def _quantiles(level: Array, freedom: Array) -> Array:
    """The quantiles of chi-square; `scipy.stats`, which has them too, takes two seconds to be loaded."""
    return np.asarray(2 * gammaincinv(freedom / 2, level))
