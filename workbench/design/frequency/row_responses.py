"""Frequency answers of many linear systems at once, with the error of each; hard points are solved one by one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import matrix_balance

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, numbers, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.response_kernel import FrequencyAnswers, adjoint_answers, row_answers
from workbench.design.frequency.sampled_loop_inputs import band
from workbench.design.matrices import EPS, Complex, one_thread

Mask = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
TARGET_ERROR = 1e-12  # relative error beyond which an answer is looked at again
SINGULAR = 0.1  # relative change of a solution by its own residual, from which no digit of it is known
POINTS = 2048  # at once, that are looked at again


@dataclass(frozen=True, eq=False)
@show
class RowResponses:
    """The responses `values` (N, m, ny, nu) of N systems at `frequencies` (m,) in rad/s; NaN where a row is flagged.

    `errors` bound, to first order, how far rounding may have moved each of the `values`, for the matrices as given.
    `sensitivities` are the changes of the values over the relative changes of all entries of the matrices.
    `flagged_rows` (N,) is True for rows with an entry that is not finite, and for rows with a pole at one of the
    frequencies.
    """

    frequencies: Array
    values: Complex
    flagged_rows: Mask
    errors: Array
    sensitivities: Array

    @property
    def conditions(self) -> Array:
        """The condition number of each answer: its relative change, over the relative changes of the entries.

        If the entries are rounded to doubles, the answer moves by about 1e-16 times this number, whatever the
        algorithm.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(self.sensitivities == 0, 0.0, self.sensitivities / np.abs(self.values)))


@check_arguments
def row_responses(
    A: Array, B: Array, Cy: Array, D: Array, frequencies: Array, period: float | None = None
) -> RowResponses:
    """C (s I - A)^-1 B + D of each row at s = j w, or at z = e^(j w h) for systems with the period h.

    Parameters
    ----------
    A, B, Cy, D
        (N, nx, nx), (N, nx, nu), (N, ny, nx) and (N, ny, nu); states, inputs and outputs are the same in all rows.
    frequencies
        (m,) in rad/s, in rising order from zero; with a period up to Nyquist's.
    period
        The period h of sampled systems in s; None for systems in continuous time.

    Raises
    ------
    ValueError
        If the shapes do not fit, or the frequencies are none, fall, are negative or above Nyquist's.

    References
    ----------
    See `response_program` for the solution, and `dual_answers` for the answer and its error.
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
    flagged = ~np.all([np.isfinite(M.reshape(N, -1)).all(axis=1) for M in (A, B, Cy, D)], axis=0)
    sound = np.flatnonzero(~flagged)
    if len(sound) and ny and nu:
        matrices = _balance(A[sound], B[sound], Cy[sound], D[sound])
        found = row_answers(*matrices, s)
        flagged[sound] = _look_again(*matrices, s, found)
        if len(sound) == N:
            return RowResponses(omega, found.values, flagged, found.errors, found.sensitivities)
    made = FrequencyAnswers(*(np.full((N, len(s), ny, nu), np.nan, kind) for kind in (complex, float, float)))
    if len(sound) and ny and nu:
        made.values[sound], made.errors[sound] = found.values, found.errors
        made.sensitivities[sound] = found.sensitivities
    return RowResponses(omega, made.values, flagged, made.errors, made.sensitivities)


def _balance(A: Array, B: Array, Cy: Array, D: Array) -> tuple[Array, Array, Array, Array]:
    """The same systems in units of the states, powers of two, in which the largest entries of A are balanced."""
    if not A.shape[1]:  # a state that nothing moves and nothing reads takes the place of none
        N, nu, ny = len(B), B.shape[2], Cy.shape[1]
        return -np.ones((N, 1, 1)), np.zeros((N, 1, nu)), np.zeros((N, ny, 1)), D
    with np.errstate(invalid="ignore"):  # of a scale beyond 2^63, which SciPy takes for a place in vain
        scale = matrix_balance(np.abs(A).max(axis=0), permute=False, separate=True)[1][0]
    return A * scale / scale[:, np.newaxis], B / scale[:, np.newaxis], Cy * scale, D


def _look_again(A: Array, B: Array, Cy: Array, D: Array, s: Complex, answers: FrequencyAnswers) -> Mask:
    """Solve anew, by elimination with pivots, the points whose error is larger than rounding must make it.

    A point at which the equations are singular, as far as rounding can tell, is a pole: its answers become NaN, and
    the mask (N,) of rows is true.
    """
    poles = np.zeros(len(A), dtype=bool)
    with np.errstate(invalid="ignore"):
        size = np.maximum(
            np.abs(answers.values.real), np.abs(answers.values.imag)
        )  # a modulus would take twice the time
        doubtful = ~(answers.errors < TARGET_ERROR * size)  # zeros are seen to below
    if not doubtful.any():
        return poles
    rows, places = np.nonzero(doubtful.any(axis=(2, 3)))
    error, moved, size = (M[rows, places] for M in (answers.errors, EPS * answers.sensitivities, size))
    fine = (error <= TARGET_ERROR * size) | ((error <= moved) & (moved <= 1e-3 * size))
    again = ~(fine & np.isfinite(error)).all(axis=(1, 2))
    rows, places = rows[again], places[again]
    for start in range(0, len(rows), POINTS):
        i, k = rows[start : start + POINTS], places[start : start + POINTS]
        M = s[k, np.newaxis, np.newaxis] * np.eye(A.shape[1]) - A[i]
        with one_thread(), np.errstate(all="ignore"):
            x, sure = _solve_rows(M, B[i])
            y, also = _solve_rows(M.swapaxes(1, 2), Cy[i].swapaxes(1, 2))
            new = adjoint_answers(A[i], B[i], Cy[i], D[i], s[k], x, y)
        pole = ~(sure & also)[:, np.newaxis, np.newaxis]
        better = pole | ~(answers.errors[i, k] <= new.errors)
        for old, own in (
            (answers.values, new.values),
            (answers.errors, new.errors),
            (answers.sensitivities, new.sensitivities),
        ):
            old[i, k] = np.where(pole, np.nan, np.where(better, own, old[i, k]))
        poles[i[~np.isfinite(answers.values[i, k]).all(axis=(1, 2))]] = True
    return poles


def _solve_rows(M: Complex, right: Array) -> tuple[Complex, Mask]:
    """The solutions of some systems after a step of refinement, and the mask of those that are known at all."""
    x, change = (np.full((len(M), *right.shape[1:]), np.nan, complex) for _ in range(2))
    for i, (own, b) in enumerate(zip(M, right, strict=True)):
        try:
            x[i] = np.linalg.solve(own, b)
            change[i] = np.linalg.solve(own, b - own @ x[i])
        except np.linalg.LinAlgError:
            continue
    sizes = (np.abs(part).reshape(len(M), -1).max(axis=1, initial=0.0) for part in (change, x))
    moved, size = sizes
    return x + change, np.asarray((moved <= SINGULAR * size) & np.isfinite(size))
