"""The search for coefficients within limits at all instants, by SQP on those instants that are near to a limit."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy import optimize

from workbench.core.validation.refusals import Array
from workbench.identification.experiments.driven_response import DrivenResponse
from workbench.identification.experiments.information_criterion import InformationCriterion

NEAR = 0.15  # margin, as a share of the range, below which a least margin takes part in a round
MOST_PLACES = 300  # that take part in a round
BEYOND = 1e9  # the goal of an experiment that tells nothing or diverges: larger than any other
TOLERANCE = 1e-6  # of margins, as a share of the range
SETTLED = 1e-5  # change of the goal by a round that ends a search


@dataclass(eq=False)
class ConstrainedSearch:
    """min goal(c) with margins(c) >= `kept` at each instant of the steps of a response.

    An exchange method for limits at infinitely many instants (Hettich and Kortanek 1993, section 7.1): SLSQP (Kraft
    1988) takes the least margins only, and a round adds those that it broke.
    """

    response: DrivenResponse
    criterion: InformationCriterion
    kept: Array  # (all limits, 2), margins that must be left, as shares of each range
    rounds: int
    iterations: int = 12  # of SLSQP in a round
    evaluations: int = field(default=0, init=False)

    def improve(self, c: Array, unit: Array) -> tuple[Array, float]:
        """Better coefficients (nu, nb) from a start, in steps of `unit` (nu, 1), and the goal there."""
        places = np.zeros((0, 3), dtype=int)
        goal = self.goal(c)[0]
        best, lowest = c, goal if self.violation(c) <= TOLERANCE else np.inf
        for _ in range(self.rounds):
            places = np.unique(np.vstack([places, self._near(c)]), axis=0)[:MOST_PLACES]
            c = self._round(c, unit, places)
            before, goal = goal, self.goal(c)[0]
            violation = self.violation(c)
            if violation <= TOLERANCE and goal < lowest:
                best, lowest = c, goal
            if violation <= TOLERANCE and abs(before - goal) < SETTLED:
                break
            if not np.isfinite(self.response.margins(c)).any():
                break
        return best, lowest

    def goal(self, c: Array) -> tuple[float, Array]:
        """The goal and its gradient (nu, nb)."""
        self.evaluations += 1
        return self.response.pull_back(c, self.criterion.goal)

    def violation(self, c: Array) -> float:
        """The largest lack of margin at any instant, or 0."""
        return float(max(0.0, np.max(self.kept - self.response.margins(c), initial=-np.inf)))

    def _near(self, c: Array) -> Array:
        """The places (M, 3) of the local minima of the margins that are near to a limit."""
        left = self.response.margins(c) - self.kept
        padded = np.pad(left, ((1, 1), (0, 0), (0, 0)), constant_values=np.inf)
        least = (left <= padded[:-2]) & (left <= padded[2:])
        plateau = (left == padded[:-2]) & (left == padded[2:])  # as an input has that is held
        places = np.argwhere(least & ~plateau & (left < NEAR))
        order = np.argsort(left[tuple(places.T)], kind="stable")
        return places[order[: MOST_PLACES // 2]]

    def _round(self, c: Array, unit: Array, places: Array) -> Array:
        """The end of some steps of SLSQP with the margins at some places."""
        shape, kept = c.shape, self.kept[tuple(places[:, 1:].T)]

        def goal(q: Array) -> tuple[float, Array]:
            value, slopes = self.goal(q.reshape(shape) * unit)
            return (value, (slopes * unit).ravel()) if np.isfinite(value) else (BEYOND, np.zeros(q.size))

        def left(q: Array) -> Array:
            margins = self.response.margins(q.reshape(shape) * unit)
            return margins[tuple(places.T)] - kept if len(margins) > 1 else np.full(len(places), -1e3)

        def slopes(q: Array) -> Array:
            every = self.response.margin_slopes(q.reshape(shape) * unit, places)
            return np.asarray((every.reshape(-1, *shape) * unit).reshape(len(places), -1))

        limits = [{"type": "ineq", "fun": left, "jac": slopes}] if len(places) else []
        end = optimize.minimize(
            goal,
            (c / unit).ravel(),
            jac=True,
            method="SLSQP",
            constraints=limits,
            options={"maxiter": self.iterations, "ftol": 1e-9},
        )
        moved = np.asarray(end.x).reshape(shape) * unit
        return moved if np.isfinite(moved).all() else c


def largest_within(response: DrivenResponse, kept: Array, rest: Array, c: Array) -> Array | None:
    """The input rest + s (c - rest) within all limits, with s as large as a few secant steps find; None if there is none."""
    scale, best = 1.0, None
    at_rest = np.maximum(np.min(response.margins(rest), axis=0) - kept, 1e-12)
    low, high = 0.0, np.inf
    for _ in range(14):
        trial = rest + scale * (c - rest)
        left = np.min(response.margins(trial), axis=0) - kept
        if (left >= 0).all():
            low, best = scale, trial
        else:
            high = scale
        used = float(np.max(np.where(np.isfinite(left), (at_rest - left) / at_rest, 0.0 if best is not None else 2.0)))
        guess = scale * 0.999 / used if used > 0 and np.isfinite(used) else scale * 2
        scale = guess if low < guess < high else (np.sqrt(low * high) if low and np.isfinite(high) else scale / 3)
        if np.isfinite(high) and low > 0.99 * high:
            break
    return best
