"""The amplitude and the frequency of an oscillation that was simulated, beside which a prediction stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.design.certificates import Refused
from workbench.validation.refusals import Array
from workbench.validation.signatures import door
from workbench.validation.views import show

FEWEST = 5  # periods from which a frequency is taken


@dataclass(frozen=True)
@show
class Measured:
    """What a record of s shows.

    Attributes
    ----------
    amplitude, offset
        Half of the highest minus the lowest s, and their mean.
    frequency
        In rad/s, of the upward passages through the offset; None where there are not five periods.
    scatter
        The standard deviation of the periods over their mean: how far it is one oscillation; None likewise.
    """

    amplitude: float
    offset: float
    frequency: float | None
    scatter: float | None


@door
def measured(t: Array, s: Array) -> Measured:
    """The oscillation in the record s (N,) at times t (N,) in s, from which its start is left out already.

    Raises
    ------
    Refused
        If a number is not finite: a run that was lost has no amplitude.
    ValueError
        If t and s are not two vectors of one length, or t does not rise.
    """
    if t.ndim != 1 or t.shape != s.shape or len(t) < 2 or not (np.isfinite(t).all() and (np.diff(t) > 0).all()):
        raise ValueError(
            f"`measured(t, s)` must be two vectors of one length, t rising and finite; got shapes {t.shape} and "
            f"{s.shape}."
        )
    if not np.isfinite(s).all():
        raise Refused("`measured(t, s)` must be finite, and this record is not; the run was lost.")
    low, high = float(s.min()), float(s.max())
    offset = (low + high) / 2
    d = s - offset
    i = np.flatnonzero((d[:-1] < 0) & (d[1:] >= 0))
    passages = t[i] - d[i] * (t[i + 1] - t[i]) / (d[i + 1] - d[i])
    if len(passages) <= FEWEST:
        return Measured((high - low) / 2, offset, None, None)
    periods = np.diff(passages)
    mean = float(periods.mean())
    return Measured((high - low) / 2, offset, 2 * np.pi / mean, float(periods.std() / mean))
