"""One solution of a switched equation, piece by piece: crossing, sliding, leaving, and where switchings accumulate."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

import numpy as np

from workbench.reference.accumulation import Streak, stalled
from workbench.reference.location import SHORTEST
from workbench.reference.modes import Modes, turned
from workbench.reference.pieces import Mode, Piece
from workbench.reference.variable_step import Effort, Flow, Leg, Rule, StoppedError, tighter, travel
from workbench.validation.refusals import Array


@dataclass(frozen=True)
class Event:
    """What happened on a switching surface, and when.

    Attributes
    ----------
    t
        In s.
    surface
        The switching function sigma, as text.
    what
        "crosses", "slides" (sliding begins), "leaves" (sliding ends), or "settles" (sliding begins with
        sigma = d sigma / dt = 0, after switchings that accumulate or after none).
    rate
        d sigma / dt on arrival; for "leaves" the rate at which the side passes 1 or -1, in 1/s.
    """

    t: float
    surface: str
    what: str
    rate: float


@dataclass(frozen=True, eq=False)
class Run:
    """States (N, nx) at the times asked for, what was met on the way, and what it cost."""

    states: Array
    events: tuple[Event, ...]
    slid: tuple[tuple[float, float, tuple[str, ...]], ...]
    effort: Effort


def follow(modes: Modes, valid: Callable[[float, Array], bool], x: Array, times: Array, rule: Rule) -> Run:
    """The solution from x at time 0, at increasing `times`.

    Raises
    ------
    ValueError
        If no piece, or more than one, continues it, or switchings accumulate where no sliding motion follows.
    StoppedError
        If it does not continue numerically.
    """
    t, effort, events, slid, streak = 0.0, Effort(), list[Event](), list[tuple[float, float, Mode]](), Streak(modes)
    kept, still = [x] if times[0] == 0 else [], 0
    piece = modes.start(t, x)
    while len(kept) < len(times):
        leg = travel(Flow.of(piece, valid), t, x, times[-1], times[len(kept) :], tighter(rule, streak.share), effort)
        kept.extend(leg.states)
        if piece.mode.sliding:
            slid.append((t, leg.t, piece.mode))
        still = still + 1 if leg.t - t <= SHORTEST * times[-1] else 0
        t, x, before = leg.t, leg.x, piece
        if len(kept) == len(times):
            break
        piece, at_rest = _next(modes, before, leg, rule)
        if at_rest is not None:
            x = at_rest
            events.append(Event(t, _names(modes, set(piece.mode.sliding) - set(before.mode.sliding)), "settles", 0.0))
        elif leg.hit is not None and leg.hit.kind != "turn":
            events.append(_event(modes, before, piece, leg))
            if still > 3 * len(modes.switched.surfaces):  # more than all of them at one instant
                raise ValueError(
                    f"`reference(ode=...)` stops at t = {t:.12g} s, where {events[-1].surface} switches again and "
                    "again: its first two derivatives do not tell to which side the state moves."
                )
            after = streak.after(before, piece, leg, times[len(kept) :])
            if after is not None:
                piece, t, x = after
                kept.extend([x] * int(np.sum(times[len(kept) :] <= t)))
                events.append(replace(events[-1], t=t, what="settles", rate=0.0))
    return Run(np.array(kept).reshape(len(times), -1), tuple(events), _joined(modes, slid), effort)


def _next(modes: Modes, piece: Piece, leg: Leg, rule: Rule) -> tuple[Piece, Array | None]:
    """The piece after another has ended, and the state it is at rest in if it begins with sigma = d sigma / dt = 0."""
    if leg.hit is not None and leg.hit.kind == "turn":
        following = modes.piece(turned(piece.mode, leg.hit))
        assert isinstance(following, Piece)  # the same rate by another name
        return following, None
    refusal: Exception = StoppedError(leg.t, leg.x, "step")
    if leg.hit is not None:
        rows = piece.watch(leg.t, leg.x)
        guards = [guard for guard, row in zip(piece.guards, rows, strict=True) if row[0] <= row[1]]
        near = {guard.surface for guard in guards if guard.kind == "cross"}
        try:
            return modes.onward(leg.t, leg.x, piece.mode, near | {leg.hit.surface}), None
        except ValueError as error:
            refusal = error
    end = stalled(modes, piece, leg.t, leg.x, rule)
    if end is None:
        raise refusal
    return end


def _names(modes: Modes, places: Collection[int]) -> str:
    return ", ".join(modes.switched.surfaces[k].name for k in sorted(places))


def _event(modes: Modes, before: Piece, after: Piece, leg: Leg) -> Event:
    assert leg.hit is not None
    k = leg.hit.surface
    if leg.hit.kind == "leave":
        return Event(leg.t, modes.switched.surfaces[k].name, "leaves", -leg.hit.side * leg.slope)
    what = "slides" if after.mode.sides[k] == 0 else "crosses"
    return Event(leg.t, modes.switched.surfaces[k].name, what, before.mode.sides[k] * leg.slope)


def _joined(modes: Modes, slid: list[tuple[float, float, Mode]]) -> tuple[tuple[float, float, tuple[str, ...]], ...]:
    """Spans in sliding on the same surfaces, as one where they meet."""
    spans: list[tuple[float, float, tuple[str, ...]]] = []
    for begin, end, mode in slid:
        names = tuple(modes.switched.surfaces[k].name for k in mode.sliding)
        if spans and spans[-1][1:] == (begin, names):
            begin = spans.pop()[0]
        spans.append((begin, end, names))
    return tuple(spans)
