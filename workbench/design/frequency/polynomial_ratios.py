"""Ratios of polynomials with whole coefficients, in lowest terms."""

from __future__ import annotations

import math

from workbench.design.frequency.integer_polynomials import (
    Polynomial,
    add,
    common_divisor,
    derivative,
    multiply,
    quotient,
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
    shared = common_divisor(F, G)
    f, g = quotient(F, shared), quotient(G, shared)
    common = math.gcd(*f, *g)
    return [a // common for a in f], [a // common for a in g]
