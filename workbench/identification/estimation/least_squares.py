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
NEAR = (
    1e-9  # of numbers in units of their starts: so near to a linearisation the residuals are linear to their rounding
)
UNBOUNDED = 1e150  # a bound so large is none, as SciPy squares distances to bounds


class NoSlopesError(ArithmeticError):
    """A derivative that is no number, at a trial whose residuals are numbers."""


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
    linearize: Linearized,
    start: Array,
    low: Array,
    high: Array,
    tolerance: float = TOLERANCE,
    rounds: int = MOST_ROUNDS,
) -> Minimum | None:
    """The nearest minimum from a start (nz,) by a trust region.

    None if there are no residuals at the start, or no derivatives where a step of the search arrived.
    """
    size = np.where(start == 0, 1.0, np.abs(start))
    low = np.where(low > -UNBOUNDED, low, -np.inf)
    high = np.where(high < UNBOUNDED, high, np.inf)
    inner = np.clip(start, np.nextafter(low, np.inf), np.nextafter(high, -np.inf))
    runs = LinearisedRuns(residuals, linearize, size)
    if not np.isfinite(runs.values(inner / size)).all():
        return None
    try:
        with np.errstate(all="ignore"):  # of trials far away, where a run grows beyond all numbers
            end = optimize.least_squares(
                runs.values,
                inner / size,
                runs.slopes,
                bounds=(low / size, high / size),
                x_scale="jac",
                ftol=tolerance,
                xtol=tolerance,
                gtol=tolerance,
                max_nfev=rounds,
            )
    except NoSlopesError:
        return None
    return Minimum(end.x * size, float(end.cost), int(end.nfev), REASONS[int(end.status)])


class LinearisedRuns:
    """Residuals and derivatives of numbers q in units of `size`, with the last run and linearisation kept.

    The last steps of a search are so short that a run would tell its rounding alone. There the residuals are those of
    the last linearisation. An end is tried by a run of its own afterwards, see `step_refinement`.
    """

    def __init__(self, residuals: Residuals, linearize: Linearized, size: Array) -> None:
        self.residuals, self.linearize, self.size = residuals, linearize, size
        self._run: tuple[Array, Array] | None = None  # numbers (nz,) and residuals (M,)
        self._linear: tuple[Array, Array, Array] | None = None  # and derivatives (M, nz)

    def values(self, q: Array) -> Array:
        """The residuals (M,)."""
        if self._linear is not None and _is_near(q, self._linear[0]):
            at, r, J = self._linear
            return np.asarray(r + J @ (q - at))
        if self._run is None or not np.array_equal(q, self._run[0]):
            self._run = q.copy(), self.residuals(q * self.size)
        return self._run[1]

    def slopes(self, q: Array) -> Array:
        """The derivatives (M, nz).

        Raises
        ------
        NoSlopesError
            If one of them is no number.
        """
        if self._linear is None or not _is_near(q, self._linear[0]):
            r, J = self.linearize(q * self.size)
            J = J * self.size
            if not (np.isfinite(r).all() and np.isfinite(J).all()):
                raise NoSlopesError
            self._linear = q.copy(), r, J
        return self._linear[2]


def _is_near(q: Array, other: Array) -> bool:
    return bool((np.abs(q - other) <= NEAR * np.maximum(np.abs(other), 1.0)).all())
