"""The turns of a Nyquist curve about a point: counted on the closed curve, or the reason why they are not."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.frequency_axis import low_slope
from workbench.study.document.frequency_curves import Complex, check_frequencies, complexes, number

LARGEST = 2 * np.pi / 3  # of a turn from one frequency to the next
APPROACH_SHARE = (
    0.5  # of the distance of the point from zero: a curve that ends nearer to zero turns no more about the point
)
REAL = 0.25  # radians from the real axis, as seen from the point, within which a curve that is flat at its end ends
INTEGRATOR_TOLERANCE = 0.05  # of the slope of a gain from that of integrators
FLAT, BEFORE = 0.25, 3.0  # of the distance from the point: the change over the last factor of 3 of frequency


@dataclass(frozen=True)
@check_arguments
class CurveTurns:
    """The number of `clockwise` encirclements of a point, negative if anticlockwise; None if it cannot be counted.

    `closures` is the number of clockwise half turns that close the curve at infinity, one for each integrator.
    `reason` says why there is no count.
    """

    clockwise: int | None
    closures: int = 0
    reason: str = ""


@check_arguments
def curve_turns(
    frequencies: Array,
    values: object,
    period: float | None = None,
    point: float = -1.0,
    integrators: int | None = None,
) -> CurveTurns:
    """The encirclements of a real `point` by the curve of L, its mirror image and its closure.

    `values` (m,) are L at `frequencies` (m,) in rad/s, with the `period` in s of a sampled loop. A pole at zero, or at
    z = 1, is passed on the right, so that n of them close the curve by n half turns clockwise. Their number comes from
    the slope of the gain at the lowest frequencies; the phase there, and `integrators` if given, must agree. Beyond the
    highest frequency the curve is closed straight to its mirror image, if it ends near zero, or flat and nearly real.

    Raises
    ------
    ValueError
        If the frequencies do not rise, or `values` does not have one value for each of them.

    References
    ----------
    Astrom and Murray (2021), Feedback Systems, second edition, section 10.2.
    """
    omega = check_frequencies("curve_turns(frequencies=...)", frequencies, period)
    curve = complexes("curve_turns(values=...)", values, 1, gaps=True)
    if curve.shape != omega.shape or not math.isfinite(point):
        must = f"an answer for each of {len(omega)} frequencies, and a finite point"
        raise refusal("curve_turns(values=...)", must, values)
    omega, curve = omega[omega > 0], curve[omega > 0]
    away = curve - point
    if not np.isfinite(curve).all() or len(curve) < 2:
        return CurveTurns(None, reason="the curve has a gap")
    if (away == 0).any():
        return CurveTurns(None, reason=f"the curve meets {number(point)}")
    steps = np.angle(away[1:] / away[:-1])
    if np.abs(steps).max() > LARGEST:
        k = int(np.abs(steps).argmax())
        span = f"{number(omega[k])} and {number(omega[k + 1])} rad/s"
        return CurveTurns(None, reason=f"the curve turns by more than 120 degrees between the frequencies {span}")
    if not (_ends(omega, curve, point) or (period is not None and omega[-1] > (1 - 1e-3) * math.pi / period)):
        where = f"at the highest frequency, {number(omega[-1])} rad/s"
        return CurveTurns(None, reason=f"{where}, the curve is neither near zero nor constant")
    order = max(0, -low_slope(omega, curve))
    if not _begins(omega, curve, point, order) or (integrators is not None and order != max(0, integrators)):
        where = f"at the lowest frequency, {number(omega[0])} rad/s, L has not reached its low-frequency asymptote"
        return CurveTurns(None, reason=f"{where}, whose slope its poles at zero give")
    first, last = float(np.angle(away[0])), float(np.angle(away[-1]))
    start = _nearest(2 * first, -order * math.pi)
    total = 2 * float(steps.sum()) + start + _nearest(-2 * last, 0.0)
    return CurveTurns(-round(total / (2 * math.pi)), order)


def _ends(omega: Array, curve: Complex, point: float) -> bool:
    """True if a curve ends near zero, where it turns no more about the point, or is flat there and nearly real."""
    if abs(curve[-1]) < APPROACH_SHARE * abs(point):
        return True
    away = complex(curve[-1]) - point
    before = complex(curve[int(np.searchsorted(omega, omega[-1] / BEFORE))])
    real = abs(math.remainder(2 * math.atan2(away.imag, away.real), 2 * math.pi)) < 2 * REAL
    return real and abs(complex(curve[-1]) - before) < FLAT * abs(away)


def _begins(omega: Array, curve: Complex, point: float, order: int) -> bool:
    """True if a curve begins as integrators do, in slope and phase, or near zero, or flat and nearly real."""
    first = complex(curve[0])
    if order == 0:
        if abs(first) < APPROACH_SHARE * abs(point) and low_slope(omega, curve) > 0:
            return True
        away, later = first - point, complex(curve[min(len(curve) - 1, int(np.searchsorted(omega, BEFORE * omega[0])))])
        real = abs(math.remainder(2 * math.atan2(away.imag, away.real), 2 * math.pi)) < 2 * REAL
        return real and abs(later - first) < FLAT * max(abs(first), abs(later))
    angle = 2 * (math.atan2(first.imag, first.real) + order * math.pi / 2)
    slope = math.log(abs(curve[1] / curve[0])) / math.log(omega[1] / omega[0])
    return abs(math.remainder(angle, 2 * math.pi)) < 2 * REAL and abs(slope + order) < INTEGRATOR_TOLERANCE


def _nearest(angle: float, to: float) -> float:
    """The angle plus full turns, as near to another as can be."""
    return to + math.remainder(angle - to, 2 * math.pi)
