"""The response of a system by elimination, and how far rounding may have moved it."""

from __future__ import annotations

import numpy as np
from scipy.linalg import matrix_balance

from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS, Complex, DesignError


def response_with_error(
    what: str,
    omega: Array,
    matrix: Complex,
    input_matrix: Complex,
    output_matrix: Complex,
    through: Complex,
    sizes: Array,
) -> tuple[Complex, Array]:
    """seen matrix^-1 driven + through at each frequency (m, ny, nu), and the error that rounding may have made there.

    To first order each entry of the matrix is off by some roundings of itself and of its `sizes`, which the answers of
    both sides weigh.
    """
    scale = matrix_balance(np.abs(matrix).max(axis=0), permute=False, separate=True)[1][0]
    matrix, input_matrix, output_matrix = (
        matrix * scale / scale[:, np.newaxis],
        input_matrix / scale[:, np.newaxis],
        output_matrix * scale,
    )
    try:
        right = _refined_solution(matrix, input_matrix)
        left = _refined_solution(matrix.swapaxes(1, 2), output_matrix.swapaxes(1, 2)).swapaxes(1, 2)
    except np.linalg.LinAlgError:
        right = left = np.full((), np.nan)
    if not np.isfinite(right).all() or not np.isfinite(left).all():
        at = omega[int(np.argmin([np.linalg.svd(one, compute_uv=False)[-1] for one in matrix]))]
        raise DesignError(f"{what} has a pole at {at:.6g} rad/s, where it has no answer; leave that frequency out.")
    size = np.abs(matrix) + sizes * scale / scale[:, np.newaxis]
    terms = (
        np.abs(left) @ (size @ np.abs(right) + np.abs(input_matrix))
        + np.abs(output_matrix) @ np.abs(right)
        + np.abs(through)
    )
    return np.asarray(output_matrix @ right + through), np.asarray((matrix.shape[1] + 1) * EPS * terms)


def _refined_solution(matrix: Complex, right_side: Complex) -> Complex:
    """matrix^-1 driven, with a step of refinement, after which each entry of the matrix counts by its own size."""
    first = np.linalg.solve(matrix, right_side)
    return np.asarray(first + np.linalg.solve(matrix, right_side - matrix @ first))
