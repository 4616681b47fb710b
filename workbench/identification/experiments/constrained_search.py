"""The search for coefficients within limits at all instants, by SQP on those instants that are near to a limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize

from workbench.core.validation.refusals import Array, Integers
from workbench.identification.datasets.experiment import Marks
from workbench.identification.experiments.driven_response import DrivenResponse
from workbench.identification.experiments.information_criterion import InformationCriterion

NEAR = 0.15  # margin, as a share of the range, below which a least margin takes part in a round
MOST_PLACES = 160  # near to a limit that take part in a round
SPREAD = 32  # instants at which every limit takes part in every round
BEYOND = 1e9  # the goal of an experiment that tells nothing or diverges: larger than any other
TOLERANCE = 1e-6  # of margins, as a share of the range
REACH = 0.5  # of a coefficient in a round, in units of the largest at the start
LARGE = 0.1  # violation, as a share of a range, from which a round does not go on
CLOSE = 0.9999  # share of the room that an input uses at least that is drawn back
SCALES = 20  # sizes of an input that are tried
SETTLED = 1e-4  # change of the coefficients by a round that ends a search, in the same units


@dataclass(frozen=True, eq=False)
class ConstrainedSearch:
    """min goal(c) with margins(c) >= `reserve` at each instant of the steps of a response.

    An exchange method for limits at infinitely many instants (Hettich and Kortanek 1993, section 7.1): SLSQP (Kraft
    1988) takes the least margins only, and a round adds those that it broke.
    """

    response: DrivenResponse
    criterion: InformationCriterion
    rest: Array  # (nu, nb), coefficients that keep all limits
    reserve: Array  # (all limits, 2), margins that must be left, as shares of each range
    is_free: Marks  # (nb,), false for coefficients that stay
    rounds: int
    iterations: int = 20  # of SLSQP in a round

    def improve(self, c: Array, unit: Array) -> tuple[Array, float]:
        """Better coefficients (nu, nb) from a start within the limits, in steps of `unit` (nu, 1), and the goal there.

        The end of a round that broke a limit is drawn back towards the rest until all limits hold.
        """
        everywhere, places = self._spread(c), np.zeros((0, 3), dtype=int)
        best, lowest = c, self.goal(c)[0]
        for _ in range(self.rounds):
            near = self._near(c)
            places = np.unique(np.vstack([places[: MOST_PLACES - len(near)], near]), axis=0)
            before, c = c, self._round(c, unit, np.unique(np.vstack([places, everywhere]), axis=0))
            inside = c
            if self.violation(c) > TOLERANCE:
                drawn = largest_within(self.response, self.reserve, self.rest, c, CLOSE)
                inside = best if drawn is None else drawn
                c = c if self.violation(c) < LARGE else inside  # a linear limit is worth little so far away
            goal = self.goal(inside)[0]
            if goal < lowest:
                best, lowest = inside, goal
            if float(np.max(np.abs(c - before) / unit)) < SETTLED:
                break
        return best, lowest

    def goal(self, c: Array) -> tuple[float, Array]:
        """The goal and its gradient (nu, nb)."""
        return self.response.pull_back(c, self.criterion.goal)

    def violation(self, c: Array) -> float:
        """The largest lack of margin at any instant, or 0."""
        return float(max(0.0, np.max(self.reserve - self.response.margins(c), initial=-np.inf)))

    def _near(self, c: Array) -> Integers:
        """The places (M, 3) of the local minima of the margins that are near to a limit."""
        left = self.response.margins(c) - self.reserve
        padded = np.pad(left, ((1, 1), (0, 0), (0, 0)), constant_values=np.inf)
        least = (left <= padded[:-2]) & (left <= padded[2:])
        plateau = (left == padded[:-2]) & (left == padded[2:])  # as an input has that is held
        places = np.argwhere(least & ~plateau & (left < NEAR))
        order = np.argsort(left[tuple(places.T)], kind="stable")
        return places[order[: MOST_PLACES // 2]]

    def _spread(self, c: Array) -> Integers:
        """The places (M, 3) of all limits at even steps."""
        margins = self.response.margins(c)
        rows = np.linspace(0, len(margins) // 2 - 1, SPREAD).astype(int)
        is_some = np.zeros(margins.shape, dtype=bool)
        is_some[rows] = np.isfinite(margins[rows])
        return np.argwhere(is_some)

    def _round(self, c: Array, unit: Array, places: Integers) -> Array:
        """The end of some steps of SLSQP with the margins at some places."""
        reserve, free, size = self.reserve[tuple(places[:, 1:].T)], self.is_free, (len(c), int(self.is_free.sum()))

        def full(q: Array) -> Array:
            every = c.copy()
            every[:, free] = q.reshape(size) * unit
            return every

        def goal(q: Array) -> tuple[float, Array]:
            value, slopes = self.goal(full(q))
            return (value, (slopes * unit)[:, free].ravel()) if np.isfinite(value) else (BEYOND, np.zeros(q.size))

        def left(q: Array) -> Array:
            margins = self.response.margins(full(q))
            return margins[tuple(places.T)] - reserve if len(margins) > 1 else np.full(len(places), -1e3)

        def slopes(q: Array) -> Array:
            every = self.response.margin_slopes(full(q), places).reshape(-1, *c.shape)
            return np.asarray((every * unit)[:, :, free].reshape(len(places), -1))

        start = (c[:, free] / unit).ravel()
        # SciPy's stub has no objective that returns its slopes, too
        end = optimize.minimize(  # type: ignore[call-overload]
            goal,
            start,
            jac=True,
            method="SLSQP",
            constraints=[{"type": "ineq", "fun": left, "jac": slopes}],
            bounds=optimize.Bounds(start - REACH, start + REACH),
            options={"maxiter": self.iterations, "ftol": 1e-9},
        )
        moved = full(np.asarray(end.x))
        return moved if np.isfinite(moved).all() else c


def largest_within(
    response: DrivenResponse, reserve: Array, rest: Array, c: Array, close: float = 0.99
) -> Array | None:
    """The input rest + s (c - rest) within all limits; None if there is no such s.

    s is the largest one for which a limit has the share `close` of its room used.
    """
    at_rest = np.maximum(np.min(response.margins(rest), axis=0) - reserve, np.finfo(float).tiny)
    is_limit = np.isfinite(at_rest)
    low, high, scale, best = 0.0, np.inf, 1.0, None
    for _ in range(SCALES):
        trial = rest + scale * (c - rest)
        left = np.min(response.margins(trial), axis=0) - reserve
        used = (at_rest[is_limit] - left[is_limit]) / at_rest[is_limit]  # shares of the room
        most = float(np.max(used, initial=0.0))
        if most <= 1.0:
            low, best = scale, trial
        else:
            high = scale
        if low > close * high or close < most <= 1.0:
            return best
        guess = scale * (1 + close) / 2 / most if 0 < most < np.inf else np.inf
        between = float(np.sqrt(low * high)) if low and np.isfinite(high) else (2 * scale if low else scale / 4)
        scale = guess if low < guess < high and np.isfinite(guess) else between
    return best
