"""Autocovariances of innovations as the start of a search for noise covariances: they are linear in Q and R.

For x+ = A x + w, y = C x + v and a filter of constant gain K, the error of the predicted state moves by
F = A - A K C, and the innovations have, with P = F P F' + Q + A K R K' A',

    C_0 = C P C' + R,        C_j = C F^j P C' - C F^(j-1) A K R,   j = 1, 2, ...

Any gain serves, so that a poor Q and R do not spoil the answer (Odelson, Rajamani and Rawlings 2006).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import nnls

from workbench.core.validation.refusals import Array
from workbench.identification.filters.filter_estimate import FilterEstimate

LAGS, LEAST = 15, 40  # autocovariances, and the innovations that they need at least
SETTLED = 1e-3  # relative change of the predicted covariance, below which the gain is constant
STABLE = 1 - 1e-6  # the largest absolute eigenvalue of F
FLOOR = 1e-6  # of the innovations' variance: the share that a number with the estimate 0 explains at the start
MOST_STATES = 40  # whose Lyapunov equations are solved as one linear system


def autocovariance_numbers(
    estimates: Sequence[FilterEstimate], R: Array, parts: Sequence[tuple[Array, Array]]
) -> Array | None:
    """The numbers (m,) by which m parts of (Q, R) are multiplied, by least squares with none below 0.

    `estimates` are of filters with constant matrices and sensors of covariance R (q, q). None if the filters are
    others, or have too few samples with a constant gain.

    References
    ----------
    Odelson, Rajamani and Rawlings (2006), A new autocovariance least-squares method for estimating noise covariances,
    Automatica 42(2), 303-308, equations 7 to 13.
    """
    found = [one for one in map(_settled, estimates) if one is not None]
    if len(found) < len(estimates):
        return None
    A, C, P = _matrices(estimates[0])
    S = C @ P @ C.T + R
    K = A @ np.linalg.solve(S, C @ P).T
    F = A - K @ C
    if np.abs(np.linalg.eigvals(F)).max() > STABLE:
        return None
    scale = 1 / np.sqrt(np.maximum(np.mean(np.concatenate(found) ** 2, axis=0), 1e-300))
    lags = min(LAGS, *(len(part) // 4 for part in found))
    sums = [len(part) * _autocovariances(part * scale, lags) for part in found]
    target: Array = np.sum(sums, axis=0) / sum(map(len, found))
    columns = [_model(F, C, K, Q, R_part, lags) * np.outer(scale, scale) for Q, R_part in parts]
    matrix = np.column_stack([column.ravel() for column in columns])
    sizes = np.linalg.norm(matrix, axis=0)
    if not np.isfinite(matrix).all() or not sizes.all():
        return None
    shares = nnls(matrix / sizes, target.ravel())[0]
    return np.asarray(np.maximum(shares, FLOOR) / sizes)


def _matrices(estimate: FilterEstimate) -> tuple[Array, Array, Array]:
    """A, C and the last predicted covariance."""
    readings = estimate.moves.readings
    assert readings is not None
    return estimate.moves.transitions[0], readings[0], estimate.P_predicted[-1]


def _settled(estimate: FilterEstimate) -> Array | None:
    """The innovations (N, q) of a filter with constant matrices from where its gain is constant; None if too few."""
    moves = estimate.moves
    if moves.readings is None or len(moves.transitions) < LEAST or estimate.x.shape[1] > MOST_STATES:
        return None
    if any(part.strides[0] for part in (moves.transitions, moves.readings, moves.noises)):
        return None
    P = estimate.P_predicted
    if not np.isfinite(P).all() or not np.isfinite(estimate.innovations).all():
        return None
    off = np.abs(P - P[-1]).max(axis=(1, 2)) > SETTLED * np.abs(P[-1]).max()
    first = int(np.flatnonzero(off)[-1]) + 1 if off.any() else 0
    e = estimate.innovations[first:]
    return e if len(e) >= LEAST else None


def _autocovariances(e: Array, lags: int) -> Array:
    """The sample autocovariances (lags, q, q) of innovations (N, q): the mean of e_{k+j} e_k'."""
    return np.array([e[j:].T @ e[: len(e) - j] / (len(e) - j) for j in range(lags)])


def _model(F: Array, C: Array, K: Array, Q: Array, R: Array, lags: int) -> Array:
    """The autocovariances (lags, q, q) of innovations that Q and R give; K is A times the gain."""
    n = len(F)
    added = Q + K @ R @ K.T
    P = np.linalg.solve(np.eye(n * n) - np.kron(F, F), added.ravel()).reshape(n, n)
    made, moved = [C @ P @ C.T + R], F @ P @ C.T - K @ R
    for _ in range(1, lags):
        made.append(C @ moved)
        moved = F @ moved
    return np.array(made)
