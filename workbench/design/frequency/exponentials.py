"""The integral of the exponential of a matrix, from which the map of a linear plant over any span follows."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from scipy.linalg import matrix_balance

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex, DesignError

Matrix = TypeVar("Matrix", Array, Complex)  # real or complex, perhaps a stack of them
TERMS = 16  # of the series, at a norm of one half: what is left out is 0.5^16 / 17! = 4e-20
DOUBLINGS = 60


def growth(A: Matrix, span: float) -> tuple[Matrix, Matrix]:
    """E = exp(A span) - I, and S, the integral of exp(A s) over s from 0 to `span`, both (..., n, n); E = A S.

    Both are series over a short part of the span, which is then doubled: E(2t) = 2 E + E^2 and S(2t) = 2 S + E S. No I
    is added, so small entries, as a chain of integrators at a short period has, keep their digits; the exponential of
    Van Loan's block matrix is right relative to its largest entry only. A stack is balanced by the same powers of two.

    Raises
    ------
    DesignError
        If the exponential leaves the range of floating-point numbers.

    References
    ----------
    Van Loan (1978), Computing integrals involving the matrix exponential, IEEE Trans. Autom. Control 23.
    """
    n = A.shape[-1]
    if not n:
        return A, A
    sizes = np.abs(A).reshape(-1, n, n).max(axis=0, initial=0.0)
    scale = matrix_balance(sizes, permute=False, separate=True)[1][0]
    X = A * scale / scale[:, np.newaxis]
    norm = float((sizes * scale / scale[:, np.newaxis]).sum(axis=0).max(initial=0.0)) * span
    doublings = max(0, math.ceil(math.log2(norm)) + 1) if norm else 0
    if doublings > DOUBLINGS:
        raise DesignError(_too_fast(A, span))
    X = X * (span / 2**doublings)
    S = term = np.broadcast_to(np.eye(n), A.shape)
    for k in range(2, TERMS + 1):
        term = term @ X / k
        S = S + term
    with np.errstate(all="ignore"):
        E, S = X @ S, S * (span / 2**doublings)
        for _ in range(doublings):
            E, S = 2 * E + E @ E, 2 * S + E @ S
    if not np.isfinite(E).all() or not np.isfinite(S).all():
        raise DesignError(_too_fast(A, span))
    back = scale[:, np.newaxis] / scale
    return np.asarray(E * back), np.asarray(S * back)


def _too_fast(A: Matrix, span: float) -> str:
    return (
        f"The exponential of the plant over {span:g} s leaves the range of floating-point numbers, as its matrix has "
        f"entries up to {np.abs(A).max():.3g} 1/s; take a shorter period."
    )


def held_map(A: Array, B: Array, span: float) -> tuple[Array, Array]:
    """E and G of a plant whose input is held: the change of x over a span is E x + G u."""
    E, S = growth(A, span)
    return E, S @ B
