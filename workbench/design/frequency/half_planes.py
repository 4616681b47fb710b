"""The number of roots of a polynomial in the right half-plane and on the imaginary axis, exactly."""

from __future__ import annotations

from itertools import pairwise

from workbench.design.frequency.integer_polynomials import Polynomial, primitive, remainder, scale, trim
from workbench.design.frequency.positive_roots import positive_roots


def is_hurwitz(p: Polynomial) -> bool:
    """True if every root of a polynomial has a negative real part: Routh's array in whole numbers.

    References
    ----------
    Gantmacher (1959), The Theory of Matrices, volume 2, chapter XV.
    """
    if not p or p[-1] == 0:
        return False
    p = p if p[-1] > 0 else scale(p, -1)
    above, row = p[::-1][0::2], p[::-1][1::2]
    for _ in range(len(p) - 1):
        if not row or row[0] <= 0:
            return False
        padded = row + [0] * (len(above) - len(row))
        below = [above[j + 1] * row[0] - above[0] * padded[j + 1] for j in range(len(above) - 1)]
        above, row = row, primitive(below) if any(below) else below
    return True


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
        rest = remainder(chain[-2], chain[-1])
        if not rest:
            break
        chain.append(scale(rest, -1))
    at_plus = [q[-1] > 0 for q in chain]
    at_minus = [(q[-1] > 0) == (len(q) % 2 == 1) for q in chain]
    index = sum(a != b for a, b in pairwise(at_minus)) - sum(a != b for a, b in pairwise(at_plus))
    axis = _real_roots(chain[-1])
    return (n - axis - index) // 2, axis


def _real_roots(q: Polynomial) -> int:
    """The real roots of a polynomial that is even or odd, with their multiplicities."""
    at_zero = next(i for i, a in enumerate(q) if a)
    return at_zero + 2 * sum(root.multiplicity for root in positive_roots(q, bits=1))
