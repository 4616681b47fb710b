"""A quadratic polynomial as control variate: what it explains has exact indices, and only the rest is estimated."""

from __future__ import annotations

import numpy as np

from workbench.study.uncertainty.saltelli import SCRAMBLES, SobolDesign
from workbench.validation.refusals import Array

EACH = 4  # runs for each coefficient, below which a fit follows the runs instead of the function


def terms(dimensions: int) -> int:
    """How many terms the polynomial has beside its constant."""
    return dimensions * (dimensions + 3) // 2


def basis(u: Array) -> Array:
    """Orthonormal polynomials at points (N, d) of the unit cube, (N, terms): lines, parabolas, products of lines."""
    i, j = np.triu_indices(u.shape[1], 1)
    line = 12**0.5 * (u - 0.5)
    return np.concatenate([line, 5**0.5 * (line**2 - 1) / 2, line[:, i] * line[:, j]], axis=1)


def polynomials(design: SobolDesign, y: Array) -> tuple[Array, Array]:
    """Of columns (N, c) the polynomials in each scramble, fitted to the runs of the others so that none flatters
    itself: their values (N, c), without the constant, and their coefficients (scrambles, terms, c).
    """
    u = design.points()
    X = np.column_stack([np.ones(len(u)), basis(u)]).reshape(SCRAMBLES, len(u) // SCRAMBLES, -1)
    # normal equations: over so many points the polynomials are nearly orthonormal, so that no digits are lost
    squares, products = np.swapaxes(X, 1, 2) @ X, np.swapaxes(X, 1, 2) @ y.reshape(*X.shape[:2], -1)
    b = np.linalg.solve(squares.sum(axis=0) - squares, products.sum(axis=0) - products)[:, 1:]
    return (X[:, :, 1:] @ b).reshape(y.shape), b


def exact(design: SobolDesign, b: Array) -> dict[str, Array]:
    """The expectations of all means of products for polynomials with coefficients (scrambles, terms, c)."""
    d = design.dimensions
    i, j = np.triu_indices(d, 1)
    squares = b**2
    alone, pairs = squares[:, :d] + squares[:, d : 2 * d], squares[:, 2 * d :]
    inside = (np.arange(d)[:, np.newaxis] == i) | (np.arange(d)[:, np.newaxis] == j)
    variance = squares.sum(axis=1, keepdims=True)
    return {
        "first": alone,
        "total": alone + np.einsum("dk,skc->sdc", inside, pairs),
        "second": pairs,
        "mean": 0 * variance,
        "square": variance,
        "variance": variance,
        "variance of pairs": variance,
    }
