"""Where switchings accumulate, or a surface is reached with no speed: sliding with sigma = d sigma / dt = 0."""

from __future__ import annotations

import numpy as np

from workbench.reference.modes import Modes, determined
from workbench.reference.pieces import ROUNDING, Mode, Piece
from workbench.reference.variable_step import Leg, Rule
from workbench.validation.refusals import Array

CONTRACTS = 0.98  # the share by which the gap between switchings shrinks, from one to the next but one
# Gaps in units of the time. The way between two switchings takes steps down to a millionth of it, and a step a
# hundred units of rounding; what is neglected by not following them any more is of the order of the gap's square.
FINE, FINEST = 1e-6, 1e-8


class Streak:
    """Crossings that follow each other, and whether their instants run into one."""

    def __init__(self, modes: Modes) -> None:
        self.modes = modes
        self.clear()

    def clear(self) -> None:
        """Forget them."""
        self.instants: list[float] = []
        self.surfaces: list[int] = []
        self.share = 1.0

    def after(self, before: Piece, piece: Piece, leg: Leg, ahead: Array) -> tuple[Piece, float, Array] | None:
        """Note a switching; where its like accumulate: the piece, time and state after all of them.

        While they do, the absolute tolerance is to be multiplied by `share`. `ahead` are the times still asked for.

        Raises
        ------
        ValueError
            If they accumulate and no sliding motion of second order follows.
        """
        assert leg.hit is not None
        k = leg.hit.surface
        if not self.modes.switched.surfaces[k].jumps:
            return None
        if leg.hit.kind != "cross" or 0 in (before.mode.sides[k], piece.mode.sides[k]):
            self.clear()
            return None
        self.instants.append(leg.t)
        self.surfaces.append(k)
        gaps = np.diff(self.instants[-6:])
        if len(gaps) < 4 or not (gaps[2:] < CONTRACTS * gaps[:-2]).all():
            self.share = 1.0
            return None
        # a phase is the last one, shrunk: near x = 0 an acceleration moves as far as the square of the gap
        self.share = float((gaps[-1] / np.diff(self.instants).max()) ** 2)
        ratio = gaps[-1] / gaps[-3]
        left = float((gaps[-1] + gaps[-2]) * ratio / (1 - ratio))
        asked = bool(((ahead > leg.t) & (ahead < leg.t + left)).any())
        if gaps[-1] > (FINEST if asked else FINE) * leg.t:
            return None
        end = _settled(self.modes, piece, leg.t, leg.x, left, set(self.surfaces[-4:]))
        if isinstance(end, str):
            names = ", ".join(self.modes.switched.surfaces[k].name for k in sorted(set(self.surfaces[-4:])))
            raise ValueError(
                f"`reference(ode=...)` stops at t = {leg.t + left:.12g} s, where the switchings of {names} "
                f"accumulate and no sliding motion of second order continues: {end}."
            )
        self.clear()
        return end[0], leg.t + left, end[1]


def stalled(modes: Modes, piece: Piece, t: float, x: Array, rule: Rule) -> tuple[Piece, Array] | None:
    """Where a surface is reached with no speed: the sliding motion there and its state; else None."""
    reach = FINE * t / ROUNDING
    near = {
        guard.surface
        for guard, (value, _, _, speed) in zip(piece.guards, piece.watch(t, x), strict=True)
        if guard.kind == "cross" and modes.switched.surfaces[guard.surface].jumps and value <= reach * speed
    }
    end = _settled(modes, piece, t, x, 0.0, near) if near else "no surface is near"
    if isinstance(end, str) or not end[0].second_order:
        return None
    following, there = end
    motion = np.abs(piece.field(t, piece.with_companions(t, x)).ravel()[: len(x)])
    motion = motion + np.abs(following.drive(t, there)).sum(axis=1)
    close = np.abs(there - x) <= rule.atol + rule.rtol * np.abs(x) + FINE * t * motion
    return (following, there) if close.all() else None


def _settled(modes: Modes, piece: Piece, t: float, x: Array, left: float, on: set[int]) -> tuple[Piece, Array] | str:
    """The piece with sigma and its first derivative zero on the surfaces `on`, and its state after a time `left`."""
    sides = tuple(0 if k in on else side for k, side in enumerate(piece.mode.sides))
    following = modes.piece(Mode(sides, piece.mode.levels))
    if isinstance(following, str):
        return following
    x = x + left * following.field(t, following.with_companions(t, x)).ravel()[: len(x)]
    x = x + following.settle(t + left, x).ravel()
    for _ in range(3):
        held = following.hold(t + left, x)
        x = x - np.linalg.pinv(held[:, 1:-1]) @ held[:, 0]
    control = following.control(t + left, x)
    if not determined(control[:, 1:]):
        return "the sides that would hold it there are not determined"
    if not (np.abs(control[:, 0]) < 1).all():
        return "the sides that would hold it there are not between -1 and 1"
    return following, x
