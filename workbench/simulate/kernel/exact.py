"""A product and a sum with one rounding, where the processor is not asked for its own instruction.

References
----------
Boldo and Melquiond (2008), Emulation of a FMA and correctly rounded sums: proved algorithms using rounding to odd,
IEEE Transactions on Computers 57, section 4.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from workbench.simulate.kernel.functions import halves

# Within these sizes no part of a product is lost below the range of a double, and none beyond it.
LEAST_PRODUCT, MOST_FACTOR, MOST_TERM = 2.0**-960, 2.0**990, 2.0**1000


def fma(a: Any, b: Any, c: Any) -> Any:
    """a b + c with one rounding, elementwise."""
    with np.errstate(all="ignore"):
        product = np.multiply(a, b)
        result = np.asarray(_by_parts(a, b, c, product))
        size = np.abs(product)
        amid = (size >= LEAST_PRODUCT) & (size <= MOST_TERM) & (np.abs(c) <= MOST_TERM)
        amid &= (np.abs(a) <= MOST_FACTOR) & (np.abs(b) <= MOST_FACTOR)
        if not amid.all():
            finite = np.isfinite(a) & np.isfinite(b)
            plain = np.where(finite & ~np.isfinite(c), c, product + c)  # exact products: of zero, of what is not finite
            known = amid | ~finite | ~np.isfinite(c) | (a == 0) | (b == 0)
            result = np.where(amid, result, plain)
            if not known.all():
                rare = np.flatnonzero(~known)
                operands = (np.broadcast_to(part, result.shape).flat[rare].tolist() for part in (a, b, c))
                result.flat[rare] = [_one(*each) for each in zip(*operands, strict=True)]
    return result


def _by_parts(a: Any, b: Any, c: Any, product: Any) -> Any:
    """From an exact product and two exact sums, of which the smaller parts are added with rounding to odd."""
    (ah, al), (bh, bl) = halves(a), halves(b)
    lacking = al * bl - (((product - ah * bh) - al * bh) - ah * bl)
    middle, low = _sum(c, lacking)
    high, rest = _sum(product, middle)
    return high + _odd(rest, low)


def _sum(a: Any, b: Any) -> tuple[Any, Any]:
    """The rounded sum and what it lacks (Knuth)."""
    total = a + b
    other = total - a
    return total, (a - (total - other)) + (b - other)


def _odd(a: Any, b: Any) -> Any:
    """A sum that is exact or, of the two doubles beside it, the one with an odd last bit."""
    total, lacking = _sum(a, b)
    bits = np.asarray(total).view(np.int64)
    outward = np.where((lacking > 0) == (total > 0), 1, -1)
    return np.where((lacking != 0) & (bits & 1 == 0), bits + outward, bits).view(np.float64)


def _one(a: float, b: float, c: float) -> float:
    """From fractions; of finite numbers whose product is not zero."""
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    try:
        return float(exact)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf
