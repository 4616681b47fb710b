"""The bandwidth of a stable answer, with proved bounds, and the figures of its step, with an estimated error."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from workbench.design.frequency import CertifiedValue
from workbench.design.frequency.axis_loop import AxisLoop, axis_loop
from workbench.design.frequency.certified_values import INFINITE
from workbench.design.frequency.integer_polynomials import add, scale, trim
from workbench.design.frequency.positive_roots import positive_roots
from workbench.design.linear.system_answers import step_answers
from workbench.study.loop_pictures import step_info

DROP = 10**-0.3  # of the square of the gain: 3 dB
DOUBT = 4e-16  # relative, of that double
NOISE = 1e-9  # relative, of a figure of a step that is computed by matrix exponentials


def bandwidth_of(system: Any) -> CertifiedValue:
    """The first frequency in rad/s at which the gain of a stable system falls 3 dB below its gain at zero.

    Raises
    ------
    ValueError
        If it passes nothing at the frequency zero.
    """
    axis = axis_loop("bandwidth", system, 0.0)
    if not axis.A or not axis.A[0]:
        raise ValueError("the answer passes nothing at the frequency zero, from which a bandwidth is counted")
    start = Fraction(axis.A[0], axis.B[0])
    near, far = (_first_crossing(axis, start * Fraction(DROP * (1 + sign * DOUBT))) for sign in (1, -1))
    if near is None or far is None:
        return INFINITE
    return CertifiedValue(near.low / 2 + far.high / 2, min(near.low, far.low), max(near.high, far.high))


def _first_crossing(axis: AxisLoop, square: Fraction) -> CertifiedValue | None:
    """The first frequency at which the square of the gain meets a level below the one at zero."""
    excess = trim(add(scale(axis.A, square.denominator), scale(axis.B, -square.numerator)))
    roots = [root for root in positive_roots(excess) if root.multiplicity % 2]
    return axis.frequency(roots[0]) if roots else None


def step_figure_of(system: Any, name: str) -> CertifiedValue:
    """The overshoot in %, the settling time or the rise time in s of a step answer.

    Its bounds are estimates: twice the change by half of the samples, in a computer a period.

    Raises
    ------
    ValueError
        If the answer tends to no value, or does not get so far.
    """
    t, y, final = step_answers(system)
    end, values = float(final[0, 0]), y[0, 0]
    if not math.isfinite(end) or end == values[0]:
        raise ValueError("the step answer does not tend to another value than its first")
    fine, coarse = (float(getattr(step_info(t[::k], values[::k], end), name)) for k in (1, 2))
    if not math.isfinite(fine):
        raise ValueError(f"the step answer has no {name.replace('_', ' ')} within {t[-1]:.4g} s")
    if system.dt:
        error = NOISE * abs(fine) if name == "overshoot" else float(system.dt)
    else:
        error = 2 * abs(fine - coarse) + NOISE * abs(fine) if math.isfinite(coarse) else abs(fine)
    return CertifiedValue(fine, max(fine - error, 0.0), fine + error)
