"""Numbers with bounds that are proved: quotients, roots and angles of rationals, rounded outward to doubles."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from workbench.core.validation.notebook_display import show
from workbench.design.matrices import DesignError

BITS = 128  # of a quotient before its square root is taken
LARGEST_EXPONENT = 1020  # of a norm that is a double


@dataclass(frozen=True)
@show
class CertifiedValue:
    """A computed number `value`, and bounds `low` and `high` between which the exact number lies."""

    value: float
    low: float
    high: float

    @property
    def error(self) -> float:
        """The largest distance of the exact number from `value`."""
        return 0.0 if self.low == self.high else max(self.high - self.value, self.value - self.low)


@dataclass(frozen=True)
@show
class CertifiedPeak:
    """The supremum `gain` over all frequencies, and the `frequency` in rad/s at which it is reached.

    `frequency` is infinite if the supremum is the limit at high frequencies. It is NaN if the gain is infinite;
    `reason` then says why.
    """

    gain: CertifiedValue
    frequency: float
    reason: str = ""


INFINITE = CertifiedValue(math.inf, math.inf, math.inf)
ZERO = CertifiedValue(0.0, 0.0, 0.0)


def enclosure(low: float, high: float, steps: int = 1) -> CertifiedValue:
    """Bounds that are each right to `steps` units in the last place, widened by them; equal ones are no exception."""
    middle = low if low == high else low + (high - low) / 2
    for _ in range(steps):
        low, high = math.nextafter(low, -math.inf), math.nextafter(high, math.inf)
    return CertifiedValue(middle, low, high)


def widen(value: float, low: float, high: float) -> CertifiedValue:
    """A value with bounds that are each right to a unit in the last place, widened by it."""
    bounds = enclosure(low, high)
    return CertifiedValue(value, bounds.low, bounds.high)


def twice_inverse(gain: CertifiedValue) -> CertifiedValue:
    """The number 2 / gain; infinity for a gain of zero."""
    if gain.low <= 0:
        return INFINITE
    value = 2 / gain.value
    if gain.low == gain.high and Fraction(value) * Fraction(gain.value) == 2:
        return CertifiedValue(value, value, value)
    return widen(value, 2 / gain.high, 2 / gain.low)


def of_fractions(low: Fraction, high: Fraction) -> CertifiedValue:
    """The enclosure of a number between two fractions."""
    exact = low == high and Fraction(float(low)) == low
    return CertifiedValue(float(low), float(low), float(low)) if exact else enclosure(float(low), float(high))


def root_of(low: Fraction, high: Fraction) -> CertifiedValue:
    """The enclosure of the square root of a number between two fractions; a negative one counts as zero."""
    first, last = square_root(low), square_root(high)
    exact = low == high and Fraction(first) ** 2 == low
    return CertifiedValue(first, first, first) if exact else enclosure(first, last)


def enclosing_root(low: Fraction, high: Fraction) -> CertifiedValue:
    """The enclosure of the square root of a number between two fractions, as narrow as doubles are."""
    first, last = rounded_root(low, up=False), rounded_root(high, up=True)
    return CertifiedValue(first + (last - first) / 2, first, last)


def square_root(x: Fraction) -> float:
    """The square root, right to the last place, of a fraction whose own size no double may have."""
    return root_of_quotient(x.numerator, x.denominator)


def rounded_root(x: Fraction, up: bool) -> float:
    """The square root of a fraction as a double that is not larger, or, `up`, not smaller.

    Raises
    ------
    DesignError
        If it is larger than any double.
    """
    if x == 0:
        return 0.0
    exponent = 2 * ((160 - x.numerator.bit_length() + x.denominator.bit_length()) // 2)
    root = Fraction(math.isqrt(math.floor(x * Fraction(2) ** exponent)) + up) / Fraction(2) ** (exponent // 2)
    if root.numerator.bit_length() - root.denominator.bit_length() > LARGEST_EXPONENT:
        raise DesignError("the norm is beyond 1e307, which is more than a double holds; choose other units.")
    near = float(root)
    wrong = near < root if up else near > root
    return math.nextafter(near, math.inf if up else 0.0) if wrong else near


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


def magnitude(x: CertifiedValue) -> CertifiedValue:
    """The number |x|."""
    return x if x.value >= 0 else CertifiedValue(-x.value, -x.high, -x.low)


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
