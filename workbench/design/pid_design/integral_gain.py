"""The largest integral gain of a process with a given derivative action, and the least peak that any gains reach."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.pid_design.derivative_action import DerivativeAction
from workbench.design.pid_design.gain_plane import GainPlane
from workbench.design.pid_design.gain_search import nodes, search
from workbench.design.pid_design.optimum_contacts import Contact, ContactEquations, contacts_of, polish
from workbench.design.pid_design.process import Process

ATTEMPTS = 7
GAP = 0.03  # a bound that lies farther above the optimum than this asks for more frequencies
FARTHEST = 64.0  # times the frequencies that are looked at first
FINEST = 8.0  # times as many frequencies
LARGEST_PEAK = 64.0  # a peak beyond this counts as no margin
PEAK_ACCURACY = 1e-4
NO_ACTION = DerivativeAction()


@dataclass(frozen=True)
class GainOptimum:
    """The gains k and ki, a bound that no ki exceeds, and the contacts with the limits."""

    k: float
    ki: float
    bound: float
    contacts: tuple[Contact, ...]


@dataclass(frozen=True, eq=False)
class IntegralGain:
    """The problem of the largest ki > 0 for a process, a derivative action and limits of the peaks of S and T."""

    process: Process
    Ms: float
    Mt: float
    derivative: DerivativeAction = NO_ACTION

    def solve(self, least: float = 0.0) -> GainOptimum | None:
        """The largest ki; None if no gains meet the specification, or none with a ki above `least`."""
        fineness, reach = 1.0, 1.0
        best: GainOptimum | None = None
        for attempt in range(ATTEMPTS):
            plane = self.plane(fineness, reach)
            best, bound = self._best_on(plane, least)
            if best is None and bound <= 0:
                if attempt >= 2 or least:
                    break
                fineness, reach = 2 * fineness, 3 * reach
            elif best is not None and (farther := self._farthest(plane, best)) > 1 and reach < FARTHEST:
                reach = min(FARTHEST, 1.2 * farther * reach)
            elif fineness < FINEST and (best is None or best.ki < (1 - GAP) * bound):
                fineness *= 2
            else:
                break
        return best

    def feasible(self) -> bool:
        """True if some gains meet the specification at the frequencies of the search."""
        plane = self.plane(2.0)
        every = nodes(plane)
        return any(search(plane, _clipped(every, *interval)) for interval in self.gain_intervals())

    def stabilisable(self) -> bool:
        """True if some gains stabilise."""
        plane = replace(self, Ms=LARGEST_PEAK, Mt=math.inf).plane()
        return any(plane.stable_intervals(nodes(plane)))

    def plane(self, fineness: float = 1.0, reach: float = 1.0) -> GainPlane:
        """The forbidden sets at frequencies that suit the process."""
        omega = self.process.frequencies(fineness, reach, self.derivative.corner)
        inverse, action = self.process.inverse(omega), self.derivative.response(omega)
        return GainPlane(self.process, omega, inverse, action, self.Ms, self.Mt)

    def gain_intervals(self) -> list[tuple[float, float]]:
        """The intervals of k that the limits leave at infinite frequency, where a process with a direct path has L."""
        D = self.process.gain_limit
        if D == 0:
            return [(-math.inf, math.inf)]
        low = max(1 / self.Ms - 1, -self.Mt / (1 + self.Mt) if math.isfinite(self.Mt) else -1.0)
        if self.process.delay:
            sides = [(low, -low)]
        else:
            other = -1 - 1 / self.Ms
            if math.isfinite(self.Mt):
                other = min(other, -self.Mt / (self.Mt - 1) if self.Mt > 1 else -math.inf)
            sides = [(low, math.inf), *([(-math.inf, other)] if other > -math.inf else [])]
        ends = [sorted((a / D - self.derivative.limit, b / D - self.derivative.limit)) for a, b in sides]
        return [(a, b) for a, b in ends]

    def reach_of(self, gains: GainOptimum) -> float:
        """The last frequency that some gains ask for, over the last one that is looked at first."""
        return min(FARTHEST, max(1.0, 1.2 * self._farthest(self.plane(), gains)))

    def _best_on(self, plane: GainPlane, least: float) -> tuple[GainOptimum | None, float]:
        """The optimum on the frequencies of a plane, and the bound from above."""
        equations = ContactEquations(plane, self.derivative)
        best: GainOptimum | None = None
        top, every = 0.0, nodes(plane)
        for interval in self.gain_intervals():
            k = _clipped(every, *interval)
            places = search(plane, k, least)
            top = max([top, *(bound for _, bound, _ in places)])
            for at, bound, _ in places:
                if best is not None and bound <= best.ki:
                    continue
                gains = polish(equations, at, bound, interval)
                if gains is not None and (best is None or gains[1] > best.ki):
                    best = GainOptimum(*gains, bound, contacts_of(equations, *gains))
        return (best if best is None else replace(best, bound=max(top, best.ki))), top

    def _farthest(self, plane: GainPlane, gains: GainOptimum) -> float:
        """The last frequency at which the loop gain is large enough to reach a limit, over that of the plane."""
        limits = [1 - 1 / self.Ms, self.Mt / (1 + self.Mt) if math.isfinite(self.Mt) else 1.0]
        last = float(plane.omega[-1])
        omega = self.process.later_frequencies(last, self.derivative.corner)
        if not omega.size or self.process.gain_limit:
            return 1.0
        law = abs(gains.k) + gains.ki / omega + np.abs(self.derivative.response(omega))
        above = np.nonzero(law > min(limits) * np.abs(self.process.inverse(omega)))[0]
        return float(omega[above[-1]]) / last if above.size else 1.0


def _clipped(k: Array, low: float, high: float) -> Array:
    """The values of k inside an interval, and its ends where they are finite."""
    ends = [end for end in (low, high) if math.isfinite(end)]
    return np.unique(np.concatenate([k[(k > low) & (k < high)], ends]))


def least_peak(
    process: Process, of_S: bool, other: float = math.inf, derivative: DerivativeAction = NO_ACTION
) -> float:
    """The least Ms, or Mt, of any gains, with the other peak below a limit; infinite if it is above 64."""

    def feasible(peak: float) -> bool:
        limits = (peak, other) if of_S else (other, peak)
        return IntegralGain(process, *limits, derivative).feasible()

    if not IntegralGain(process, math.inf, math.inf, derivative).stabilisable():
        return math.inf
    high = 2.0
    while not feasible(high):
        high *= 2
        if high > LARGEST_PEAK:
            return math.inf
    low = high / 2 if high > 2 else 1.0
    while high - low > PEAK_ACCURACY * high:
        middle = (low + high) / 2
        low, high = (low, middle) if feasible(middle) else (middle, high)
    return high
