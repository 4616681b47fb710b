"""Polynomials with whole coefficients, lowest power first: exact products, quotients, shifts and common divisors.

Doubles are rationals, so what is made of them by sums and products is exact here, and no tolerance decides a degree.
"""

from __future__ import annotations

import math
from itertools import accumulate, zip_longest

Polynomial = list[int]
PRIME = 2**61 - 1  # modulo which a polynomial without a repeated root is recognised at once


def trim(p: Polynomial) -> Polynomial:
    """The polynomial without zeros in its highest powers; the zero polynomial is empty."""
    last = len(p)
    while last and p[last - 1] == 0:
        last -= 1
    return p[:last]


def add(p: Polynomial, q: Polynomial) -> Polynomial:
    """The sum p + q."""
    return [a + b for a, b in zip_longest(p, q, fillvalue=0)]


def scale(p: Polynomial, factor: int) -> Polynomial:
    """The product of a polynomial and a whole number."""
    return [factor * a for a in p]


def multiply(p: Polynomial, q: Polynomial) -> Polynomial:
    """The product p q."""
    product = [0] * max(len(p) + len(q) - 1, 0)
    for i, a in enumerate(p):
        if a:
            for j, b in enumerate(q):
                product[i + j] += a * b
    return product


def quotient(p: Polynomial, divisor: Polynomial) -> Polynomial:
    """The quotient of p by a divisor whose coefficients have no common factor: then it is whole, too (Gauss)."""
    rest, n = list(p), len(divisor) - 1
    result = [0] * max(len(p) - n, 0)
    for i in range(len(result) - 1, -1, -1):
        result[i] = factor = rest[i + n] // divisor[-1]
        if factor:
            for j, b in enumerate(divisor):
                rest[i + j] -= factor * b
    return result


def primitive(p: Polynomial) -> Polynomial:
    """The polynomial divided by the common divisor of its coefficients, which is positive."""
    common = math.gcd(*p)
    return [a // common for a in p] if common > 1 else list(p)


def derivative(p: Polynomial) -> Polynomial:
    """The derivative p'."""
    return [i * a for i, a in enumerate(p)][1:]


def shift(p: Polynomial) -> Polynomial:
    """The polynomial p(x + 1), by repeated division by x - 1."""
    rest, shifted = p[::-1], []
    while rest:
        rest = list(accumulate(rest))
        shifted.append(rest.pop())
    return shifted


def mirror(p: Polynomial) -> Polynomial:
    """The polynomial p(-x)."""
    return [-a if i % 2 else a for i, a in enumerate(p)]


def stretch(p: Polynomial, numerator: int, denominator: int = 1) -> Polynomial:
    """The polynomial p(x numerator / denominator), times the power of the denominator that keeps it whole."""
    n = len(p) - 1
    return [a * numerator**i * denominator ** (n - i) for i, a in enumerate(p)]


def bilinear(p: Polynomial) -> Polynomial:
    """The polynomial (1 - v)^n p((1 + v) / (1 - v)), n = len(p) - 1: the unit circle becomes the imaginary axis."""
    about = mirror(shift(mirror(p)))  # p(t - 1), with t = 2 / (1 - v)
    return mirror(shift(stretch(about, 2)[::-1]))


def squared_modulus(p: Polynomial) -> Polynomial:
    """The polynomial |p(j omega)|^2 of x = omega^2."""
    even, odd = mirror(p[0::2]), mirror(p[1::2])
    return add(multiply(even, even), [0, *multiply(odd, odd)])


def remainder(p: Polynomial, q: Polynomial) -> Polynomial:
    """A positive multiple of the remainder of p by q, without a common factor of its coefficients."""
    rest, sign = list(p), 1 if q[-1] > 0 else -1
    while len(rest) >= len(q):
        lead, offset = rest[-1], len(rest) - len(q)
        common = math.gcd(lead, q[-1])
        factor = sign * lead // common
        rest = scale(rest, abs(q[-1]) // common)
        for j, b in enumerate(q):
            rest[offset + j] -= factor * b
        rest = trim(rest)
    return primitive(rest) if rest else rest


def common_divisor(p: Polynomial, q: Polynomial) -> Polynomial:
    """The greatest common divisor without a common factor of its coefficients (Euclid)."""
    p, q = primitive(trim(p)), primitive(trim(q))
    if not (p and q):
        return p or q
    i, j = (next(k for k, a in enumerate(f) if a) for f in (p, q))
    p, q, zeros = p[i:], q[j:], [0] * min(i, j)  # roots at zero are seen without a division
    if _coprime_modulo(p, q):
        return [*zeros, 1]
    while q:
        p, q = q, remainder(p, q) if len(p) >= len(q) else p
    return [*zeros, *p]


def square_free_factors(p: Polynomial) -> list[tuple[Polynomial, int]]:
    """The factors without repeated roots, each with the multiplicity of its roots in p (Yun)."""
    p = primitive(trim(p))
    if len(p) < 2:
        return []
    factors, multiplicity = [], 1
    repeated = common_divisor(p, derivative(p))
    simple = quotient(p, repeated)
    while len(simple) > 1:
        shared = common_divisor(simple, repeated)
        factor = quotient(simple, shared)
        if len(factor) > 1:
            factors.append((factor, multiplicity))
        simple, repeated, multiplicity = shared, quotient(repeated, shared), multiplicity + 1
    return factors


def _coprime_modulo(p: Polynomial, q: Polynomial) -> bool:
    """True if p and q have no common divisor modulo a prime that keeps their degrees, and so none at all."""
    if p[-1] % PRIME == 0 or q[-1] % PRIME == 0:
        return False
    a, b = ([c % PRIME for c in f] for f in (p, q))
    while len(b) > 1:
        inverse = pow(b[-1], -1, PRIME)
        while len(a) >= len(b):
            factor, offset = a[-1] * inverse % PRIME, len(a) - len(b)
            for j, c in enumerate(b):
                a[offset + j] = (a[offset + j] - factor * c) % PRIME
            a = trim(a)
        a, b = b, a
    return len(b) == 1
