"""The figures of a response in continuous time: first and last crossings of levels, and the largest value, proved."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from workbench.design.frequency.integer_polynomials import Polynomial, add, derivative, scale
from workbench.design.frequency.positive_roots import Root, at, bounds, unit_roots
from workbench.design.step_response.response_pieces import QUIET, UNIT, ResponsePiece, ResponsePieces

GRID = 2000  # times in doubles, from which the search for a supremum begins
LIKELY = 8
BITS = 120  # of a place within a piece
Bounds = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Top:
    """Bounds of the supremum of a response, and of the first time at which it is reached; None if it is a limit only.

    The later bound of the time is None where the supremum may be a limit.
    """

    low: Fraction
    high: Fraction
    first: Fraction | None
    last: Fraction | None


def first_reach(pieces: ResponsePieces, level: Fraction) -> Bounds:
    """Bounds of the first time at which the response reaches a level below its final value."""
    target = int(level * UNIT)
    early: Fraction | None = None

    def relevant(piece: ResponsePiece) -> bool:
        return piece.range[1] >= target

    for _, found in pieces.spans(relevant):
        for piece in found:
            least, most = _below_level(piece, target - piece.error - 1), _below_level(piece, target + piece.error + 1)
            if early is None and (u := _first(least)) is not None:
                early = piece.time(u.low)
            if early is not None and (u := _first(most)) is not None:
                return early, piece.time(u.high)
    raise AssertionError("a response reaches what lies below its final value")


def last_outside(pieces: ResponsePieces, band: Fraction) -> Bounds:
    """Bounds of the last time at which the response, whose final value is 1, is further than a band away from 1."""
    width = int(band * UNIT)
    late: Fraction | None = None

    def relevant(piece: ResponsePiece) -> bool:
        low, high = piece.range
        return low <= UNIT - width or high >= UNIT + width

    long = 2.0**pieces.longest
    end = long
    while pieces.response.envelope(end) > float(band) * (1 - 1e-6):
        end *= 2
    low_end = end / 2
    for _ in range(60):
        middle = (low_end + end) / 2
        low_end, end = (
            (low_end, middle) if pieces.response.envelope(middle) <= float(band) * (1 - 1e-6) else (middle, end)
        )
    for _, found in pieces.spans(relevant, int(end / long) + 1, -1):
        for piece in found:
            doubt = piece.error + 1
            sides = [_below_level(piece, UNIT + width), scale(_below_level(piece, UNIT - width), -1)]
            maybe = [u.high for p in sides if (u := _last(_shift_up(p, doubt))) is not None]
            surely = [u.low for p in sides if (u := _last(_shift_up(p, -doubt))) is not None]
            if late is None and maybe:
                late = piece.time(max(maybe))
            if late is not None and surely:
                return piece.time(max(surely)), late
    return Fraction(0), late or Fraction(0)


def supremum(pieces: ResponsePieces, sign: int, start: Fraction) -> Top:
    """The supremum of the response, or of its negative, and of `start` before the first time."""
    limit = sign * pieces.response.final
    best = max(limit, start)
    rows: list[tuple[Fraction, Fraction, Fraction, Fraction]] = []

    def relevant(piece: ResponsePiece) -> bool:
        low, high = piece.range
        return (high if sign > 0 else -low) > best * UNIT

    for t in _likely(pieces, sign):
        if (near := pieces.around(t, relevant)) is not None:
            best = max([best, *(row[2] for row in _candidates(near, sign))])
    for end, found in pieces.spans(relevant):
        for piece in found:
            for row in _candidates(piece, sign):
                best = max(best, row[2])
                rows.append(row)
        away = Fraction(pieces.response.envelope(end))
        side = pieces.response.side(end) * sign
        tail = limit if side < 0 else limit + away
        if tail <= best or away < QUIET:
            break
    high = max([best, tail, *(row[3] for row in rows)])
    kept = [row for row in rows if row[3] >= best and row[3] > max(limit, start)]
    open_end = tail >= best and limit >= start
    first = min((row[0] for row in kept), default=None)
    last = None if open_end or not kept else max(row[1] for row in kept)
    return Top(best, high, first, last)


def _likely(pieces: ResponsePieces, sign: int) -> list[float]:
    """Times in s near which the response, or its negative, is large in doubles; with luck near its supremum."""
    end = 2.0**pieces.longest
    while pieces.response.envelope(end) > 1e-3 and end < 2.0 ** (pieces.longest + 20):
        end *= 2
    t = np.concatenate([np.linspace(0, end, GRID), np.geomspace(end * 1e-9, end, GRID)])
    with np.errstate(all="ignore"):
        y = np.nan_to_num(sign * pieces.response.rough(t), nan=-np.inf)
    return [float(t[k]) for k in np.argsort(y)[: -LIKELY - 1 : -1]]


def _candidates(piece: ResponsePiece, sign: int) -> list[tuple[Fraction, Fraction, Fraction, Fraction]]:
    """Where the largest value of a piece may be: bounds of the time, and of the value."""
    p, error = scale(piece.polynomial, sign), Fraction(piece.error + 1, UNIT)
    slope, doubt = derivative(p), piece.slope_error + 1
    ends = sorted(
        (root for shift in (-doubt, doubt) for root in unit_roots(_shift_up(slope, shift), BITS)),
        key=lambda root: root.low,
    )
    ends = [Root(Fraction(0), Fraction(0)), *ends, Root(Fraction(1), Fraction(1))]
    places = [ends[0], ends[-1]]
    for left, right in pairwise(ends):
        middle = (left.high + right.low) / 2
        if left.high >= right.low or abs(at(slope, middle)) <= doubt:
            places.append(Root(left.low, max(left.high, right.high)))
    rows = []
    for place in places:
        _, high = bounds(p, place)
        reached = at(p, place.middle)
        rows.append(
            (piece.time(place.low), piece.time(place.high), reached / UNIT - error, max(high, reached) / UNIT + error)
        )
    return rows


def _shift_up(p: Polynomial, by: int) -> Polynomial:
    return add(p, [by])


def _below_level(piece: ResponsePiece, level: int) -> Polynomial:
    return _shift_up(piece.polynomial, -level)


def _first(p: Polynomial) -> Root | None:
    """The first place from 0 to 1 at which a polynomial is not negative."""
    if p[0] >= 0:
        return Root(Fraction(0), Fraction(0))
    if roots := unit_roots(p, BITS):
        return roots[0]
    return Root(Fraction(1), Fraction(1)) if sum(p) >= 0 else None


def _last(p: Polynomial) -> Root | None:
    """The last place from 0 to 1 at which a polynomial is not negative."""
    if sum(p) >= 0:
        return Root(Fraction(1), Fraction(1))
    if roots := unit_roots(p, BITS):
        return roots[-1]
    return Root(Fraction(0), Fraction(0)) if p[0] >= 0 else None
