"""Steps of a filter on square roots of covariances, P = S S', by orthogonal transformations (array algorithms).

No covariance is ever subtracted from another, so that S S' cannot lose its definiteness.
Kailath, Sayed and Hassibi (2000), Linear Estimation, chapter 12; for smoothers Park and Kailath (1996), IEEE TAC 41(5).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dgeqrf, dtrtrs

from workbench.core.validation.refusals import Array

EPS = float(np.finfo(float).eps)


@lru_cache(maxsize=64)
def _upper(n: int) -> Array:
    return np.triu(np.ones((n, n)))


def triangle(rows: Array) -> Array:
    """R (n, n), upper triangular with R' R = rows' rows, of rows (m, n), m >= n; they are overwritten."""
    n: int = rows.shape[1]
    R: Array = dgeqrf(rows, overwrite_a=True)[0][:n] * _upper(n)
    return R


class Correction(NamedTuple):
    """The correction by a sample: x+ = x + whitened gains, whitened = root^-T innovation, P+ = S S'."""

    root: Array  # (q, q), upper triangular: the covariance of the innovation is root' root
    gains: Array  # (q, n)
    S: Array  # (n, n)

    def whiten(self, innovation: Array) -> Array:
        """An innovation (q,) over its root, white with covariance I if the model is right."""
        if len(innovation) == 1:
            return np.asarray(innovation / self.root[0])
        whitened: Array = dtrtrs(self.root, innovation, trans=1)[0]
        return whitened


def correction(roots: Array, readings: Array, noise: Array) -> Correction:
    """The correction by a sample of q sensors.

        [ readings'  roots' ]           [ root  gains ]
        [ noise'     0      ]  = Theta  [ 0     S'    ]

    `roots` (n, m) has P = roots roots', `readings` (q, m) is H roots, and `noise` (q, q) is the square root of R. The
    large rows come first: then Householder's reflections are accurate row by row (Powell and Reid 1969).
    """
    q = len(readings)
    n, m = roots.shape
    rows = np.zeros((m + q, q + n), order="F")
    rows[:m, :q], rows[:m, q:], rows[m:, :q] = readings.T, roots.T, noise.T
    R = triangle(rows)
    return Correction(R[:q, :q], R[:q, q:], R[q:, q:].T)


def predict(spread: Array, noise: Array) -> Array:
    """S (n, n) with S S' = spread spread' + noise noise', from matrices with n rows."""
    n, m = spread.shape
    rows = np.empty((m + noise.shape[1], n), order="F")
    rows[:m], rows[m:] = spread.T, noise.T
    return triangle(rows if len(rows) >= n else np.vstack([rows, np.zeros((n - len(rows), n))])).T


def square_root(P: Array) -> Array:
    """L (n, n) with L L' = P, of a positive semidefinite matrix."""
    scale = np.sqrt(np.maximum(np.diag(P), 0.0))
    scale[scale == 0] = 1.0
    values, vectors = np.linalg.eigh(P / scale[:, None] / scale)
    try:
        return np.asarray(scale[:, None] * np.linalg.cholesky(P / scale[:, None] / scale))
    except np.linalg.LinAlgError:  # a matrix without an inverse
        return np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


class BackwardSteps(NamedTuple):
    """Steps from a sample to the one before: x_k = x + G (x_(k+1) - x_pred), and the root of its own covariance."""

    G: Array  # (N - 1, n, n)
    S: Array  # (N - 1, n, n), of x_k if x_(k+1) were known


def backward_steps(spread: Array, noise: Array, roots: Array) -> BackwardSteps:
    """All steps backward at once, by

        [ spread'  roots' ]           [ S_pred'  g' ]
        [ noise'   0      ]  = Theta  [ 0        S' ],    G = g S_pred^-1

    with spread (N - 1, n, m), such as F S, noise (N - 1, n, l), and the roots (N - 1, n, m) before the prediction.
    """
    N, n, m = spread.shape
    rows = np.zeros((N, max(m + noise.shape[2], 2 * n), 2 * n))
    rows[:, :m, :n], rows[:, :m, n:] = np.swapaxes(spread, 1, 2), np.swapaxes(roots, 1, 2)
    rows[:, m : m + noise.shape[2], :n] = np.swapaxes(noise, 1, 2)
    R = np.asarray(np.linalg.qr(rows, mode="r"), dtype=float)
    return BackwardSteps(_gains(R[:, :n, :n], R[:, :n, n:]), np.swapaxes(R[:, n:, n:], 1, 2))


def _gains(R: Array, right: Array) -> Array:
    """G' = R^-1 right for upper triangular R; where R has no inverse, the least solution."""
    G = np.empty_like(right)
    columns = np.linalg.norm(R, axis=1)
    diagonal = np.abs(np.diagonal(R, axis1=1, axis2=2))
    singular = (diagonal <= 8 * R.shape[1] * EPS * columns).any(axis=1)
    G[~singular] = np.linalg.solve(R[~singular], right[~singular])
    for k in np.flatnonzero(singular):
        scale = np.where(columns[k] > 0, columns[k], 1.0)
        G[k] = np.linalg.lstsq(R[k] / scale, right[k], rcond=8 * R.shape[1] * EPS)[0] / scale[:, None]
    return np.swapaxes(G, 1, 2)


def definiteness(roots: Array) -> float:
    """The least eigenvalue of all the correlation matrices of covariances S S', for roots (N, n, n); 1 if none exists.

    It is a square of a singular value of S, and so it is never negative.
    """
    lengths = np.linalg.norm(roots, axis=2, keepdims=True)
    if not roots.size:
        return 1.0
    if not lengths.all():
        return 0.0
    return float(np.linalg.svd(roots / lengths, compute_uv=False)[:, -1].min() ** 2)
