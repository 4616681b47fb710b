"""The integral of the exponential of a matrix, from which the map of a linear plant over any span follows."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import expm, matrix_balance

from workbench.design.matrices import Refused
from workbench.validation.refusals import Array

Matrix = np.ndarray[Any, Any]  # real or complex, perhaps several of them


def integral_of_exponential(A: Matrix, span: float) -> Matrix:
    """The integral of exp(A s) over s from 0 to `span`, (..., n, n), as a block of one exponential.

    With it exp(A h) - I = A S, to the accuracy of A and not of I, and the input that is held adds S B. All matrices of a
    stack are balanced by the same powers of two.

    Raises
    ------
    Refused
        If the exponential leaves the range of floating-point numbers.

    References
    ----------
    Van Loan (1978), Computing integrals involving the matrix exponential, IEEE Trans. Autom. Control 23.
    """
    n = A.shape[-1]
    if not n or not span:
        return np.zeros_like(A)
    sizes = np.abs(A).reshape(-1, n, n).max(axis=0)
    _, (scale, _) = matrix_balance(sizes, permute=False, separate=True)
    block = np.zeros((*A.shape[:-2], 2 * n, 2 * n), A.dtype)
    block[..., :n, :n] = span * (A * scale / scale[:, np.newaxis])
    block[..., :n, n:] = np.eye(n)
    with np.errstate(all="ignore"):
        S = span * expm(block)[..., :n, n:] * scale[:, np.newaxis] / scale
    if not np.isfinite(S).all():
        raise Refused(
            f"The exponential of the plant over {span:g} s leaves the range of floating-point numbers; its fastest "
            f"pole is {np.linalg.eigvals(A).real.max():.3g} 1/s. Take a shorter period."
        )
    return np.asarray(S)


def held_map(A: Array, B: Array, span: float) -> tuple[Array, Array]:
    """exp(A span) - I and what an input that is held adds: the change of x over a span is E x + G u."""
    S = integral_of_exponential(A, span)
    return A @ S, S @ B
