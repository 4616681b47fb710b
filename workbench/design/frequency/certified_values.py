"""Numbers with bounds that are proved: quotients, roots and angles of rationals, rounded outward to doubles."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from workbench.validation.notebook_display import show

BITS = 128  # of a quotient before its square root is taken


@dataclass(frozen=True)
@show
class CertifiedValue:
    """A number and the bounds `low` <= number <= `high` within which the exact one lies."""

    value: float
    low: float
    high: float

    @property
    def error(self) -> float:
        """The largest distance of the exact number from `value`."""
        return 0.0 if self.low == self.high else max(self.high - self.value, self.value - self.low)


INFINITE = CertifiedValue(math.inf, math.inf, math.inf)
ZERO = CertifiedValue(0.0, 0.0, 0.0)


def enclosure(low: float, high: float, steps: int = 1) -> CertifiedValue:
    """Bounds that are each right to `steps` units in the last place, widened by them; equal ones are no exception."""
    middle = low if low == high else low + (high - low) / 2
    for _ in range(steps):
        low, high = math.nextafter(low, -math.inf), math.nextafter(high, math.inf)
    return CertifiedValue(middle, low, high)


def of_fractions(low: Fraction, high: Fraction) -> CertifiedValue:
    """The enclosure of a number between two fractions."""
    exact = low == high and Fraction(float(low)) == low
    return CertifiedValue(float(low), float(low), float(low)) if exact else enclosure(float(low), float(high))


def root_of(low: Fraction, high: Fraction) -> CertifiedValue:
    """The enclosure of the square root of a number between two fractions; a negative one counts as zero."""
    first, last = square_root(low), square_root(high)
    exact = low == high and Fraction(first) ** 2 == low
    return CertifiedValue(first, first, first) if exact else enclosure(first, last)


def square_root(x: Fraction) -> float:
    """The square root, right to the last place, of a fraction whose own size no double may have."""
    return root_of_quotient(x.numerator, x.denominator)


def root_of_quotient(top: int, bottom: int) -> float:
    """The square root of a quotient of whole numbers, right to the last place."""
    if top <= 0:
        return 0.0
    places = BITS - top.bit_length() + bottom.bit_length()
    places += places % 2
    scaled = (top << places) // bottom if places >= 0 else top // (bottom << -places)
    return math.ldexp(float(math.isqrt(scaled)), -places // 2)


def angle(across: int, along: int) -> float:
    """The angle of (along, across) in radians, right to the last place but one, for whole numbers of any size."""
    size = max(abs(across), abs(along))
    return math.atan2(across / size, along / size) if size else 0.0


def least(values: Iterable[CertifiedValue]) -> CertifiedValue:
    """The least of some numbers, infinity if there are none."""
    listed = list(values)
    if not listed:
        return INFINITE
    return CertifiedValue(*(min(getattr(v, part) for v in listed) for part in ("value", "low", "high")))


def greatest(values: Iterable[CertifiedValue]) -> CertifiedValue:
    """The greatest of some numbers, zero if there are none."""
    listed = list(values)
    if not listed:
        return ZERO
    return CertifiedValue(*(max(getattr(v, part) for v in listed) for part in ("value", "low", "high")))
