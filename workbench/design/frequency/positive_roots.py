"""Real roots of polynomials with whole coefficients, each alone in an interval, and bounds of polynomials there.

References
----------
Collins and Akritas (1976), Polynomial real root isolation using Descartes' rule of signs, SYMSAC '76.
Abbott (2014), Quadratic interval refinement for real roots, ACM Communications in Computer Algebra 48.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise

from workbench.design.frequency.integer_polynomials import (
    Polynomial,
    derivative,
    shift,
    square_free_factors,
    stretch,
    trim,
)

BITS = 160  # of a root that are known: three doubles, so that a loss of one hundred bits leaves a double
FINEST = 2**64  # parts of an interval that a step of the refinement may make


@dataclass(frozen=True)
class Root:
    """A real root: the only one of a polynomial from `low` to `high`, which are equal where it is exactly known.

    The ends are whole numbers over powers of two, as is every place at which a polynomial is asked here.
    """

    low: Fraction
    high: Fraction
    multiplicity: int = 1
    factor: Polynomial = field(default_factory=list, repr=False, compare=False)

    @property
    def middle(self) -> Fraction:
        """The middle of the interval."""
        return (self.low + self.high) / 2

    def refine(self, bits: int = BITS) -> Root:
        """The same root known to so many bits; `factor` is a polynomial that has it as a simple root."""
        low, high = _refine(self.factor, self.low, self.high, bits)
        return replace(self, low=low, high=high)


def positive_roots(p: Polynomial, bits: int = BITS) -> list[Root]:
    """The positive roots of a polynomial in ascending order, each known to `bits` bits, none overlooked."""
    roots = []
    for factor, multiplicity in square_free_factors(trim(p)):
        factor = factor[next(i for i, a in enumerate(factor) if a) :]
        roots += [Root(low, high, multiplicity, factor).refine(bits) for low, high in _isolate(factor)]
    return sorted(roots, key=lambda root: root.low)


def unit_roots(p: Polynomial, bits: int = BITS) -> list[Root]:
    """The roots of a polynomial between 0 and 1, without these, in ascending order."""
    roots = []
    for factor, multiplicity in square_free_factors(trim(p)):
        factor = factor[next(i for i, a in enumerate(factor) if a) :]
        roots += [Root(low, high, multiplicity, factor).refine(bits) for low, high in _isolate(factor, 0)]
    return sorted(roots, key=lambda root: root.low)


def at(p: Polynomial, x: Fraction) -> Fraction:
    """The value p(x), exactly."""
    places = _places(x)
    return Fraction(_value(p, x, places), 1 << places * max(len(p) - 1, 0))


def bounds(p: Polynomial, root: Root) -> tuple[Fraction, Fraction]:
    """Bounds of p from below and above over the interval of a positive root."""
    if root.low == root.high:
        value = at(p, root.low)
        return value, value
    rising, falling = [max(a, 0) for a in p], [max(-a, 0) for a in p]
    low, high = root.low, root.high
    return at(rising, low) - at(falling, high), at(rising, high) - at(falling, low)


def ratio(p: Polynomial, q: Polynomial, x: Fraction) -> tuple[int, int]:
    """Two whole numbers in the proportion of p(x) to q(x)."""
    places, excess = _places(x), len(q) - len(p)
    top, bottom = _value(p, x, places), _value(q, x, places)
    return (top << places * excess, bottom) if excess > 0 else (top, bottom << places * -excess)


def _places(x: Fraction) -> int:
    """The binary places of x, a whole number over a power of two."""
    return x.denominator.bit_length() - 1


def _value(p: Polynomial, x: Fraction, places: int) -> int:
    """The whole number p(x) 2^(n places), n = len(p) - 1, for an x with at most so many binary places."""
    total, whole = 0, x.numerator << places - _places(x)
    for i, a in enumerate(reversed(p)):
        total = total * whole + (a << places * i)
    return total


def _sign(p: Polynomial, x: Fraction) -> int:
    value = _value(p, x, _places(x))
    return (value > 0) - (value < 0)


def _isolate(p: Polynomial, top: int | None = None) -> list[tuple[Fraction, Fraction]]:
    """Open intervals with one root each, or exact roots twice, of a square-free polynomial that is not zero at 0.

    They are the positive roots, or those below 2^top if it is given.
    """
    if _variations(p) == 0:
        return []
    top = _upper_bound(p) if top is None else top
    unit, intervals = Fraction(2) ** top, []
    nodes = [(stretch(p, 2**top) if top >= 0 else stretch(p, 1, 2**-top), 0, 0)]
    while nodes:
        q, place, depth = nodes.pop()
        count = _variations(shift(q[::-1]))
        if count == 0:
            continue
        if count == 1:
            intervals.append((unit * Fraction(place, 2**depth), unit * Fraction(place + 1, 2**depth)))
            continue
        left = stretch(q, 1, 2)
        right = shift(left)
        if right[0] == 0:
            right = right[1:]
            intervals.append((unit * Fraction(2 * place + 1, 2 ** (depth + 1)),) * 2)
        nodes += [(left, 2 * place, depth + 1), (right, 2 * place + 1, depth + 1)]
    return intervals


def _variations(p: Polynomial) -> int:
    signs = [a > 0 for a in p if a]
    return sum(a != b for a, b in pairwise(signs))


def _upper_bound(p: Polynomial) -> int:
    """An exponent k such that every root is smaller than 2^k in modulus (Fujiwara)."""
    n, lead = len(p) - 1, p[-1].bit_length()
    return 1 + max((-((lead - 1 - p[n - i].bit_length()) // i) for i in range(1, n + 1) if p[n - i]), default=0)


def _refine(p: Polynomial, low: Fraction, high: Fraction, bits: int) -> tuple[Fraction, Fraction]:
    """The interval of a root with a width of 2^-bits of its end: a chord says in which of many parts it may lie."""
    if low == high:
        return low, high
    before, parts = _sign(p, low) or _sign(derivative(p), low), 4
    while (high - low) * 2**bits > high:
        places = max(_places(low), _places(high))
        start, end = _value(p, low, places), _value(p, high, places)
        if (start > 0) == (end > 0) or not start or not end:  # an end is another root
            parts = 2
        place = min(parts * start // (start - end), parts - 1) if parts > 2 else 0
        left = low + (high - low) * Fraction(place, parts)
        right = left + (high - low) / parts
        signs = (_sign(p, left) or before if left == low else _sign(p, left), _sign(p, right))
        for x, sign in zip((left, right), signs, strict=True):
            if sign == 0 and low < x < high:
                return x, x
        if signs[0] != before:
            high, parts = left, max(2, math.isqrt(parts))
        elif signs[1] == before:
            low, parts = right, max(2, math.isqrt(parts))
        else:
            low, high, parts = left, right, min(parts * parts, FINEST)
    return low, high
