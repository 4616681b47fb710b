"""The axis cut where the gain or the phase of a loop with a delay turns, so that both are monotonic in between.

With L = exp(rho + j phi), rho' = omega a(x) and phi' = b(x) - delay, where a and b are rational functions of
x = omega^2. The axis is cut at the real roots of the polynomials that decide their signs and their slopes, and the
sign of Re L and Im L without the delay; so values at two ends bound rho, phi and their slopes between them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import pairwise

from workbench.design.frequency.axis_loop import AxisLoop
from workbench.design.frequency.certified_values import angle, root_of_quotient
from workbench.design.frequency.integer_polynomials import add, derivative, multiply, scale
from workbench.design.frequency.polynomial_ratios import Ratio, lowest_terms, slope_numerator
from workbench.design.frequency.positive_roots import positive_roots, ratio

INSIDE = 1e-15  # relative: how far from a pole or zero on the axis the one-sided phase is taken


@dataclass(frozen=True)
class LoopGainPoint:
    """rho, phi and their slopes at a frequency omega in rad/s; rho and its slope are infinite at poles and zeros."""

    omega: float
    rho: float
    phi: float
    rho_slope: float
    phi_slope: float


@dataclass(frozen=True)
class FrequencyInterval:
    """An open interval of frequencies in rad/s on which rho, phi and their slopes are monotonic; `at` gives a point."""

    start: float
    end: float
    at: Callable[[float], LoopGainPoint]
    phase: Callable[[float], float]  # the phi of `at` alone, inside of the interval


@dataclass(frozen=True, eq=False)
class LateLoop:
    """A loop with a delay: its slopes rho' / omega and phi' + delay as ratios, and the places where it is cut."""

    loop: AxisLoop
    a: Ratio
    b: Ratio
    cuts: tuple[float, ...]
    singular: frozenset[float]

    def pieces(self, end: float) -> list[FrequencyInterval]:
        """The pieces from 0 to a frequency in rad/s."""
        ends = [0.0, *(cut for cut in self.cuts if cut < end), end]
        return [self.piece(start, stop) for start, stop in pairwise(ends)]

    def piece(self, start: float, end: float) -> FrequencyInterval:
        """The piece between two frequencies without a cut between them."""
        middle = math.sqrt(start * end) if start else end / 2
        centre = self._values.angle(middle)

        def point(omega: float) -> LoopGainPoint:
            return self._point(omega, start, end, centre)

        def phase(omega: float) -> float:
            if omega in (start, end):
                return point(omega).phi
            turn = centre + math.remainder(self._values.angle(omega) - centre, 2 * math.pi)
            return turn - omega * float(self.loop.delay)

        return FrequencyInterval(start, end, point, phase)

    @cached_property
    def _values(self) -> _Values:
        return _Values(self)

    def _point(self, omega: float, start: float, end: float, centre: float) -> LoopGainPoint:
        delay = float(self.loop.delay)
        b = self._values.b(omega)
        if omega in self.singular:
            inside = omega * (1 + INSIDE if omega == start else 1 - INSIDE) if omega else end * 1e-12
            top, bottom = self._values.a(inside)
            turn, rho_slope = self._values.angle(inside), math.inf if (top > 0) == (bottom > 0) else -math.inf
            rho = rho_slope if omega == end else -rho_slope
        else:
            turn, rho = self._values.angle(omega), self._values.rho(omega)
            top, bottom = self._values.a(omega)
            rho_slope = omega * (top / bottom)
        turn = centre + math.remainder(turn - centre, 2 * math.pi)
        if omega == 0:  # L is real or imaginary there
            turn = round(turn / (math.pi / 2)) * (math.pi / 2)
        return LoopGainPoint(omega, rho, turn - omega * delay, rho_slope, b - delay)


class _Values:
    """The values of a loop without its delay at frequencies in rad/s, each computed once from exact numbers."""

    def __init__(self, late: LateLoop) -> None:
        loop = late.loop
        # a cut belongs to two pieces, and crossovers, limits of the gain and three peaks ask for it
        square = cache(lambda omega: Fraction(omega) ** 2)
        self.a = cache(lambda omega: ratio(*late.a, square(omega)))
        self.b = cache(lambda omega: _quotient(*ratio(*late.b, square(omega))))
        self.rho = cache(lambda omega: math.log(root_of_quotient(*ratio(loop.A, loop.B, square(omega)))))
        self.angle = cache(lambda omega: _angle(loop, omega, square(omega)))


def _quotient(top: int, bottom: int) -> float:
    return top / bottom


def _angle(loop: AxisLoop, omega: float, x: Fraction) -> float:
    """The phase of L without its delay at x = omega^2, in (-pi, pi]."""
    top, bottom = ratio(loop.Q, loop.P, x)
    over, under = omega.as_integer_ratio()
    return angle(top * over, bottom * under)


def late_loop(loop: AxisLoop) -> LateLoop:
    """The loop with its cuts; `loop` has a delay and no zero numerator."""
    A, B, P, Q, delay = loop.A, loop.B, loop.P, loop.Q, loop.delay
    AB = multiply(A, B)
    a = lowest_terms(slope_numerator(A, B), AB)
    Q_slope, P_slope = add(Q, [0, *scale(derivative(Q), 2)]), [0, *scale(derivative(P), 2)]
    b = lowest_terms(add(multiply(P, Q_slope), scale(multiply(Q, P_slope), -1)), AB)
    falling = add(scale(b[0], delay.denominator), scale(b[1], -delay.numerator))
    a_slope, b_slope = (slope_numerator(*pair) for pair in (a, b))
    # rho' = omega a falls and rises where a + 2 x a' = 0
    a_turn = add(multiply(*a), [0, *scale(a_slope, 2)])
    parts = [A, B, P, Q, add(A, scale(B, -1)), a[0], a[1], b[0], b[1], falling, a_turn, b_slope]
    ends = [{loop.frequency(root).value for root in positive_roots(part, bits=70)} for part in parts]
    cuts, singular = set().union(*ends), ends[0] | ends[1]
    if A[0] == 0 or B[0] == 0:
        singular.add(0.0)
    return LateLoop(loop, a, b, tuple(sorted(cuts)), frozenset(singular))
