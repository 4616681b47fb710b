"""One solution of a switched equation, piece by piece: crossing, sliding, leaving, and where switchings accumulate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.engine.reference.continuation import Modes, is_determined, next_mode, stop
from workbench.engine.reference.smooth_pieces import ROUNDING, SmoothPiece, SwitchingMode
from workbench.engine.reference.variable_step import (
    SHORTEST,
    Effort,
    Flow,
    IntegrationError,
    Leg,
    SolverOptions,
    travel,
)

CONTRACTS = 0.98  # the share by which the gap between switchings shrinks, from one to the next but one
# Gaps in units of the time. The way between two switchings takes steps down to a millionth of it, and a step a
# hundred units of rounding; what is neglected by not following them any more is of the order of the gap's square.
FINE, FINEST = 1e-6, 1e-8


@dataclass(frozen=True)
class Event:
    """A crossing of a switching surface, or the begin or end of sliding on it.

    It "crosses", "slides" (sliding begins), "leaves" (sliding ends), or "settles" (sliding begins with sigma = d sigma
    / dt = 0, after switchings that accumulate or after none).
    """

    t: float  # s
    surface: str  # the switching function sigma
    what: str
    rate: float  # 1/s, d sigma / dt on arrival; for "leaves" the rate at which the side passes 1 or -1


@dataclass(frozen=True, eq=False)
class SwitchedRun:
    """States (N, nx) at the times asked for, the events on the way, and the cost."""

    states: Array
    events: tuple[Event, ...]
    sliding_spans: tuple[tuple[float, float, tuple[str, ...]], ...]
    effort: Effort


class Streak:
    """Consecutive crossings of surfaces, watched for instants that accumulate at one time."""

    def __init__(self, modes: Modes) -> None:
        self.modes = modes
        self.clear()

    def clear(self) -> None:
        """Forget the crossings."""
        self.instants: list[float] = []
        self.surfaces: list[int] = []
        self.share = 1.0

    def after(
        self, before: SmoothPiece, piece: SmoothPiece, leg: Leg, ahead: Array
    ) -> tuple[SmoothPiece, float, Array] | None:
        """Note a crossing; if crossings accumulate, return the piece, the time and the state after all of them.

        While they do, the absolute tolerance is to be multiplied by `share`. `ahead` are the times still asked for. If
        no sliding motion of second order follows, a ValueError says so.
        """
        assert leg.guard is not None
        k = leg.guard.surface
        if not self.modes.switched_rate.surfaces[k].jumps:
            return None
        if leg.guard.kind != "cross" or 0 in (before.mode.sides[k], piece.mode.sides[k]):
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
        end = _settle_on(self.modes, piece, leg.t, leg.x, left, set(self.surfaces[-4:]))
        if isinstance(end, str):
            names = self.modes.switched_rate.names(set(self.surfaces[-4:]))
            why = f"the switchings of {names} accumulate and no sliding motion of second order continues: {end}"
            raise stop(leg.t + left, why)
        self.clear()
        return end[0], leg.t + left, end[1]


def follow(
    modes: Modes, valid: Callable[[float, Array], bool], x: Array, times: Array, rule: SolverOptions
) -> SwitchedRun:
    """The solution from x at time 0, at increasing `times`; a `StoppedError` where it does not continue numerically."""
    t, effort, events, slid, streak = (
        0.0,
        Effort(),
        list[Event](),
        list[tuple[float, float, SwitchingMode]](),
        Streak(modes),
    )
    kept, still = [x] if times[0] == 0 else [], 0
    piece = modes.start(t, x)
    while len(kept) < len(times):
        tighter = replace(rule, atol=rule.atol * streak.share)
        leg = travel(Flow.of(piece, valid), t, x, times[-1], times[len(kept) :], tighter, effort)
        kept.extend(leg.states)
        if piece.mode.sliding_surfaces:
            slid.append((t, leg.t, piece.mode))
        still = still + 1 if leg.t - t <= SHORTEST * times[-1] else 0
        t, x, before = leg.t, leg.x, piece
        if len(kept) == len(times):
            break
        piece, at_rest = _next(modes, before, leg, rule)
        if at_rest is not None:
            x = at_rest
            names = modes.switched_rate.names(set(piece.mode.sliding_surfaces) - set(before.mode.sliding_surfaces))
            events.append(Event(t, names, "settles", 0.0))
        elif leg.guard is not None and leg.guard.kind != "turn":
            events.append(_event(modes, before, piece, leg))
            if still > 3 * len(modes.switched_rate.surfaces):  # more than all of them at one instant
                why = "switches again and again: its first two derivatives do not tell to which side the state moves"
                raise stop(t, f"{events[-1].surface} {why}")
            after = streak.after(before, piece, leg, times[len(kept) :])
            if after is not None:
                piece, t, x = after
                kept.extend([x] * int(np.sum(times[len(kept) :] <= t)))
                events.append(replace(events[-1], t=t, what="settles", rate=0.0))
    return SwitchedRun(np.array(kept).reshape(len(times), -1), tuple(events), _join_spans(modes, slid), effort)


def _next(modes: Modes, piece: SmoothPiece, leg: Leg, rule: SolverOptions) -> tuple[SmoothPiece, Array | None]:
    """The piece after another has ended, and the state it is at rest in if it begins with sigma = d sigma / dt = 0."""
    if leg.guard is not None and leg.guard.kind == "turn":
        following = modes.piece(next_mode(piece.mode, leg.guard))
        assert isinstance(following, SmoothPiece)  # the same rate by another name
        return following, None
    refusal: Exception = IntegrationError(leg.t, leg.x, "step")
    if leg.guard is not None:
        rows = piece.watch(leg.t, leg.x)
        guards = [guard for guard, row in zip(piece.guards, rows, strict=True) if row[0] <= row[1]]
        near = {guard.surface for guard in guards if guard.kind == "cross"}
        try:
            return modes.onward(leg.t, leg.x, piece.mode, near | {leg.guard.surface}), None
        except ValueError as error:
            refusal = error
    end = start_of_sliding(modes, piece, leg.t, leg.x, rule)
    if end is None:
        raise refusal
    return end


def _event(modes: Modes, before: SmoothPiece, after: SmoothPiece, leg: Leg) -> Event:
    assert leg.guard is not None
    k = leg.guard.surface
    if leg.guard.kind == "leave":
        return Event(leg.t, modes.switched_rate.surfaces[k].name, "leaves", -leg.guard.side * leg.slope)
    what = "slides" if after.mode.sides[k] == 0 else "crosses"
    return Event(leg.t, modes.switched_rate.surfaces[k].name, what, before.mode.sides[k] * leg.slope)


def _join_spans(
    modes: Modes, slides: list[tuple[float, float, SwitchingMode]]
) -> tuple[tuple[float, float, tuple[str, ...]], ...]:
    """Spans in sliding on the same surfaces, as one where they meet."""
    spans: list[tuple[float, float, tuple[str, ...]]] = []
    for begin, end, mode in slides:
        names = tuple(modes.switched_rate.surfaces[k].name for k in mode.sliding_surfaces)
        if spans and spans[-1][1:] == (begin, names):
            begin = spans.pop()[0]
        spans.append((begin, end, names))
    return tuple(spans)


def start_of_sliding(
    modes: Modes, piece: SmoothPiece, t: float, x: Array, rule: SolverOptions
) -> tuple[SmoothPiece, Array] | None:
    """The sliding motion and its state if a surface is reached with no speed; else None."""
    reach = FINE * t / ROUNDING
    near = {
        guard.surface
        for guard, (value, _, _, speed) in zip(piece.guards, piece.watch(t, x), strict=True)
        if guard.kind == "cross" and modes.switched_rate.surfaces[guard.surface].jumps and value <= reach * speed
    }
    end = _settle_on(modes, piece, t, x, 0.0, near) if near else "no surface is near"
    if isinstance(end, str) or not end[0].second_order:
        return None
    following, there = end
    motion = np.abs(piece.field(t, piece.with_companions(t, x)).ravel()[: len(x)])
    motion = motion + np.abs(following.drive(t, there)).sum(axis=1)
    close = np.abs(there - x) <= rule.atol + rule.rtol * np.abs(x) + FINE * t * motion
    return (following, there) if close.all() else None


def _settle_on(
    modes: Modes, piece: SmoothPiece, t: float, x: Array, left: float, on: set[int]
) -> tuple[SmoothPiece, Array] | str:
    """The piece with sigma and its first derivative zero on the surfaces `on`, and its state after a time `left`."""
    sides = tuple(0 if k in on else side for k, side in enumerate(piece.mode.sides))
    following = modes.piece(SwitchingMode(sides, piece.mode.levels))
    if isinstance(following, str):
        return following
    x = x + left * following.field(t, following.with_companions(t, x)).ravel()[: len(x)]
    x = x + following.settle(t + left, x).ravel()
    for _ in range(3):
        held = following.hold(t + left, x)
        x = x - np.linalg.pinv(held[:, 1:-1]) @ held[:, 0]
    control = following.control(t + left, x)
    if not is_determined(control[:, 1:]):
        return "the sides that would hold it there are not determined"
    if not (np.abs(control[:, 0]) < 1).all():
        return "the sides that would hold it there are not between -1 and 1"
    return following, x
