"""Frequency answers of many linear systems at once, each through one reduction to Hessenberg form an input."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import matrix_balance

from workbench.design.frequency.sampled_parts import band
from workbench.design.matrices import EPS, Complex, one_thread
from workbench.validation.notebook_display import show
from workbench.validation.refusals import Array, numbers, seconds
from workbench.validation.signatures import door

ROWS = 32  # at once: what is read and written in a pass stays in the cache


@dataclass(frozen=True, eq=False)
@show
class RowResponses:
    """The answers (N, m, ny, nu) of N systems at `frequencies` (m,) in rad/s; a row that has none is NaN and `flagged`.

    Flagged (N,) are the rows of whose matrices an entry is not finite, and those with a pole at one of the frequencies.
    """

    frequencies: Array
    values: Complex
    flagged: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


@door
def row_responses(
    A: Array, B: Array, Cy: Array, D: Array, frequencies: Array, period: float | None = None
) -> RowResponses:
    """C (s I - A)^-1 B + D of each row at s = j w, or at z = e^(j w h) for systems with the period h.

    A Householder reflection turns an input to the first axis and others bring A to Hessenberg form; then the equations
    from the last to the second give all states as multiples of the last one, and the first equation its size.

    Parameters
    ----------
    A, B, Cy, D
        (N, nx, nx), (N, nx, nu), (N, ny, nx) and (N, ny, nu); states, inputs and outputs are the same in all rows.
    frequencies
        (m,) in rad/s, in rising order from zero; with a period up to Nyquist's.

    Raises
    ------
    ValueError
        If the shapes do not fit, or the frequencies are none, fall, are negative or above Nyquist's.

    References
    ----------
    Laub (1981), Efficient multivariable frequency response computations, IEEE Trans. Autom. Control 26; Wilkinson
    (1965), The Algebraic Eigenvalue Problem, section 7.11 (Hyman's method).
    """
    A, B, Cy, D = (numbers(f"row_responses({name}=...)", M) for name, M in zip("ABCD", (A, B, Cy, D), strict=True))
    N, n, nu, ny = (
        (*A.shape[:2], B.shape[-1], Cy.shape[1]) if {A.ndim, B.ndim, Cy.ndim, D.ndim} == {3} else (0, 0, 0, 0)
    )
    if (A.shape, B.shape, Cy.shape, D.shape) != ((N, n, n), (N, n, nu), (N, ny, n), (N, ny, nu)):
        raise ValueError(
            "`row_responses(A, B, Cy, D)` must have shapes (N, nx, nx), (N, nx, nu), (N, ny, nx) and (N, ny, nu); got "
            f"{A.shape}, {B.shape}, {Cy.shape} and {D.shape}."
        )
    h = None if period is None else seconds("row_responses(period=...)", period)
    omega = band("row_responses(frequencies=...)", frequencies, math.inf if h is None else math.pi / h)
    s = np.asarray(1j * omega if h is None else np.exp(1j * omega * h), complex)
    values = np.full((N, len(s), ny, nu), np.nan, complex)
    sound = np.flatnonzero([all(np.isfinite(M[i]).all() for M in (A, B, Cy, D)) for i in range(N)])
    if n and len(sound):
        scale = matrix_balance(np.abs(A[sound]).max(axis=0), permute=False, separate=True)[1][0]
        A, B, Cy = A * scale / scale[:, np.newaxis], B / scale[:, np.newaxis], Cy * scale
    with one_thread(), np.errstate(all="ignore"):
        for start in range(0, len(sound), ROWS):
            rows = sound[start : start + ROWS]
            for j in range(nu):
                values[rows, :, :, j] = _one_input(A[rows], B[rows, :, j], Cy[rows], s)
    values += D[:, np.newaxis]
    return RowResponses(omega, values, np.asarray(~np.isfinite(values).all(axis=(1, 2, 3))))


def _one_input(A: Array, b: Array, Cy: Array, s: Complex) -> Complex:
    """C (s I - A)^-1 b of each row, (N, m, ny)."""
    N, n = b.shape
    if not n:
        return np.zeros((N, len(s), Cy.shape[1]), complex)
    H, size, C = _hessenberg(A, b, Cy)
    x = np.empty((N, n, len(s)), complex)
    x[:, n - 1] = 1
    parts = x.view(float)  # real and imaginary parts side by side, for products with real matrices
    for k in range(n - 1, 0, -1):
        known = (H[:, k : k + 1, k:] @ parts[:, k:]).view(complex)[:, 0]
        x[:, k - 1] = (s * x[:, k] - known) / H[:, k, k - 1, np.newaxis]
    first = s * x[:, 0] - (H[:, :1] @ parts).view(complex)[:, 0]
    answer = (C @ parts).view(complex) * (size[:, np.newaxis] / first)[:, np.newaxis]
    for i in np.flatnonzero(~np.isfinite(answer).all(axis=(1, 2))):  # an input that does not reach all states, say
        answer[i] = _pivoted(A[i], b[i], Cy[i], s)
    terms = np.abs(s) * np.abs(x[:, 0]) + (np.abs(H[:, :1]) @ np.abs(x))[:, 0]
    poles = np.abs(first) <= 10 * n * EPS * terms  # s is an eigenvalue, as far as rounding can tell
    answer = np.where(poles[:, np.newaxis], np.nan, answer)
    return np.asarray(answer.swapaxes(1, 2))


def _hessenberg(A: Array, b: Array, Cy: Array) -> tuple[Array, Array, Array]:
    """H, the first entry of b, all others of which are zero, and C, in the coordinates in which A is a Hessenberg H."""
    H, C, n = A.copy(), Cy.copy(), b.shape[1]
    size = np.empty(len(b))
    for k in range(n):
        v = (b if k == 0 else H[:, k:, k - 1]).copy()  # is turned to the axis k
        length = np.linalg.norm(v, axis=1) * np.where(v[:, 0] > 0, -1.0, 1.0)
        if k == 0:
            size = length
        v[:, 0] -= length
        v /= np.maximum(np.linalg.norm(v, axis=1), np.finfo(float).tiny)[:, np.newaxis]
        row, column = v[:, np.newaxis], 2 * v[:, :, np.newaxis]
        H[:, k:] -= column @ (row @ H[:, k:])
        for M in (H, C):
            M[:, :, k:] -= (M[:, :, k:] @ column) @ row
    return H, size, C


def _pivoted(A: Array, b: Array, Cy: Array, s: Complex) -> Complex:
    """C (s I - A)^-1 b of one row, (ny, m), by elimination with pivots; NaN at a pole."""
    values = np.full((len(Cy), len(s)), np.nan, complex)
    for k, point in enumerate(s):
        try:
            values[:, k] = Cy @ np.linalg.solve(point * np.eye(len(A)) - A, b)
        except np.linalg.LinAlgError:
            continue
    return values
