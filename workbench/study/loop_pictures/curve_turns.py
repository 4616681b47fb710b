"""The turns of a Nyquist curve about a point: counted on the closed curve, or the reason why they are not."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from workbench.study.loop_pictures.frequency_curves import Complex, low_slope, number
from workbench.validation.refusals import Array
from workbench.validation.signatures import door

LARGEST = 2 * np.pi / 3  # of a turn from one frequency to the next
SETTLED = 0.5  # of the distance of the point from zero: a curve that ends nearer to zero turns no more about the point
REAL = 0.02  # radians from the real axis, at which a curve that ends elsewhere is closed on it


@dataclass(frozen=True)
@door
class CurveTurns:
    """The `clockwise` turns about a point, negative if they are the other way; None where the curve does not tell.

    `closures` is the number of half turns clockwise by which the curve is closed at infinity, as at integrators.
    `reason` says why there is no count.
    """

    clockwise: int | None
    closures: int = 0
    reason: str = ""


@door
def curve_turns(frequencies: Array, values: object, period: float | None = None, point: float = -1.0) -> CurveTurns:
    """The turns about a real point of the curve of L at frequencies (m,) in rad/s, its mirror image and its closure.

    A pole at zero, or at z = 1, is passed on the side of the stable poles' opposite half-plane, so that n of them close
    the curve by n half turns clockwise. Its number comes from the slope of the gain at the lowest frequencies. Beyond
    the highest frequency the curve is closed straight to its mirror image, if it ends near zero, or near the real axis.

    References
    ----------
    Astrom and Murray (2021), Feedback Systems, second edition, section 10.2.
    """
    omega = np.asarray(frequencies, dtype=float)
    curve: Complex = np.asarray(values, dtype=complex)
    omega, curve = omega[omega > 0], curve[omega > 0]
    away = curve - point
    if not np.isfinite(curve).all() or len(curve) < 2:
        return CurveTurns(None, reason="it has a gap")
    if (away == 0).any():
        return CurveTurns(None, reason=f"it meets {number(point)}")
    steps = np.angle(away[1:] / away[:-1])
    if np.abs(steps).max() > LARGEST:
        k = int(np.abs(steps).argmax())
        span = f"{number(omega[k])} and {number(omega[k + 1])} rad/s"
        return CurveTurns(None, reason=f"it turns by more than 120 degrees between the frequencies {span}")
    settled = abs(curve[-1]) < SETTLED * abs(point)
    real = abs(math.remainder(2 * float(np.angle(away[-1])), 2 * math.pi)) < 2 * REAL
    if not (settled or real or (period is not None and omega[-1] > (1 - 1e-3) * math.pi / period)):
        return CurveTurns(None, reason=f"it is not near zero at its highest frequency, {number(omega[-1])} rad/s")
    order = max(0, -low_slope(omega, curve))
    first, last = float(np.angle(away[0])), float(np.angle(away[-1]))
    start = _nearest(2 * first, -order * math.pi)
    total = 2 * float(steps.sum()) + start + _nearest(-2 * last, 0.0)
    return CurveTurns(-round(total / (2 * math.pi)), order)


def _nearest(angle: float, to: float) -> float:
    """The angle plus full turns, as near to another as can be."""
    return to + math.remainder(angle - to, 2 * math.pi)
