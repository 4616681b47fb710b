"""The mode that continues a solution from a switching surface: crossing, sliding (Filippov), or none that is unique."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection
from dataclasses import dataclass, field
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import Array
from workbench.engine.reference.smooth_pieces import Guard, Numeric, SmoothPiece, SwitchingMode
from workbench.engine.reference.surfaces import SwitchedRate

MOST = 3**5  # continuations from one state that are looked at: five relays at once
FLAT = 1e5  # a derivative this many times beyond its rounding has a sign
ALIKE = 1e-8  # rates are one within this share; a side that is left may be 1e-9 from its end
SINGULAR = 1e-10  # reciprocal condition below which sides in sliding are not determined


@dataclass(frozen=True, eq=False)
class Modes:
    """The modes of a switched rate, each made once."""

    switched_rate: SwitchedRate
    pieces: dict[SwitchingMode, SmoothPiece | str] = field(default_factory=dict)

    def piece(self, mode: SwitchingMode) -> SmoothPiece | str:
        """The piece of a mode, or the reason why it has none."""
        if mode not in self.pieces:
            try:
                self.pieces[mode] = SmoothPiece.of(self.switched_rate, mode)
            except ValueError as reason:
                self.pieces[mode] = str(reason)
        return self.pieces[mode]

    def start(self, t: float, x: Array) -> SmoothPiece:
        """The piece from an initial state."""
        count = len(self.switched_rate.surfaces)
        levels = tuple(self._first_levels(t, x))
        mode = self._mode_at(t, x, SwitchingMode((0,) * count, levels), {})
        sigma = self._sigma(t, x, mode)
        return self.onward(t, x, mode, {k for k in range(count) if not abs(sigma[k]) > 1e-14 * (1 + abs(t))})

    def onward(self, t: float, x: Array, mode: SwitchingMode, on: Collection[int]) -> SmoothPiece:
        """The piece that continues from a state that lies on the surfaces `on`, or a refusal.

        A piece continues if each side it names is the side that it moves to; in sliding, if the sides that keep it on
        the surface are between -1 and 1.
        """
        places = sorted({*on, *mode.sliding_surfaces})
        names = ", ".join(f"{self.switched_rate.surfaces[k].name} = 0" for k in places)
        options = [(1, -1, 0) if self.switched_rate.surfaces[k].jumps else (1, -1) for k in places]
        if math.prod(map(len, options)) > MOST:
            raise stop(t, f"the state lies on {len(places)} surfaces at once, which is too many to look at: {names}")
        found: dict[bool, list[SmoothPiece]] = {True: [], False: []}
        looked, reasons = list[SmoothPiece](), list[str]()
        for sides in itertools.product(*options):
            piece = self.piece(self._mode_at(t, x, mode, dict(zip(places, sides, strict=True))))
            if isinstance(piece, str):
                reasons.append(piece)
                continue
            looked.append(piece)
            if (verdict := self._continues(piece, t, x, places)) is not None:
                found[verdict].append(piece)
        if len(found[True]) > 1:
            raise stop(t, f"the state leaves {names} to more than one side: the solution is not unique")
        if not found[True] and not _alike(found[False], looked, t, x):
            why = reasons[0] if reasons else "the solution is not unique"
            raise stop(t, f"the state stays on {names}, where each side has a rate of its own: {why}")
        if not found[True] and not found[False]:
            why = f": {reasons[0]}" if reasons else " in a way that is unique and continues"
            raise stop(t, f"the state can neither cross {names} nor slide there{why}")
        return (found[True] or found[False])[0]

    def _continues(self, piece: SmoothPiece, t: float, x: Array, on: list[int]) -> bool | None:
        """True if the piece continues from (t, x) with certainty, False if within rounding, None if not at all."""
        if piece.mode.sliding_surfaces:
            held, control = piece.hold(t, x), piece.control(t, x)
            if not is_determined(control[:, 1:]):
                return None
            beyond_first = held[len(piece.mode.sliding_surfaces) :]
            if (np.abs(beyond_first[:, 0]) > beyond_first[:, -1]).any():
                return None
        certain, second = True, None
        for k, (guard, row) in enumerate(zip(piece.guards, piece.watch(t, x), strict=True)):
            value, noise, slope, slope_noise = row
            if not (
                (guard.kind == "cross" and guard.surface in on)
                or abs(value) <= max(noise, 1e-9 * (guard.kind == "leave"))
            ):
                if not value > 0:
                    return None
                continue
            if not abs(slope) > FLAT * slope_noise:
                second = piece.bend(t, x) if second is None else second
                slope, slope_noise = second[k]
            if slope < -FLAT * slope_noise or not np.isfinite(slope):
                return None
            certain = certain and bool(slope > FLAT * slope_noise)
        return certain

    def _mode_at(self, t: float, x: Array, mode: SwitchingMode, chosen_sides: dict[int, int]) -> SwitchingMode:
        """The mode with some sides chosen, and each other side by the sign of its own sigma."""
        sides = list(mode.sides)
        for k in range(len(sides)):
            if k in chosen_sides:
                sides[k] = chosen_sides[k]
            else:
                sigma = self._sigma(t, x, SwitchingMode(tuple(sides), mode.levels))[k]
                # a side is flipped by a surface that lies before it, never by rounding on its own
                sides[k] = int(np.sign(sigma)) if abs(sigma) > 1e-12 or not sides[k] else sides[k]
        return SwitchingMode(tuple(sides), mode.levels)

    def _first_levels(self, t: float, x: Array) -> list[float]:
        levels = [0.0] * len(self.switched_rate.surfaces)
        for k, surface in enumerate(self.switched_rate.surfaces):
            if surface.level is not None:
                mode = self._mode_at(t, x, SwitchingMode((0,) * len(levels), tuple(levels)), {})
                levels[k] = float(np.round(self._sigma(t, x, mode)[k]))
        return levels

    def _sigma(self, t: float, x: Array, mode: SwitchingMode) -> Array:
        return self._sigmas(t, np.concatenate([x, mode.sides, mode.levels])).ravel()

    @cached_property
    def _sigmas(self) -> Numeric:
        """All sigma as a function of (t, [x; sides; levels])."""
        every = self.switched_rate.surfaces
        sides, levels = ca.SX.sym("sides", len(every)), ca.SX.sym("levels", len(every))
        sigma = ca.vertcat(ca.SX(0, 1), *[s.sigma for s in every])
        old = [[s.side, s.corner, *([] if s.level is None else [s.level])] for s in every]
        new = [[sides[k], sides[k], *([] if s.level is None else [levels[k]])] for k, s in enumerate(every)]
        if every:
            sigma = ca.substitute(sigma, ca.vertcat(*itertools.chain(*old)), ca.vertcat(*itertools.chain(*new)))
        arguments = [self.switched_rate.t, ca.vertcat(self.switched_rate.x, sides, levels)]
        return Numeric(ca.Function("sigma", arguments, [sigma]))


def next_mode(mode: SwitchingMode, guard: Guard) -> SwitchingMode:
    """The mode after a staircase has moved on by one level: the side of the surface changes its sign."""
    k, side = guard.surface, guard.side
    levels = tuple(level + side * (i == k) for i, level in enumerate(mode.levels))
    return SwitchingMode(tuple(-side if i == k else s for i, s in enumerate(mode.sides)), levels)


def is_determined(gains: Array) -> bool:
    """True if the sides in sliding follow from their gains (k, k)."""
    if not np.isfinite(gains).all():
        return False
    scaled = gains / np.maximum(np.abs(gains).max(axis=1, keepdims=True), np.finfo(float).tiny)
    sizes = np.linalg.svd(scaled, compute_uv=False)
    return bool(sizes[-1] > SINGULAR * sizes[0])


def _alike(pieces: list[SmoothPiece], examined_pieces: list[SmoothPiece], t: float, x: Array) -> bool:
    """True if pieces have one rate, relative to the largest rate of all that were examined."""
    if len(pieces) < 2:
        return True
    rates = [
        [p.field(t, p.with_companions(t, x)).ravel()[: len(x)] for p in some] for some in (pieces, examined_pieces)
    ]
    spread, size = np.ptp(rates[0], axis=0), np.abs(rates[1]).max(axis=0)
    return not (spread > ALIKE * size).any()


def stop(t: float, why: str) -> ValueError:
    """The error of a solution that ends at a time."""
    return ValueError(f"`reference(ode=...)` stops at t = {t:.12g} s, where {why}.")
