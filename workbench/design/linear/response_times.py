"""Times at which the response of a continuous system is drawn, closer while its fast modes last, and exact values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.linalg import expm

from workbench.design.matrices import Complex
from workbench.validation.refusals import Array

TIMES = 1000  # of a response whose modes are all slow
MOST = 4000  # times of one length of step, of those that are shorter
STEPS = 40.0  # in a turn of a mode, or in 2 pi of its time constants
LASTS = 8.0  # time constants of a mode, after which nothing of it is seen
LEVELS = 40  # halvings of the longest step


def response_times(poles: Complex, end: float, count: int = TIMES, most: int = MOST) -> list[tuple[float, int]]:
    """The steps from zero to `end` [s] as pairs of a step and how often it is taken, the shortest ones first.

    The longest step makes `count` times. A mode that would have fewer than 40 steps in a turn has shorter ones, halved
    again and again, until it has decayed, but no more than `most` of each length.
    """
    longest, lasts = end / (count - 1), [0.0] * (LEVELS + 1)
    for pole in np.asarray(poles)[np.abs(poles) > 0].tolist():
        level = math.ceil(math.log2(max(1.0, longest * abs(pole) * STEPS / (2 * math.pi))))
        seen = end if pole.real >= 0 else min(end, LASTS / -pole.real)
        lasts[min(level, LEVELS)] = max(lasts[min(level, LEVELS)], seen)
    ends = [end]  # of the stretch of each level
    for level in range(1, LEVELS + 1):
        step = longest / 2**level
        pairs = math.ceil(min(max(lasts[level:]), most * step) / (2 * step) - 1e-9)
        ends.append(min(ends[-1], 2 * step * max(pairs, int(max(lasts[level:]) > 0))))
    stretches = [(longest / 2**k, a, b) for k, (b, a) in enumerate(pairwise([*ends, 0.0]))]
    return [(step, round((b - a) / step)) for step, a, b in reversed(stretches) if b > a]


def times_of(steps: Sequence[tuple[float, int]]) -> Array:
    """The times (N,) from zero on."""
    parts: list[Array] = [np.zeros(1)]
    start = 0.0
    for step, times in steps:
        parts.append(np.asarray(start + step * np.arange(1, times + 1), dtype=float))
        start = float(parts[-1][-1])
    return np.concatenate(parts)


def exact_responses(
    A: Array, B: Array, Cy: Array, D: Array, steps: Sequence[tuple[float, int]], impulse: bool = False
) -> Array:
    """The step or impulse responses (N, ..., ny, nu) of models (..., nx, nx), exact but for rounding.

    The state is carried on by the exponential of the matrix. An impulse response is without what passes at once.
    """
    nx, nu = B.shape[-2:]
    x = np.array(B) if impulse else np.zeros_like(B)
    drive = np.zeros_like(B) if impulse else B
    through = np.zeros_like(D) if impulse else D
    values = [Cy @ x + through]
    whole = np.zeros((*A.shape[:-2], nx + nu, nx + nu))
    whole[..., :nx, :nx], whole[..., :nx, nx:] = A, drive
    taken = steps[0][0]
    moved = expm(whole * taken)
    for step, times in steps:
        while taken < 0.75 * step:  # each step is twice the one before, or a higher power of two
            moved, taken = moved @ moved, 2 * taken
        Ad, Bd = moved[..., :nx, :nx], moved[..., :nx, nx:]
        for _ in range(times):
            x = Ad @ x + Bd
            values.append(Cy @ x + through)
    return np.asarray(values)
