"""The peaks of a loop with a delay, by branch and bound: an interval that cannot hold the peak is dropped, no other.

On an interval within a piece the values at its ends bound log |L|, the phase and their slopes, and so a function f of
L from below: by the sector in which L lies, and by its slope, f >= (f(start) + f(end) - max |f'| width) / 2, whose gap
falls with the square of the width. Where f' has no zero, f is least at an end.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from workbench.design.frequency import sector_bounds
from workbench.design.frequency.certified_values import square_root
from workbench.design.frequency.delay_pieces import FrequencyInterval, LateLoop, LoopGainPoint
from workbench.design.frequency.sector_bounds import Sector, SectorBound
from workbench.design.matrices import DesignError

NARROW = 1e-11  # relative gap at which the search ends
ROUNDING = 1e-15  # relative, of |L| and of its phase
MOST = 20_000  # intervals
TERMS = 40  # of a power series, beyond the degree of its polynomials
TURN, STEP = 2 * math.pi, 6.0  # rad: of a phase, and of the delay beyond the last cut


@dataclass(frozen=True)
class Valley:
    """The infimum of a function of L on the axis, its bounds, and a frequency in rad/s at which it is reached."""

    value: float
    low: float
    high: float
    frequency: float


@dataclass(frozen=True)
class Stretch:
    """Two neighbouring points of a piece; the last one is at infinity where there is no piece."""

    piece: FrequencyInterval | None
    start: LoopGainPoint
    end: LoopGainPoint


def least_distance(late: LateLoop) -> Valley:
    """The infimum of |1 + L|^2, 1 / Ms^2."""
    return _Search(late, sector_bounds.distance, sector_bounds.distance_bound).run(0.0, {})


def least_inverse_distance(late: LateLoop) -> Valley:
    """The infimum of |1 + 1 / L|^2, 1 / Mt^2; beside a pole of L at 0 a power series stands for the bounds."""
    search = _Search(late, sector_bounds.inverse_distance, sector_bounds.inverse_distance_bound)
    integrates = late.loop.B[0] == 0
    return search.run(_safe_start(late) if integrates else 0.0, {0.0: 1.0} if integrates else {})


def least_balance(late: LateLoop) -> Valley:
    """The infimum of g = 1 + cos(phi) / cosh(rho), of which |S - T|^2 = (2 - g) / g is a falling function."""
    return _Search(late, sector_bounds.balance, sector_bounds.balance_bound).run(0.0, {})


@dataclass(frozen=True)
class _Search:
    late: LateLoop
    value: Callable[[float, float], float]
    bound: Callable[[Sector], SectorBound]

    def run(self, start: float, known_values: dict[float, float]) -> Valley:
        """The infimum over the axis from a frequency, and of what is known at single ones."""
        end = self._at_infinity()
        best = min([(v, omega) for omega, v in known_values.items()] + [(self._at(end), math.inf)])
        heap: list[tuple[float, int, Stretch]] = []
        fresh = self._first(start, end)
        for count in range(MOST):
            for stretch in fresh:
                best = min([best, *((self._at(p), p.omega) for p in (stretch.start, stretch.end))])
                below = self._below(stretch)
                if below < best[0]:
                    heapq.heappush(heap, (below, len(heap) + MOST * count, stretch))
            doubt = self._doubt(best)
            if not heap or heap[0][0] >= best[0] * (1 - NARROW) - doubt:
                low = min(best[0], heap[0][0] if heap else math.inf)
                return Valley(best[0], max(low - doubt, 0.0), best[0] + doubt, best[1])
            fresh = self._halves(heapq.heappop(heap)[2])
        raise DesignError(
            f"The peak of a loop with a delay must be told from its neighbours within {MOST} intervals; this loop has "
            "too many that are nearly equal. Shorten the delay, or add the lag that the hardware has."
        )

    def _first(self, start: float, end: LoopGainPoint) -> list[Stretch]:
        last = max([*self.late.cuts, 2 * start, 1 / float(self.late.loop.delay)])
        pieces = [piece for piece in self.late.pieces(last) if piece.end > start]
        points = [(piece, piece.at(max(piece.start, start)), piece.at(piece.end)) for piece in pieces]
        tail = self.late.piece(last, 2 * last).at(last)
        return [*(Stretch(*row) for row in points), Stretch(None, tail, end)]

    def _halves(self, stretch: Stretch) -> list[Stretch]:
        start, end = stretch.start.omega, stretch.end.omega
        if stretch.piece is None:
            piece = self.late.piece(start, start + max(start, STEP / float(self.late.loop.delay)))
            middle = piece.at(piece.end)
            return [Stretch(piece, stretch.start, middle), Stretch(None, middle, stretch.end)]
        middle = stretch.piece.at(math.sqrt(start * end) if 0 < 4 * start < end else start + (end - start) / 2)
        return [Stretch(stretch.piece, stretch.start, middle), Stretch(stretch.piece, middle, stretch.end)]

    def _at(self, point: LoopGainPoint) -> float:
        return self.value(point.rho, point.phi)

    def _at_infinity(self) -> LoopGainPoint:
        """The point with the gain at infinity, and the phase of -1, as every phase recurs there."""
        A, B = self.late.loop.A, self.late.loop.B
        rho = math.log(square_root(Fraction(A[-1], B[-1]))) if len(A) == len(B) else -math.inf
        return LoopGainPoint(math.inf, rho, math.pi, -math.inf, -math.inf)

    def _below(self, stretch: Stretch) -> float:
        """A lower bound of the function on a stretch."""
        p, q = stretch.start, stretch.end
        rho = min(p.rho, q.rho), max(p.rho, q.rho)
        if stretch.piece is None:
            return self.bound(Sector(rho, (0.0, TURN), (-math.inf, math.inf), (-math.inf, math.inf))).below
        phi = min(p.phi, q.phi), max(p.phi, q.phi)
        slopes = [(min(a, b), max(a, b)) for a, b in ((p.rho_slope, q.rho_slope), (p.phi_slope, q.phi_slope))]
        bound, width = self.bound(Sector(rho, phi, *slopes)), q.omega - p.omega
        ends = self._at(p), self._at(q)
        if bound.steepest == 0:
            return min(ends)
        return max(bound.below, (sum(ends) - bound.steepest * width) / 2)

    def _doubt(self, best: tuple[float, float]) -> float:
        """The rounding of the best value: that of |L| and of its phase, on the distance from -1."""
        value, omega = best
        lag = omega * float(self.late.loop.delay) if math.isfinite(omega) else 0.0
        return 4 * ROUNDING * (math.pi + lag) * (math.sqrt(value) + value)


def _safe_start(late: LateLoop) -> float:
    """A frequency up to which |1 + 1 / L| >= 1 beside a pole of L at 0, by its power series; 0 if there is none.

    |D + N e|^2 - |N|^2 = B + 2 (P cos(omega delay) + omega Q sin(omega delay)), with e the delay, in powers of x.
    """
    B, P, Q, delay = late.loop.B, late.loop.P, late.loop.Q, late.loop.delay
    size = max(map(len, (B, P, Q))) + TERMS
    over, under = delay.numerator, delay.denominator
    whole = math.factorial(2 * TERMS) * under ** (2 * TERMS)  # times this, every coefficient is a whole number
    series = [b * whole for b in B] + [0] * (size - len(B))
    for k in range(TERMS):
        even, odd = (2 * (-1) ** k * (whole // (math.factorial(n) * under**n)) * over**n for n in (2 * k, 2 * k + 1))
        for i, p in enumerate(P):
            series[i + k] += even * p
        for i, q in enumerate(Q):
            series[i + k + 1] += odd * q
    first = next(i for i, c in enumerate(series) if c)
    if series[first] < 0:
        return 0.0
    x = Fraction(1) / (1 + delay**2)
    rest = [abs(c) for c in series[first + 1 :]]
    while 2 * _scaled_sum(rest, x) > series[first] * x.denominator ** len(rest):
        x /= 4
    return square_root(x)


def _scaled_sum(coefficients: list[int], x: Fraction) -> int:
    """The sum of c1 x + c2 x^2 + ..., times the denominator of x to the power of their number."""
    total, power = 0, 1
    for c in reversed(coefficients):
        total, power = (total + c * power) * x.numerator, power * x.denominator
    return total
