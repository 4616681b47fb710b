"""Sums of rational coefficient x monomial x sine or cosine, as dictionaries; products become sums.

A key is (monomial, wave): the monomial a sorted tuple of (name, exponent), the wave "cos" or "sin" with its angle, a
rational polynomial as a sorted tuple. The number 1 is the cosine of the angle 0, so that all terms have one form.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Literal, TypeAlias

Monomial: TypeAlias = tuple[tuple[str, int], ...]
Angle: TypeAlias = tuple[tuple[Monomial, Fraction], ...]
Wave: TypeAlias = tuple[Literal["cos", "sin"], Angle]
Key: TypeAlias = tuple[Monomial, Wave]
Terms: TypeAlias = dict[Key, Fraction]

PLAIN: Wave = ("cos", ())
UNIT: Key = ((), PLAIN)
HALF = Fraction(1, 2)
# Beyond so many products at once, or such a power, an expansion would take minutes; it is given up.
MOST_PRODUCTS, HIGHEST_POWER = 500_000, 64


class NotInClass(ValueError):  # noqa: N818
    """The error of an expression without a normal form; the message names the operation."""


def constant(value: Fraction) -> Terms:
    """A number."""
    return {UNIT: value} if value else {}


def variable(name: str) -> Terms:
    """A symbol."""
    return {(((name, 1),), PLAIN): Fraction(1)}


def scale(terms: Terms, factor: Fraction) -> Terms:
    """A sum times a number."""
    return {key: value * factor for key, value in terms.items()} if factor else {}


def add(a: Terms, b: Terms, sign: int = 1) -> Terms:
    """a + b, or with sign -1 the difference."""
    result = dict(a)
    for key, value in b.items():
        _add(result, key, value if sign == 1 else -value)
    return result


def _add(terms: Terms, key: Key, value: Fraction) -> None:
    before = terms.get(key)
    if before is None:
        terms[key] = value
    elif total := before + value:
        terms[key] = total
    else:
        del terms[key]


def multiply(a: Terms, b: Terms) -> Terms:
    """a b, with each product of two waves written as the sum of two others."""
    if len(a) * len(b) > MOST_PRODUCTS:
        raise NotInClass(f"MUL of sums of {len(a)} and {len(b)} terms: too long to expand.")
    result: Terms = {}
    for (m, u), x in a.items():
        for (n, v), y in b.items():
            monomial = times(m, n)
            if not u[1] or not v[1]:
                _add(result, (monomial, u if u[1] else v), x * y)
                continue
            for wave, factor in _product_to_sum(u, v):
                _add(result, (monomial, wave), x * y * factor)
    return result


@lru_cache(maxsize=1 << 16)
def times(m: Monomial, n: Monomial) -> Monomial:
    """The product of two monomials."""
    if not m or not n:
        return m or n
    exponents = dict(m)
    for name, exponent in n:
        exponents[name] = exponents.get(name, 0) + exponent
    return tuple(sorted((name, exponent) for name, exponent in exponents.items() if exponent))


@lru_cache(maxsize=1 << 16)
def _product_to_sum(u: Wave, v: Wave) -> tuple[tuple[Wave, Fraction], ...]:
    """Two waves multiplied.

    cos a cos b = (cos(a - b) + cos(a + b)) / 2      sin a cos b = (sin(a + b) + sin(a - b)) / 2
    sin a sin b = (cos(a - b) - cos(a + b)) / 2      cos a sin b = (sin(a + b) - sin(a - b)) / 2
    """
    (first, a), (second, b) = u, v
    kind: Literal["cos", "sin"] = "cos" if first == second else "sin"
    factors = {1: -HALF if first == second == "sin" else HALF, -1: -HALF if (first, second) == ("cos", "sin") else HALF}
    pairs: list[tuple[Wave, Fraction]] = []
    for sign, factor in factors.items():
        angle = dict(a)
        for monomial, coefficient in b:
            angle[monomial] = angle.get(monomial, Fraction(0)) + sign * coefficient
        pairs += _pairs(kind, tuple(sorted((monomial, c) for monomial, c in angle.items() if c)), factor)
    return tuple(pairs)


def _pairs(kind: Literal["cos", "sin"], angle: Angle, factor: Fraction) -> list[tuple[Wave, Fraction]]:
    """A sine or cosine in its one form, whose angle begins with a positive coefficient."""
    if not angle:
        return [(PLAIN, factor)] if kind == "cos" else []
    # The constant, if any, has the empty monomial and so comes first; the sign is that of a symbol if it can be.
    if angle[1 if len(angle) > 1 and not angle[0][0] else 0][1] > 0:
        return [((kind, angle), factor)]
    flipped = tuple((monomial, -coefficient) for monomial, coefficient in angle)
    return [((kind, flipped), factor if kind == "cos" else -factor)]


def wave(kind: Literal["cos", "sin"], argument: Terms) -> Terms:
    """The sine or cosine of a sum without sines and cosines."""
    if any(angle for _, (_, angle) in argument):
        raise NotInClass(f"{kind.upper()} has a normal form only if no sine or cosine stands in its argument.")
    angle: Angle = tuple(sorted((monomial, coefficient) for (monomial, _), coefficient in argument.items()))
    return {((), kept): factor for kept, factor in _pairs(kind, angle, Fraction(1))}


def inverse(terms: Terms) -> Terms:
    """1 / x for a single term without sine or cosine."""
    ((monomial, (_, angle)), coefficient), *others = terms.items() or [(UNIT, Fraction(0))]
    if others or angle or not coefficient:
        raise NotInClass("DIV has a normal form only if the divisor is a number or a product of symbols.")
    return {(tuple((name, -exponent) for name, exponent in monomial), PLAIN): 1 / coefficient}


def power(base: Terms, exponent: Terms) -> Terms:
    """A whole power."""
    n = exponent.get(UNIT, Fraction(0))
    if exponent.keys() - {UNIT} or n.denominator != 1 or abs(n) > HIGHEST_POWER:
        raise NotInClass(f"POW has a normal form only for whole exponents from -{HIGHEST_POWER} to {HIGHEST_POWER}.")
    result = constant(Fraction(1))
    for _ in range(abs(int(n))):
        result = multiply(result, base)
    return inverse(result) if n < 0 else result
