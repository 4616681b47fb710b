"""The figures of the step response of a stable system, each with bounds that are proved."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from workbench.core.validation.notebook_display import show
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.axis_loop import refuse_odd_loop
from workbench.design.frequency.certified_values import INFINITE, ZERO, CertifiedValue, of_fractions
from workbench.design.frequency.stable_ratios import ONE_CHANNEL, StableRatio, stable_ratio
from workbench.design.matrices import DesignError
from workbench.design.step_response.piece_figures import Bounds, Top, first_reach, last_outside, supremum
from workbench.design.step_response.response_modes import response_modes
from workbench.design.step_response.response_pieces import ResponsePieces
from workbench.design.step_response.sampled_figures import sampled_figures

if TYPE_CHECKING:
    import control

RISE = (Fraction(1, 10), Fraction(9, 10))  # of the final value
BAND = Fraction(1, 50)  # of the final value: that of the settling time
MOST_POLES = 20  # of a picture: some seconds
NO_STEP = "its step response has no final value"
LARGEST_PEAK = 10**10  # times the final value: a larger peak leaves it to rounding
UNKNOWN_VALUE = CertifiedValue(math.nan, math.nan, math.nan)


@dataclass(frozen=True)
@show
class StepInfo:
    """The figures of a step response from rest, each with bounds; times are in s from the step on.

    `rise_time` is that from 10 % to 90 % of the `final` value, `settling_time` the last one at which the response is
    2 % of it or more away from it. `overshoot` and `undershoot` are the parts of the final value, in %, by which the
    response goes beyond it, and below zero. `peak` is the largest |y|, and `peak_time` when it is first reached,
    infinite if |y| only tends to it. In a computer all are those at its instants. A response that returns to zero has
    `peak` and `peak_time` alone, the others are NaN; `remarks` says so. A peak above
    1e10 times the final value counts as that.
    """

    rise_time: CertifiedValue
    settling_time: CertifiedValue
    overshoot: CertifiedValue
    undershoot: CertifiedValue
    peak: CertifiedValue
    peak_time: CertifiedValue
    final: CertifiedValue
    remarks: tuple[str, ...] = ()


@check_arguments
def step_info(system: control.TransferFunction | control.StateSpace) -> StepInfo:
    """Rise time, settling time, overshoot, peak and final value of the step response of a stable system.

    The system has one input and one output, and is continuous or discrete. Polynomials enclose the response on
    intervals of time, and their roots give its crossings and extrema. After the last interval its modes are bounded. So
    no peak is missed, as it could be on a grid of time.

    Raises
    ------
    ValueError
        If the system is not a linear system with one input and one output, has more zeros than poles, or numbers that
        are not finite.
    DesignError
        If it is not stable or has an integrator, and so no final value; or has more than 40 states, or a response that
        turns too often before it settles.

    Examples
    --------
    >>> import control
    >>> info = wb.step_info(control.tf([4], [1, 1, 4]))
    >>> info.overshoot.value.__round__(4), info.peak_time.value.__round__(4)
    (44.4344, 1.6223)
    """
    ratio = stable_ratio("step_info", system, NO_STEP)
    final = ratio.final
    if not ratio.numerator:
        return _peak_alone(ZERO, ZERO, ZERO, system.name)
    if len(ratio.denominator) == 1:
        size = of_fractions(abs(final), abs(final))
        return StepInfo(ZERO, ZERO, ZERO, ZERO, size, ZERO, of_fractions(final, final))
    scale = final if final else Fraction(1)
    if ratio.period is None:
        return _continuous(ratio, scale, system.name)
    return _sampled_step_info(ratio, scale, system.name)


def exact_figures(system: control.TransferFunction | control.StateSpace) -> StepInfo | None:
    """The figures of a step response for a picture, which shall be drawn at once.

    They are None where `step_info` refuses them or knows a peak alone, and for more than 20 poles.
    """
    refuse_odd_loop("exact_figures", system, "system", ONE_CHANNEL)
    if len(system.poles()) > MOST_POLES:
        return None
    try:
        info = step_info(system)
    except DesignError:
        return None
    return None if info.remarks else info


def _continuous(ratio: StableRatio, scale: Fraction, name: str) -> StepInfo:
    pieces = ResponsePieces.of(response_modes(ratio, scale))
    tops = [supremum(pieces, sign, Fraction(0)) for sign in (1, -1)]
    rise = settling = None
    if ratio.final and max(top.high for top in tops) < LARGEST_PEAK:
        start, end = (first_reach(pieces, level) for level in RISE)
        rise = max(end[0] - start[1], Fraction(0)), end[1] - start[0]
        settling = last_outside(pieces, BAND)
    return _info(ratio, scale, name, rise, settling, tops, Fraction(1))


def _sampled_step_info(ratio: StableRatio, scale: Fraction, name: str) -> StepInfo:
    found = sampled_figures(ratio, response_modes(ratio, scale), scale, RISE, BAND)
    rise = settling = None
    period = Fraction(ratio.period or 0)
    small = max(found.top.high, found.bottom.high) < LARGEST_PEAK
    if small and found.low is not None and found.high is not None and found.settling_count is not None:
        rise = (period * (found.high - found.low),) * 2
        settling = (period * found.settling_count,) * 2
    return _info(ratio, scale, name, rise, settling, [found.top, found.bottom], period)


def _info(
    ratio: StableRatio,
    scale: Fraction,
    name: str,
    rise: Bounds | None,
    settling_time: Bounds | None,
    tops: list[Top],
    unit: Fraction,
) -> StepInfo:
    """The figures from those of the response over `scale`; times of the extremes are in units of so many s."""
    final = of_fractions(ratio.final, ratio.final)
    highest, lowest = tops
    low, high = max(highest.low, lowest.low), max(highest.high, lowest.high)
    likely = [top for top in tops if top.high >= low]  # two where doubles do not tell which is the larger
    peak = of_fractions(abs(scale) * low, abs(scale) * high)
    peak_time = _time(likely, unit)
    if rise is None or settling_time is None:
        return _peak_alone(peak, peak_time, final, name)
    return StepInfo(
        of_fractions(*rise),
        of_fractions(*settling_time),
        _percent(highest.low - 1, highest.high - 1),
        _percent(lowest.low, lowest.high),
        peak,
        peak_time,
        final,
    )


def _time(tops: Iterable[Top], unit: Fraction) -> CertifiedValue:
    """The time in s at which the larger of some suprema is first reached."""
    held = [top for top in tops if top.first is not None]
    if not held:
        return INFINITE
    first = min(top.first for top in held if top.first is not None) * unit
    if len(held) < len(list(tops)) or any(top.last is None for top in held):
        return CertifiedValue(float(first), float(first), math.inf)
    return of_fractions(first, max(top.last for top in held if top.last is not None) * unit)


def _percent(low: Fraction, high: Fraction) -> CertifiedValue:
    """A part in percent between two fractions; one that may be zero counts as zero."""
    if low > 0:
        return of_fractions(100 * low, 100 * high)
    return CertifiedValue(0.0, 0.0, 0.0 if high <= 0 else math.nextafter(float(100 * high), math.inf))


def _peak_alone(peak: CertifiedValue, peak_time: CertifiedValue, final: CertifiedValue, name: str) -> StepInfo:
    """The figures of a response that returns to zero."""
    remark = (
        f"The response of '{name}' returns to zero, as far as rounding tells, so that rise, settling, overshoot and "
        "undershoot, which are parts of the final value, have no meaning; `peak` and `peak_time` stand."
    )
    return StepInfo(UNKNOWN_VALUE, UNKNOWN_VALUE, UNKNOWN_VALUE, UNKNOWN_VALUE, peak, peak_time, final, (remark,))
