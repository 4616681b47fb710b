"""The largest value of a rational function of x = omega^2 over the whole axis, from the roots of its derivative."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from workbench.design.frequency.integer_polynomials import Polynomial, trim
from workbench.design.frequency.polynomial_ratios import slope_numerator
from workbench.design.frequency.positive_roots import Root, bounds, positive_roots, ratio

ROUGH = 60  # bits of a place at first; those of the highest candidates are refined
NO_BOUND = Fraction(10**1000)  # no bound from above
ZERO = Root(Fraction(0), Fraction(0))


@dataclass(frozen=True)
class SquaredPeak:
    """The supremum of F / G, between two fractions, and an x at which it is reached; None where that is infinity."""

    low: Fraction
    high: Fraction
    place: Root | None


def largest_ratio(F: Polynomial, G: Polynomial) -> SquaredPeak:
    """The supremum of F / G over 0 <= x <= infinity, where G has no zero and no lower degree than F.

    It is the value at 0, at infinity or at a zero of F' G - F G', all of which are isolated. What a zero's interval
    leaves open is bounded by that of F and G over it, and at its middle the value is reached.
    """
    if not trim(F):
        return SquaredPeak(Fraction(0), Fraction(0), ZERO)
    candidates = [_value(F, G, root) for root in (ZERO, *positive_roots(slope_numerator(F, G), ROUGH))]
    if len(F) == len(G):
        limit = Fraction(F[-1], G[-1])
        candidates.append(SquaredPeak(limit, limit, None))
    reached = max(peak.low for peak in candidates)
    finalists = [
        _value(F, G, peak.place.refine()) if peak.place and peak.low < peak.high else peak
        for peak in candidates
        if peak.high >= reached
    ]
    best = max(finalists, key=lambda peak: peak.low)
    return SquaredPeak(best.low, max(peak.high for peak in finalists), best.place)


def _value(F: Polynomial, G: Polynomial, root: Root) -> SquaredPeak:
    reached = Fraction(*ratio(F, G, root.middle))
    if root.low == root.high:
        return SquaredPeak(reached, reached, root)
    (_, most), (least, _) = bounds(F, root), bounds(G, root)
    return SquaredPeak(reached, max(reached, most / least) if least > 0 else NO_BOUND, root)
