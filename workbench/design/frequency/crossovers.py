"""The crossovers of a loop without a delay, and the gain crossovers of any loop: where |L| = 1 and where L < 0."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

from workbench.design.frequency.axis_loop import AxisLoop
from workbench.design.frequency.certified_values import CertifiedValue, angle, of_fractions, square_root
from workbench.design.frequency.integer_polynomials import add, scale, trim
from workbench.design.frequency.margin_records import Crossover
from workbench.design.frequency.positive_roots import Root, at, bounds, positive_roots
from workbench.design.frequency.rational_peaks import ZERO

ROUNDING = 1e-15  # relative, of an angle that is made of few operations


@dataclass(frozen=True)
class UnitGain:
    """An x at which |L| = 1 (None: infinity), the phase of -L there without its delay, in (-pi, pi], and its bounds.

    `direction` is the sign of |D|^2 - |N|^2 beyond it, and zero where |L| only touches one.
    """

    place: Root | None
    frequency: CertifiedValue
    phase: CertifiedValue
    direction: int


def unit_gains(loop: AxisLoop) -> list[UnitGain]:
    """All places where |L| = 1, those at zero and infinity included; where |L| is one everywhere, these alone."""
    W = trim(add(loop.B, scale(loop.A, -1)))
    roots = positive_roots(W)
    places: list[Root | None] = [*([ZERO] if not W or W[0] == 0 else []), *roots]
    if len(W) < max(len(loop.A), len(loop.B)):
        places.append(None)
    signs, sign = {}, 1 if W and W[-1] > 0 else -1
    for root in reversed(roots):
        signs[root] = sign if root.multiplicity % 2 else 0
        sign = sign if root.multiplicity % 2 == 0 else -sign
    return [
        UnitGain(
            root,
            loop.top if root is None else loop.frequency(root),
            _phase(loop, root),
            0 if root is None else signs.get(root, 0),
        )
        for root in places
    ]


def _phase(loop: AxisLoop, root: Root | None) -> CertifiedValue:
    """The phase of -L in radians, L = (P + j omega Q) / B, at an x where L is neither zero nor infinite."""
    if root is None or root is ZERO:
        real = loop.P[-1] if root is None else loop.P[0]
        return CertifiedValue(math.pi, math.pi, math.pi) if real > 0 else CertifiedValue(0.0, 0.0, 0.0)
    middle = _angle_of(at(loop.P, root.middle), at(loop.Q, root.middle), root.middle)
    P, Q = bounds(loop.P, root), bounds(loop.Q, root)
    if Q[0] <= 0 <= Q[1]:  # L is real here, as no other number is as near to the axis as 2^-BITS
        middle = math.pi if P[0] > 0 else 0.0
    corners = [_angle_of(p, q, x) for p, q, x in product(P, Q, (root.low, root.high))]
    offsets = [math.remainder(corner - middle, 2 * math.pi) for corner in corners]
    doubt = ROUNDING * math.pi
    return CertifiedValue(middle, middle + min(offsets) - doubt, middle + max(offsets) + doubt)


def _angle_of(P: Fraction, Q: Fraction, x: Fraction) -> float:
    """The angle of -(P + j omega Q)."""
    across, along = -Q * Fraction(square_root(x)), -P
    return angle(across.numerator * along.denominator, along.numerator * across.denominator)


def real_crossovers(loop: AxisLoop) -> list[Crossover]:
    """All places where L without its delay is real and negative, 0 and infinity included, with the factor -1 / L."""
    crossovers = []
    if loop.P and loop.B[0] and loop.P[0] < 0:
        crossovers.append(_real_crossover(loop, ZERO))
    for root in positive_roots(loop.Q):
        if bounds(loop.P, root)[1] < 0 and bounds(loop.B, root)[0] > 0:
            crossovers.append(_real_crossover(loop, root))
    if loop.P and len(loop.P) == len(loop.B) and loop.P[-1] < 0:
        gain = Fraction(loop.B[-1], -loop.P[-1])
        crossovers.append(Crossover(loop.top, of_fractions(gain, gain)))
    return crossovers


def _real_crossover(loop: AxisLoop, root: Root) -> Crossover:
    P, B = bounds(loop.P, root), bounds(loop.B, root)
    return Crossover(loop.frequency(root), of_fractions(B[0] / -P[0], B[1] / -P[1]))


def unit_gain_crossovers(loop: AxisLoop) -> list[tuple[UnitGain, Crossover]]:
    """The gain crossovers with the phase margin in degrees, in (-180, 180]; one at infinity has none with a delay."""
    rows = []
    for gain in unit_gains(loop):
        if not (gain.place is None and loop.delay):
            rows.append((gain, Crossover(gain.frequency, _degrees(late_phase(loop, gain)))))
    return rows


def late_phase(loop: AxisLoop, gain: UnitGain) -> CertifiedValue:
    """The phase of -L with its delay, in (-pi, pi] radians."""
    phase = gain.phase
    if not loop.delay or gain.place is ZERO:
        return phase
    omega = gain.frequency
    lag = omega.value * float(loop.delay)
    doubt = (omega.high - omega.low) * float(loop.delay) + ROUNDING * (lag + math.pi)
    value = math.remainder(phase.value - lag, 2 * math.pi)
    shift = value - phase.value
    return CertifiedValue(value, phase.low + shift - doubt, phase.high + shift + doubt)


def _degrees(phase: CertifiedValue) -> CertifiedValue:
    value, low, high = (math.degrees(part) for part in (phase.value, phase.low, phase.high))
    return CertifiedValue(value if value > -180 else 180.0, low, high)
