"""The margins of a loop with one channel, certified: crossovers, gains, delay, peaks of S and T, and the disk.

A loop without a delay is a ratio of polynomials with rational coefficients, those of its doubles as written; its
crossovers and peaks are isolated roots of polynomials made of them, so that none is overlooked, however narrow. The
circle of a discrete loop becomes the axis by z = (1 + v) / (1 - v). With a delay, exp(-s delay) is exact, too.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from workbench.core.validation.refusals import positive
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.axis_loop import AxisLoop, axis_loop, refuse_odd_loop
from workbench.design.frequency.certified_values import (
    INFINITE,
    ZERO,
    CertifiedPeak,
    CertifiedValue,
    enclosure,
    greatest,
    least,
    magnitude,
    root_of,
    twice_inverse,
    widen,
)
from workbench.design.frequency.crossovers import (
    UnitGain,
    late_phase,
    real_crossovers,
    unit_gain_crossovers,
)
from workbench.design.frequency.delay_count import is_stable
from workbench.design.frequency.delay_crossovers import gain_limits, phase_crossovers
from workbench.design.frequency.delay_peaks import Valley, least_balance, least_distance, least_inverse_distance
from workbench.design.frequency.delay_pieces import LateLoop, late_loop
from workbench.design.frequency.estimated_margins import estimated_margins
from workbench.design.frequency.exact_systems import MOST_STATES
from workbench.design.frequency.integer_polynomials import Polynomial, add, scale, trim
from workbench.design.frequency.margin_records import Crossover, StabilityMargins, StableMargins
from workbench.design.frequency.rational_peaks import largest_ratio
from workbench.design.frequency.rounded_crossovers import doubt_words, doubtful_crossovers, with_doubt

if TYPE_CHECKING:
    import control

LAG = 64.0  # rad of the delay, up to which phase crossovers are listed without a `band`


@check_arguments
def stability_margins(
    loop: control.TransferFunction | control.StateSpace, delay: float = 0.0, band: float | None = None
) -> StabilityMargins:
    """The margins of the negative feedback of a loop L with one channel, continuous or discrete, with an exact delay.

    Up to 40 states the bounds are proved for the numbers as written, else `remarks` calls them estimates. A phase
    crossover of a `StateSpace` that another last digit of its matrices may undo is in `remarks`, and not listed.

    Parameters
    ----------
    loop
        The loop gain L, a `TransferFunction` or a `StateSpace` with one input and one output.
    delay
        A delay in s; for a discrete loop a whole number of periods. It must be 0 for a continuous loop of more than 40
        states.
    band
        For a continuous loop with a delay, the frequency in rad/s up to which phase crossovers are listed.

    Raises
    ------
    ValueError
        If `loop` is not a linear system with one input and one output, or has more zeros than poles, no denominator, or
        numbers that are not finite; if the delay is negative or `band` is not positive.
    DesignError
        If 1 + L is zero at infinity, doubles do not tell the side of a root, or the loop is too large: beyond 400
        states, 40 with a delay, or 40 as a `TransferFunction`.

    References
    ----------
    Seiler, Packard and Gahinet (2020), IEEE Control Systems Magazine 40(5), "An introduction to disk margins".

    Examples
    --------
    >>> import control
    >>> found = wb.stability_margins(control.tf([4], [1, 3, 3, 1]))
    >>> found.gain_high.value, found.Ms.gain.value
    (2.0, 3.0)
    """
    if band is not None:
        band = positive("stability_margins(band=...)", band, " of rad/s")
    refuse_odd_loop("stability_margins", loop)
    if loop.nstates and loop.nstates > MOST_STATES:
        return estimated_margins(loop, delay)
    given = axis_loop("stability_margins", loop, delay)
    stable, gains = is_stable(given), unit_gain_crossovers(given)
    late = late_loop(given) if given.delay and given.numerator else None
    phases = real_crossovers(given) if late is None else phase_crossovers(late, band or _band(given, gains))
    doubtful = doubtful_crossovers(loop, given, phases) if loop.nstates and late is None and not loop.dt else []
    phases = [row for row in phases if row not in doubtful]
    margins = _margins(given, late, gains, phases) if stable else None
    remarks = _remarks(given)
    if doubtful:
        remarks = (*remarks, doubt_words(doubtful))
        if margins is not None:
            low, high = with_doubt(margins.gain_low, margins.gain_high, doubtful)
            margins = replace(margins, gain_low=low, gain_high=high)
    return StabilityMargins(stable, tuple(row for _, row in gains), tuple(phases), margins, remarks)


def _band(loop: AxisLoop, gains: list[tuple[UnitGain, Crossover]]) -> float:
    last = max((gain.frequency.value for gain, _ in gains), default=0.0)
    return max(LAG / float(loop.delay), 2 * last)


def _remarks(loop: AxisLoop) -> tuple[str, ...]:
    remarks = []
    if not trim(add(loop.A, scale(loop.B, -1))):
        remarks.append("|L| is one at every frequency; only the ends of the axis are listed as gain crossovers.")
    if loop.numerator and not loop.Q and not loop.delay:
        remarks.append("L is real at every frequency; only the ends of the axis are listed as phase crossovers.")
    return tuple(remarks)


def _margins(
    loop: AxisLoop,
    late: LateLoop | None,
    gains: list[tuple[UnitGain, Crossover]],
    phases: list[Crossover],
) -> StableMargins:
    low, high = gain_limits(late) if late else _limits([row.margin for row in phases])
    phase = least(magnitude(row.margin) for _, row in gains)
    delay = least(_delay(loop, gain) for gain, _ in gains)
    if loop.period is None and len(loop.A) == len(loop.B) and abs(loop.A[-1]) > loop.B[-1]:
        delay = ZERO  # |L| > 1 at infinity: no delay is short enough
    return StableMargins(low, high, phase, delay, *(_late_peaks(late) if late else _peaks(loop)))


def _limits(factors: list[CertifiedValue]) -> tuple[CertifiedValue, CertifiedValue]:
    return greatest(f for f in factors if f.value < 1), least(f for f in factors if f.value > 1)


def _delay(loop: AxisLoop, gain: UnitGain) -> CertifiedValue:
    """The delay in s whose lag at a gain crossover is the phase margin, taken as positive."""
    phase, omega = late_phase(loop, gain), gain.frequency
    turn = 2 * math.pi if phase.value < 0 else 0.0
    if omega.value == 0 or math.isinf(omega.value):
        return INFINITE if omega.value == 0 else ZERO
    value, low, high = ((part + turn) for part in (phase.value, phase.low, phase.high))
    bounds = enclosure(low / omega.high, high / omega.low, steps=2)
    return CertifiedValue(value / omega.value, bounds.low, bounds.high)


def _peaks(loop: AxisLoop) -> tuple[CertifiedPeak, CertifiedPeak, CertifiedValue, float]:
    """Ms, Mt and the disk margin from |D|^2, |N|^2 and |D - N|^2 over |D + N|^2."""
    both = add(loop.A, loop.B)
    closed, opposed = trim(add(both, scale(loop.P, 2))), trim(add(both, scale(loop.P, -2)))
    balance = _peak(loop, opposed, closed)
    return _peak(loop, loop.B, closed), _peak(loop, loop.A, closed), twice_inverse(balance.gain), balance.frequency


def _peak(loop: AxisLoop, F: Polynomial, G: Polynomial) -> CertifiedPeak:
    peak = largest_ratio(F, G)
    place = loop.top if peak.place is None else loop.frequency(peak.place)
    return CertifiedPeak(root_of(peak.low, peak.high), place.value)


def _late_peaks(late: LateLoop) -> tuple[CertifiedPeak, CertifiedPeak, CertifiedValue, float]:
    S, T, g = least_distance(late), least_inverse_distance(late), least_balance(late)
    disk = (2 * math.sqrt(part / (2 - part)) for part in (g.value, g.low, g.high))
    return _inverse_root(S), _inverse_root(T), widen(*disk), g.frequency


def _inverse_root(valley: Valley) -> CertifiedPeak:
    value, low, high = (1 / math.sqrt(part) for part in (valley.value, valley.high, valley.low))
    return CertifiedPeak(widen(value, low, high), valley.frequency)
