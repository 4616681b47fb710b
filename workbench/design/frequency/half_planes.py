"""The number of roots of a polynomial in the right half-plane and on the imaginary axis, exactly."""

from __future__ import annotations

from itertools import pairwise

from workbench.design.frequency.integer_polynomials import Polynomial, primitive, scale, trim
from workbench.design.frequency.isolated_roots import isolated_roots


def unstable_roots(p: Polynomial) -> tuple[int, int]:
    """The roots of a real polynomial with Re s > 0, and those on the imaginary axis, each with its multiplicity.

    The Cauchy index of the two real parts of p(j omega) is the number of roots on the left less that on the right.

    References
    ----------
    Gantmacher (1959), The Theory of Matrices, volume 2, chapter XV, sections 3 and 4.
    """
    p = trim(p)
    n = len(p) - 1
    even = [0 if k % 2 != n % 2 else (-1) ** ((n - k) // 2) * a for k, a in enumerate(p)]
    odd = trim([0 if k % 2 == n % 2 else (-1) ** ((n - 1 - k) // 2) * a for k, a in enumerate(p)])
    chain = [even, odd] if odd else [even]
    while len(chain) > 1:
        rest = _negative_remainder(chain[-2], chain[-1])
        if not rest:
            break
        chain.append(rest)
    at_plus = [q[-1] > 0 for q in chain]
    at_minus = [(q[-1] > 0) == (len(q) % 2 == 1) for q in chain]
    index = sum(a != b for a, b in pairwise(at_minus)) - sum(a != b for a, b in pairwise(at_plus))
    axis = _real_roots(chain[-1])
    return (n - axis - index) // 2, axis


def _real_roots(q: Polynomial) -> int:
    """The real roots of a polynomial that is even or odd, with their multiplicities."""
    at_zero = next(i for i, a in enumerate(q) if a)
    return at_zero + 2 * sum(root.multiplicity for root in isolated_roots(q, bits=1))


def _negative_remainder(p: Polynomial, q: Polynomial) -> Polynomial:
    """A positive multiple of the remainder of p by q, with the other sign."""
    rest = list(p)
    while len(rest) >= len(q):
        lead, offset, positive = rest[-1], len(rest) - len(q), abs(q[-1])
        factor = lead if q[-1] > 0 else -lead
        rest = scale(rest, positive)
        for j, b in enumerate(q):
            rest[offset + j] -= factor * b
        rest = trim(rest)
    return scale(primitive(rest), -1) if rest else rest
