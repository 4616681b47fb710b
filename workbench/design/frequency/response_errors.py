"""The response of a system by elimination, and how far rounding may have moved it."""

from __future__ import annotations

import numpy as np
from scipy.linalg import matrix_balance

from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS, Complex, Refused


def solved(
    what: str, omega: Array, matrix: Complex, driven: Complex, seen: Complex, through: Complex, sizes: Array
) -> tuple[Complex, Array]:
    """seen matrix^-1 driven + through at each frequency (m, ny, nu), and the error that rounding may have made there.

    To first order each entry of the matrix is off by some roundings of itself and of its `sizes`, which the answers of
    both sides weigh.
    """
    scale = matrix_balance(np.abs(matrix).max(axis=0), permute=False, separate=True)[1][0]
    matrix, driven, seen = matrix * scale / scale[:, np.newaxis], driven / scale[:, np.newaxis], seen * scale
    try:
        right = _refined(matrix, driven)
        left = _refined(matrix.swapaxes(1, 2), seen.swapaxes(1, 2)).swapaxes(1, 2)
    except np.linalg.LinAlgError:
        right = left = np.full((), np.nan)
    if not np.isfinite(right).all() or not np.isfinite(left).all():
        at = omega[int(np.argmin([np.linalg.svd(one, compute_uv=False)[-1] for one in matrix]))]
        raise Refused(f"{what} has a pole at {at:.6g} rad/s, where it has no answer; leave that frequency out.")
    size = np.abs(matrix) + sizes * scale / scale[:, np.newaxis]
    terms = np.abs(left) @ (size @ np.abs(right) + np.abs(driven)) + np.abs(seen) @ np.abs(right) + np.abs(through)
    return np.asarray(seen @ right + through), np.asarray((matrix.shape[1] + 1) * EPS * terms)


def _refined(matrix: Complex, driven: Complex) -> Complex:
    """matrix^-1 driven, with a step of refinement, after which each entry of the matrix counts by its own size."""
    first = np.linalg.solve(matrix, driven)
    return np.asarray(first + np.linalg.solve(matrix, driven - matrix @ first))
