"""Real roots of polynomials with whole coefficients, each alone in an interval, and bounds of polynomials there.

References
----------
Collins and Akritas (1976), Polynomial real root isolation using Descartes' rule of signs, SYMSAC '76.
Abbott (2014), Quadratic interval refinement for real roots, ACM Communications in Computer Algebra 48.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
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
    """A real root: the only one of its polynomial from `low` to `high`, which are equal where it is exactly known."""

    low: Fraction
    high: Fraction
    multiplicity: int = 1

    @property
    def middle(self) -> Fraction:
        """The middle of the interval."""
        return (self.low + self.high) / 2


def positive_roots(p: Polynomial, bits: int = BITS) -> list[Root]:
    """The positive roots of a polynomial in ascending order, each known to `bits` bits, none overlooked."""
    roots = []
    for factor, multiplicity in square_free_factors(trim(p)):
        factor = factor[next(i for i, a in enumerate(factor) if a) :]
        for low, high in _isolate(factor):
            roots.append(Root(*_refine(factor, low, high, bits), multiplicity))
    return sorted(roots, key=lambda root: root.low)


def at(p: Polynomial, x: Fraction) -> Fraction:
    """The value p(x), exactly."""
    return Fraction(_numerator(p, x), x.denominator ** max(len(p) - 1, 0))


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
    top, bottom = _numerator(p, x), _numerator(q, x)
    excess = len(q) - len(p)
    return (top * x.denominator**excess, bottom) if excess > 0 else (top, bottom * x.denominator**-excess)


def _numerator(p: Polynomial, x: Fraction) -> int:
    """The whole number p(x) d^n of the denominator d of x."""
    total, power = 0, 1
    for a in reversed(p):
        total = total * x.numerator + a * power
        power *= x.denominator
    return total


def _sign(p: Polynomial, x: Fraction) -> int:
    value = _numerator(p, x)
    return (value > 0) - (value < 0)


def _isolate(p: Polynomial) -> list[tuple[Fraction, Fraction]]:
    """Open intervals with one root each, or exact roots twice, of a square-free polynomial that is not zero at 0."""
    if _variations(p) == 0:
        return []
    top = _upper_bound(p)
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
        start, end = at(p, low), at(p, high)
        if start * end >= 0:  # an end is another root
            parts = 2
        place = min(max(int(parts * start / (start - end)), 0), parts - 1) if parts > 2 else 0
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
