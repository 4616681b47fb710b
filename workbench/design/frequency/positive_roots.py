"""Intervals that hold all positive roots of a polynomial, by Descartes' rule of signs: no root is ever overlooked."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

from workbench.design.frequency.integer_polynomials import Polynomial, shift, stretch, trim

Interval = tuple[Fraction, Fraction]


def variations(p: Polynomial) -> int:
    """The number of changes of sign in a sequence of coefficients, zeros skipped: no fewer than its positive roots."""
    signs = [a > 0 for a in p if a]
    return sum(a != b for a, b in pairwise(signs))


def positive_roots(p: Polynomial, bits: int = 40) -> list[Interval]:
    """Intervals in ascending order that together hold every positive root; none means that there is no such root.

    An interval is an exact root, or as narrow as 2^-bits of its upper end. It need not hold a root: a pair of complex
    roots as near to the axis as it is wide counts as one.

    References
    ----------
    Collins and Akritas (1976), Polynomial real root isolation using Descartes' rule of signs, SYMSAC '76.
    """
    p = trim(p)
    while p and p[0] == 0:
        p = p[1:]
    if variations(p) == 0:
        return []
    top = _upper_bound(p)
    unit = Fraction(2) ** top
    found: list[Interval] = []
    nodes = [(stretch(p, 2**top) if top >= 0 else stretch(p, 1, 2**-top), 0, 0)]
    while nodes:
        q, place, depth = nodes.pop()
        if variations(shift(q[::-1])) == 0:
            continue
        if (place + 1) >> bits:
            found.append((unit * Fraction(place, 2**depth), unit * Fraction(place + 1, 2**depth)))
            continue
        left = stretch(q, 1, 2)
        right = shift(left)
        while right[0] == 0:
            right = right[1:]
            middle = unit * Fraction(2 * place + 1, 2 ** (depth + 1))
            found.append((middle, middle))
        nodes += [(left, 2 * place, depth + 1), (right, 2 * place + 1, depth + 1)]
    return sorted(set(found))


def _upper_bound(p: Polynomial) -> int:
    """An exponent k such that every root is smaller than 2^k in modulus (Fujiwara)."""
    n, lead = len(p) - 1, p[-1].bit_length()
    return 1 + max((-((lead - 1 - p[n - i].bit_length()) // i) for i in range(1, n + 1) if p[n - i]), default=0)
