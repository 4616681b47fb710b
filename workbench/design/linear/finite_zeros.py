"""The finite zeros of a state space with one channel, told from those that rounding brings back from infinity."""

from __future__ import annotations

import numpy as np

from workbench.design.matrices import Complex
from workbench.validation.refusals import Array

NOUGHT = 1e-11  # of the sizes of its factors: a Markov parameter below it is zero


def markov_parameter(A: Array, B: Array, Cy: Array, D: Array) -> tuple[int, float]:
    """The number of poles above that of zeros, and the gain K of G = K s^-number for large s; (nx, 0.0) for G = 0.

    It is the first of D, C B, C A B, ... that is not zero.
    """
    if D[0, 0] != 0:
        return 0, float(D[0, 0])
    size, power = float(np.linalg.norm(A, 2)) if len(A) else 0.0, np.asarray(B, dtype=float)
    scale = float(np.linalg.norm(Cy) * np.linalg.norm(B))
    for order in range(1, len(A) + 1):
        value = float((Cy @ power)[0, 0])
        if abs(value) > NOUGHT * scale:
            return order, value
        power, scale = A @ power, scale * size
    return len(A), 0.0


def finite_zeros(zeros: Complex, count: int) -> Complex:
    """The smallest of the zeros, as many as there are."""
    return np.asarray(zeros[np.argsort(np.abs(zeros), kind="stable")][: max(count, 0)])
