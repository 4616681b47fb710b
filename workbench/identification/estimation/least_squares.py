"""The search for the least squares of residuals with exact derivatives, within bounds."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import optimize

from workbench.core.validation.refusals import Array

Residuals = Callable[[Array], Array]  # (nz,) -> (M,); infinite where there is none
Linearized = Callable[[Array], tuple[Array, Array]]  # (nz,) -> (M,) and (M, nz)
TOLERANCE = 1e-13  # of changes of the numbers and of the sum, relative: near to the rounding of both
MOST_ROUNDS = 200
UNBOUNDED = 1e150  # a bound so large is none, as SciPy squares distances to bounds


class Minimum(NamedTuple):
    """The end of a search: the numbers z (nz,), half the sum of squares, and how many runs it took."""

    z: Array
    cost: float
    rounds: int
    reason: str  # why it ended, in a clause


REASONS = {
    0: "all rounds were done",
    1: "the gradient vanished",
    2: "the sum of squares changed no more",
    3: "the numbers changed no more",
    4: "neither the sum of squares nor the numbers changed any more",
}


def least_squares(
    residuals: Residuals,
    linearized: Linearized,
    start: Array,
    low: Array,
    high: Array,
    tolerance: float = TOLERANCE,
    rounds: int = MOST_ROUNDS,
) -> Minimum | None:
    """The nearest minimum from a start (nz,) by a trust region; None if there are no residuals at the start."""
    size = np.where(start == 0, 1.0, np.abs(start))
    low = np.where(low > -UNBOUNDED, low, -np.inf)
    high = np.where(high < UNBOUNDED, high, np.inf)
    inner = np.clip(start, np.nextafter(low, np.inf), np.nextafter(high, -np.inf))

    def values(q: Array) -> Array:
        return residuals(q * size)

    def slopes(q: Array) -> Array:
        return linearized(q * size)[1] * size

    if not np.isfinite(values(inner / size)).all():
        return None
    found = optimize.least_squares(
        values,
        inner / size,
        slopes,
        bounds=(low / size, high / size),
        x_scale="jac",
        ftol=tolerance,
        xtol=tolerance,
        gtol=tolerance,
        max_nfev=rounds,
    )
    return Minimum(found.x * size, float(found.cost), int(found.nfev), REASONS[int(found.status)])
