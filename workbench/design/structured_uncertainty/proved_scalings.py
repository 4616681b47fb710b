"""A bound from scalings that holds in spite of rounding: a Cholesky factor is the proof.

References
----------
Rump (2006), Verification of positive definiteness, BIT Numerical Mathematics 46.
"""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS, Complex
from workbench.design.structured_uncertainty.scaling_search import Scalings

TINY = float(np.finfo(float).tiny)


def proved_bound(M: Complex, scalings: Scalings) -> float:
    """A number beta for which beta^2 D - M'DM - j (G M - M'G) is proved to be positive definite.

    Scales by powers of two, which commute with each perturbation, are taken first. The Cholesky factor of the matrix
    less a multiple of the identity proves it, if the multiple exceeds the rounding of the matrix and of the factor.
    """
    M, scalings = _even(M, scalings)
    D, G, n = scalings.D, scalings.G, len(M)
    least = float(np.linalg.eigvalsh(D)[0]) if np.isfinite(D).all() else -1.0
    if not least > 8 * n * EPS * float(np.linalg.norm(D)):
        return np.inf
    form = scalings.form(M)
    size: Array = np.abs(M).T @ np.abs(D) @ np.abs(M) + np.abs(G) @ np.abs(M) + np.abs(M).T @ np.abs(G)
    square = max(scalings.square(M), 0.0)
    margin = 4 * (n + 4) * EPS * (float(np.linalg.norm(size)) + square * float(np.linalg.norm(D)))
    step = max(4 * margin / least, 4 * EPS * square, TINY)
    for _ in range(60):
        level = square + step
        rest = level * D - form
        slack = 4 * (n + 4) * EPS * (float(np.linalg.norm(size)) + level * float(np.linalg.norm(D)))
        slack += 4 * (n + 1) * EPS * max(float(np.trace(rest).real), 0.0) + n * TINY
        try:
            np.linalg.cholesky(rest - slack * np.eye(n))
        except np.linalg.LinAlgError:
            step *= 2
            continue
        return float(np.nextafter(np.sqrt(level), np.inf)) if square > 0 else _zero_or(M, scalings, size, level)
    return np.inf


def _zero_or(M: Complex, scalings: Scalings, size: Array, level: float) -> float:
    """Zero, if the form itself is proved to be negative definite: then no perturbation of any size is singular."""
    n = len(M)
    slack = 8 * (n + 4) * EPS * float(np.linalg.norm(size)) + n * TINY
    if not np.any(size):
        return 0.0
    try:
        np.linalg.cholesky(-scalings.form(M) - slack * np.eye(n))
    except np.linalg.LinAlgError:
        return float(np.nextafter(np.sqrt(level), np.inf))
    return 0.0


def _even(M: Complex, scalings: Scalings) -> tuple[Complex, Scalings]:
    """The same problem in units by powers of two in which D has a diagonal near to one, where D commutes with them."""
    D = scalings.D
    n = len(D)
    groups = list(range(n))
    for i in range(n):
        for j in range(i):
            if D[i, j] != 0 or scalings.G[i, j] != 0:
                groups[i] = groups[j]
    exponents = np.zeros(n)
    for group in set(groups):
        rows = [i for i in range(n) if groups[i] == group]
        exponents[rows] = np.round(np.log2(np.diag(D).real[rows].max()) / 2)
    units = np.exp2(exponents)
    outer = np.multiply.outer(units, units)
    return M * units[:, None] / units, Scalings(D / outer, scalings.G / outer)
