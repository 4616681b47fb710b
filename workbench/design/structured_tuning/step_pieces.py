"""Overshoot, settling and rise time of a linear step response as pieces, by differences along exact derivatives."""

from __future__ import annotations

import math

import numpy as np
import scipy.linalg

from workbench.core.validation.refusals import Array
from workbench.design.structured_tuning.figure_pieces import FigurePiece
from workbench.design.structured_tuning.system_jets import SystemJet

SAMPLES, CONSTANTS, LONGEST = 1500, 10.0, 6000  # of a response, its time constants, and periods in a computer
BAND, LEVELS = 0.02, (0.1, 0.9)
STEP = 1e-6  # of a difference, relative to the change of the matrices


def step_piece(jet: SystemJet, name: str, limit: float) -> FigurePiece:
    """The excess of a figure of the step response of one channel over its limit, with its gradient (d,).

    That of an overshoot in % is (overshoot - limit) / (10 + limit), that of a time the logarithm of their ratio.
    """
    d, size = len(jet.slopes), float(np.abs(jet.M).max())
    steps = STEP * size / np.maximum(np.abs(jet.slopes).max(axis=(1, 2)), 1e-300)
    moves = steps[:, np.newaxis, np.newaxis] * jet.slopes
    matrices = np.concatenate([jet.M[np.newaxis], jet.M + moves, jet.M - moves])
    t, shares = _responses(jet, matrices)
    values = np.array([_excess(t, share, name, limit, jet.period is not None) for share in shares])
    return FigurePiece(float(values[0]), np.asarray((values[1 : d + 1] - values[d + 1 :]) / (2 * steps)))


def _excess(t: Array, share: Array, name: str, limit: float, sampled: bool) -> float:
    if name == "overshoot":
        peak = int(share.argmax())
        top = float(share[peak]) if sampled else _top(share, peak)
        return (100 * (top - 1) - limit) / (10 + limit)
    if name == "rise_time":
        low, high = (_first_above(t, share, level) for level in LEVELS)
        return math.log(max(high - low, 1e-300) / limit)
    outside = np.flatnonzero(np.abs(share - 1) > BAND)
    if not outside.size:
        return math.log(max(t[1], 1e-300) / limit)
    k = min(int(outside[-1]), len(t) - 2)
    a, b = abs(share[k] - 1) - BAND, abs(share[k + 1] - 1) - BAND
    return math.log((t[k] + (t[k + 1] - t[k]) * a / (a - b)) / limit)


def _responses(jet: SystemJet, matrices: Array) -> tuple[Array, Array]:
    """Times (m,), the same for all, and the step responses (N, m) of systems [A b; c d] over their final values."""
    h, count = _grid(jet)
    N, n = len(matrices), jet.n
    A, B, C, D = matrices[:, :n, :n], matrices[:, :n, n:], matrices[:, n:, :n], matrices[:, n, n]
    whole = np.zeros((N, n + 1, n + 1))
    whole[:, :n, :n], whole[:, :n, n:] = A, B
    stable = A if jet.period is None else A - np.eye(n)
    if jet.period is None:
        whole = scipy.linalg.expm(whole * h)
    else:
        whole[:, n, n] = 1.0
    final = D - (C @ np.linalg.solve(stable, B))[:, 0, 0]
    states = np.zeros((N, n + 1, 1))
    states[:, n] = 1.0
    while states.shape[2] <= count:  # the states that follow a block are the block, moved on by its length
        states, whole = np.concatenate([states, whole @ states], axis=2), whole @ whole
    y = (C @ states[:, :n, : count + 1])[:, 0] + D[:, np.newaxis]
    return np.asarray(h * np.arange(count + 1)), np.asarray(y / final[:, np.newaxis])


def _grid(jet: SystemJet) -> tuple[float, int]:
    """The step in s, and the number of the samples."""
    poles = np.linalg.eigvals(jet.A)
    decays = -poles.real if jet.period is None else -np.log(np.abs(poles) + 1e-300) / jet.period
    decay = float(decays.min(initial=np.inf))
    end = CONSTANTS / decay if 0 < decay < math.inf else 1.0
    if jet.period is None:
        return end / SAMPLES, SAMPLES
    return jet.period, int(min(end / jet.period + 10, LONGEST))


def _top(share: Array, k: int) -> float:
    """The height of the parabola through a largest sample and its neighbours."""
    if not 0 < k < len(share) - 1:
        return float(share[k])
    a, b, c = share[k - 1], share[k], share[k + 1]
    bend = a - 2 * b + c
    return float(b - (a - c) ** 2 / (8 * bend)) if bend < 0 else float(b)


def _first_above(t: Array, share: Array, level: float) -> float:
    k = max(int((share >= level).argmax()), 1)
    return float(t[k - 1] + (t[k] - t[k - 1]) * (level - share[k - 1]) / (share[k] - share[k - 1]))
