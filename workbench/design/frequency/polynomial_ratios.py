"""Ratios of polynomials with whole coefficients, in lowest terms."""

from __future__ import annotations

from fractions import Fraction

from workbench.design.frequency.integer_polynomials import (
    PRIME,
    Polynomial,
    add,
    common_divisor,
    derivative,
    divide,
    multiply,
    scale,
    trim,
)

Ratio = tuple[Polynomial, Polynomial]


def slope_numerator(F: Polynomial, G: Polynomial) -> Polynomial:
    """F' G - F G', the numerator of the slope of F / G."""
    return trim(add(multiply(derivative(F), G), scale(multiply(F, derivative(G)), -1)))


def lowest_terms(F: Polynomial, G: Polynomial) -> Ratio:
    """F / G without the common divisor of F and G, which is not zero."""
    F, G = trim(F), trim(G)
    if not F:
        return [], [1]
    if _coprime(F, G):
        return F, G
    shared = common_divisor(F, G)
    f, g = divide(F, shared), divide(G, shared)
    ratio = Fraction(F[-1] * g[-1], G[-1] * f[-1])
    return scale(f, ratio.numerator), scale(g, ratio.denominator)


def _coprime(F: Polynomial, G: Polynomial) -> bool:
    """True if F and G have no common divisor modulo a prime, which their degrees survive, and so none at all."""
    a, b = ([c % PRIME for c in p] for p in (F, G))
    if not (a[-1] and b[-1]):
        return False
    while len(b) > 1:
        inverse = pow(b[-1], -1, PRIME)
        while len(a) >= len(b):
            factor, offset = a[-1] * inverse % PRIME, len(a) - len(b)
            for j, c in enumerate(b):
                a[offset + j] = (a[offset + j] - factor * c) % PRIME
            a = trim(a)
        a, b = b, a
    return len(b) == 1
