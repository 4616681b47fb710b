"""Small convex quadratic programs by an interior-point method, and the step that a bundle of pieces gives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from workbench.core.validation.refusals import Array
from workbench.design.structured_tuning.figure_pieces import FigurePiece

ROUNDS = 40
ACCURACY = 1e-10  # relative, of the residuals and of the gap between both objectives
TO_BOUNDARY = 0.995  # of the longest step that keeps slacks and multipliers positive
SHARE = 0.01  # of the residual, below which the products of slacks and multipliers do not go
TINY = 1e-14  # relative, added to the diagonal of a matrix that may be singular


def solve_quadratic_program(P: Array, q: Array, G: Array, h: Array) -> tuple[Array, Array]:
    """The z that makes z'Pz / 2 + q'z smallest under G z <= h, and the multipliers of the rows of G.

    References
    ----------
    Mehrotra (1992), On the implementation of a primal-dual interior point method, SIAM Journal on Optimization 2.
    """
    n, m = len(q), len(h)
    z = np.zeros(n)
    s = np.maximum(h - G @ z, 1.0)
    y = np.ones(m)
    scale = 1 + max(np.abs(q).max(initial=0.0), np.abs(h).max(initial=0.0))
    for _ in range(ROUNDS):
        dual, primal, gap = P @ z + q + G.T @ y, G @ z + s - h, float(s @ y) / m
        if max(np.abs(dual).max(), np.abs(primal).max(), gap) <= ACCURACY * scale:
            break
        weights = y / s
        K = P + G.T @ (weights[:, np.newaxis] * G)
        K[np.diag_indices(n)] += TINY * (1 + np.abs(np.diag(K)))
        try:
            factor = scipy.linalg.cho_factor(K)
        except np.linalg.LinAlgError:
            break
        _, ds, dy = _newton(factor, G, s, y, dual, primal, s * y)
        length = min(1.0, _longest(s, ds), _longest(y, dy))
        centring = min(1.0, max(0.0, float((s + length * ds) @ (y + length * dy)) / m / gap)) ** 3
        target = max(centring * gap, SHARE * float(np.abs(dual).max()))  # or the products vanish before the residual
        dz, ds, dy = _newton(factor, G, s, y, dual, primal, s * y + ds * dy - target)
        length = min(1.0, TO_BOUNDARY * min(_longest(s, ds), _longest(y, dy)))
        if not np.isfinite(length * dz).all():
            break
        z, s, y = z + length * dz, s + length * ds, y + length * dy
    return z, y


def _newton(
    factor: tuple[Array, bool], G: Array, s: Array, y: Array, dual: Array, primal: Array, complement: Array
) -> tuple[Array, Array, Array]:
    right = -dual + G.T @ ((complement - y * primal) / s)
    dz = scipy.linalg.cho_solve(factor, right)
    ds = -primal - G @ dz
    return dz, ds, (-complement - y * ds) / s


def _longest(value: Array, change: Array) -> float:
    falling = change < 0
    return float((-value[falling] / change[falling]).min(initial=1 / TO_BOUNDARY))


@dataclass(frozen=True, eq=False)
class BundleStep:
    """The step d (nd,) of a bundle, the decrease that it promises, and the multipliers of soft and hard pieces."""

    step: Array
    decrease: float
    soft: Array
    hard: Array


def bundle_step(
    soft: Sequence[FigurePiece],
    hard: Sequence[FigurePiece],
    penalty: float,
    H: Array,
    low: Array,
    high: Array,
) -> BundleStep:
    """The step that makes max soft + penalty max(0, hard) + d'Hd / 2 smallest, for pieces that are linear in d.

    `low` and `high` (nd,) bound d. The merit is `penalty` times the largest violation where no soft piece is given.
    """
    d = len(low)
    a, b = _rows(soft, d), _rows(hard, d)
    top = max((one.value for one in soft), default=0.0)
    worst = max((one.value for one in hard), default=0.0)
    G = np.block(
        [
            [a[0], -np.ones((len(soft), 1)), np.zeros((len(soft), 1))],
            [b[0], np.zeros((len(hard), 1)), -np.ones((len(hard), 1))],
            [np.zeros((1, d + 1)), -np.ones((1, 1))],
            [np.eye(d), np.zeros((d, 2))],
            [-np.eye(d), np.zeros((d, 2))],
        ]
    )
    h = np.concatenate([top - a[1], -b[1], [0.0], high, -low])
    q = np.concatenate([np.zeros(d), [1.0 if soft else 0.0, penalty]])
    P = np.zeros((d + 2, d + 2))
    P[:d, :d] = H
    if not soft:
        P[d, d] = 1.0
    z, y = solve_quadratic_program(P, q, G, h)
    step = np.clip(z[:d], low, high)
    before = (top if soft else 0.0) + penalty * max(0.0, worst)
    after = max((one.value + float(one.gradient @ step) for one in soft), default=0.0)
    after += penalty * max(0.0, max((one.value + float(one.gradient @ step) for one in hard), default=0.0))
    return BundleStep(step, before - after, y[: len(soft)], y[len(soft) : len(soft) + len(hard)])


def _rows(pieces: Sequence[FigurePiece], d: int) -> tuple[Array, Array]:
    if not pieces:
        return np.zeros((0, d)), np.zeros(0)
    return np.array([one.gradient for one in pieces]), np.array([one.value for one in pieces])
