"""The phase crossovers of a loop with a delay, and the gains between which it stays stable.

On a piece where the phase is monotonic each odd multiple of pi between its ends is reached exactly once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from workbench.design.frequency.certified_values import (
    INFINITE,
    ZERO,
    CertifiedValue,
    greatest,
    least,
    of_fractions,
    root_of,
    widen,
)
from workbench.design.frequency.delay_pieces import FrequencyInterval, LateLoop
from workbench.design.frequency.margin_records import Crossover
from workbench.design.matrices import DesignError

TURN = 2 * math.pi
ROUNDING = 1e-15  # relative, of a phase
MOST = 10_000  # crossovers in a list
STEP = 6.0  # rad of the delay, no multiple of the angles at which a phase can turn


def phase_crossovers(late: LateLoop, band: float) -> list[Crossover]:
    """All phase crossovers up to a frequency in rad/s, that at 0 included, with the factor -1 / L."""
    crossovers = _at_zero(late)
    for piece in late.pieces(band):
        targets = _targets(piece)
        if len(crossovers) + len(targets) > MOST:
            raise DesignError(
                f"Up to {band:g} rad/s there are more than {MOST} phase crossovers; choose a smaller `band`."
            )
        crossovers += sorted((_crossover(piece, k) for k in targets), key=lambda c: c.frequency.value)
    return crossovers


def gain_limits(late: LateLoop) -> tuple[CertifiedValue, CertifiedValue]:
    """The ends of the interval of gains around one that keep a stable loop stable: of all crossovers, to infinity."""
    A, B = late.loop.A, late.loop.B
    lows, highs = [ZERO], [INFINITE]
    if len(A) == len(B):  # roots of a chain reach the axis
        highs.append(root_of(*[Fraction(B[-1], A[-1])] * 2))
    at_zero = [crossover.margin for crossover in _at_zero(late)]
    lows += [margin for margin in at_zero if margin.value < 1]
    highs += [margin for margin in at_zero if margin.value > 1]
    for piece in _all_pieces(late):
        if targets := _targets(piece):
            # on a piece with |L| > 1, or < 1, the crossover at the end where |L| is nearer to 1 counts
            start, end = piece.at(piece.start).rho, piece.at(piece.end).rho
            ends = (_crossover(piece, targets[k]).margin for k in (0, -1))
            near = min(ends, key=lambda margin: abs(math.log(margin.value)))
            (lows if max(start, end) + min(start, end) > 0 else highs).append(near)
        if piece.start >= max(late.cuts, default=0.0) and piece.at(piece.end).rho <= ROUNDING - math.log(
            least(highs).value
        ):
            break
    return greatest(lows), least(highs)


def _all_pieces(late: LateLoop) -> Iterator[FrequencyInterval]:
    """All pieces, and beyond the last cut one octave after another."""
    last = max(late.cuts, default=0.0) or 1 / float(late.loop.delay)
    if late.cuts:
        yield from late.pieces(last)
    else:
        yield late.piece(0.0, last)
    while True:
        end = last + max(last, STEP / float(late.loop.delay))
        yield late.piece(last, end)
        last = end


def _at_zero(late: LateLoop) -> list[Crossover]:
    P, B = late.loop.P, late.loop.B
    if not (B[0] and P and P[0] < 0):
        return []
    gain = Fraction(B[0], -P[0])
    return [Crossover(ZERO, of_fractions(gain, gain))]


def _targets(piece: FrequencyInterval) -> range:
    """The numbers k for which the phase is (2 k + 1) pi inside of a piece, ascending."""
    ends = [piece.at(omega).phi for omega in (piece.start, piece.end)]
    places = [(phi / math.pi - 1) / 2 for phi in ends]
    for omega, place in zip((piece.start, piece.end), places, strict=True):
        if omega and abs(place - round(place)) < ROUNDING * (1 + abs(place)):
            raise DesignError(
                f"At {omega:.6g} rad/s the phase of the loop turns within rounding of -180 degrees, so that doubles do "
                "not tell whether it crosses. Change the delay in its last digits."
            )
    low, high = sorted(round(place) if abs(place - round(place)) < ROUNDING else place for place in places)
    return range(math.floor(low) + 1, math.ceil(high))


def _crossover(piece: FrequencyInterval, k: int) -> Crossover:
    from scipy.optimize import brentq  # here, as it takes long to import

    target = (2 * k + 1) * math.pi

    def excess(omega: float) -> float:
        return piece.phase(omega) - target

    omega = float(brentq(excess, piece.start, piece.end, xtol=1e-300, rtol=4 * 2.3e-16, maxiter=500))
    point = piece.at(omega)
    slope = abs(point.phi_slope) or 1.0
    doubt = 4 * math.ulp(omega) + (abs(excess(omega)) + 4 * ROUNDING * (abs(target) + TURN)) / slope
    shift = math.exp(-point.rho)
    spread = shift * math.expm1(min(1.5 * abs(point.rho_slope) * doubt + 4 * ROUNDING, 1.0))
    return Crossover(widen(omega, omega - doubt, omega + doubt), widen(shift, shift - spread, shift + spread))
