"""The singular values of a graded triangular matrix, each with its own digits, by rotations in long numbers.

References
----------
Drmac and Veselic (2008), New fast and accurate Jacobi SVD algorithm, SIAM J. Matrix Anal. Appl. 29.
"""

from __future__ import annotations

import math

from workbench.design.frequency.rational_matrices import Whole
from workbench.design.matrices import DesignError
from workbench.design.reduction.fixed_point import FixedPoint

MOST_SWEEPS = 60


def orthogonal_columns(R: FixedPoint) -> FixedPoint:
    """R' J with an orthogonal J that makes its columns orthogonal: their lengths are the singular values of R.

    Their directions are its right singular vectors. R comes from a factorisation with pivots, which makes the sweeps
    of rotations few.
    """
    W = R.numbers.T.copy()
    for _ in range(MOST_SWEEPS):
        if not _sweep(W, R.bits):
            return FixedPoint(W, R.bits)
    raise DesignError("the singular values of two Gramians did not settle; choose other units.")


def _sweep(W: Whole, bits: int) -> bool:
    """Rotate each pair of columns to right angles, in place; True if any pair was not."""
    moved, n, sure = False, W.shape[1], 2 * (bits // 3)
    for i in range(n - 1):
        for j in range(i + 1, n):
            u, v = W[:, i], W[:, j]
            a, b, c = int(u @ u), int(v @ v), int(u @ v)
            if c == 0 or c * c << sure <= a * b:
                continue
            moved = True
            t = _tangent(b - a, 2 * c, bits)
            cosine = math.isqrt((1 << 4 * bits) // ((1 << 2 * bits) + t * t))
            sine = (cosine * t) >> bits
            W[:, i], W[:, j] = (cosine * u - sine * v) >> bits, (sine * u + cosine * v) >> bits
    return moved


def _tangent(gap: int, twice: int, bits: int) -> int:
    """The tangent, times 2^bits, of the smaller angle whose double has the tangent twice / gap."""
    if abs(twice) << 27 < abs(gap):
        return (twice << bits) // (2 * gap)
    zeta = gap / twice
    return int(math.copysign(1.0, zeta) / (abs(zeta) + math.hypot(1.0, zeta)) * 2**60) << bits - 60
