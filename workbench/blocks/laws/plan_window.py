"""The signals of a planned reference by a loop over its pieces, which are written once in place of each by itself."""

from __future__ import annotations

import casadi as ca

from workbench.blocks.signals.planned_reference import PlannedReference
from workbench.blocks.signals.signal import clock
from workbench.core.bounded_loop import bounded_loop


def planned_signals(reference: PlannedReference, t: ca.SX) -> ca.SX:
    """The signals of a planned reference at time t [s], (n, 1), with the bits of its own formula."""
    pieces = reference.pieces
    now = ca.SX(clock(t))

    def choose(chosen: ca.SX, piece: ca.SX, now: ca.SX) -> tuple[ca.SX, ...]:
        return (ca.if_else(now >= piece[0], piece, chosen),)

    (chosen,) = bounded_loop(len(pieces), choose, ca.SX(ca.DM(pieces[0])), ca.SX(ca.DM(pieces.T)), constants=(now,))
    s, n = t - chosen[0], (len(pieces[0]) - 1) // 4
    a, b, c, d = ca.vertsplit(chosen[1:], n)
    return a + s * (b + s * (c + s * d))
