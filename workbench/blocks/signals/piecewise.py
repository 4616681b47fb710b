"""Cubic polynomials over time, piece by piece, as expressions."""

from __future__ import annotations

import casadi as ca

from workbench.blocks.signals.signal import Motion, clock
from workbench.core.block import Number
from workbench.core.validation.refusals import Array

MOST_PIECES = 2000  # each is a comparison at each evaluation, and a part of what is compiled


def piecewise_motion(t: Number, pieces: Array) -> Motion:
    """The value of n signals at time t [s] with its first and second derivatives, each (n, 1).

    `pieces` (m, 1 + 4 n) has of each piece its begin in s and the coefficients of 1, s, s^2 and s^3, s being the time
    since the begin.
    """
    n = (pieces.shape[1] - 1) // 4
    chosen = ca.SX(pieces[0])
    for row in pieces[1:]:
        chosen = ca.if_else(clock(t) >= row[0], ca.SX(row), chosen)
    s = t - chosen[0]
    a, b, c, d = ca.vertsplit(chosen[1:], n)
    return a + s * (b + s * (c + s * d)), b + s * (2 * c + s * 3 * d), 2 * c + 6 * d * s
