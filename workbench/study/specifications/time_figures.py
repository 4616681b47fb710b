"""The bandwidth of an answer and the figures of its step, by the certified ones of `design.frequency`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from workbench.design.frequency import CertifiedValue

from workbench.design.linear.system_answers import step_answers
from workbench.study.loop_pictures import step_info

FIGURE_OF = {"overshoot": "overshoot", "settling_time": "settling_time", "rise_time": "rise_time"}


def bandwidth_of(system: Any) -> tuple[CertifiedValue, bool]:
    """The first frequency in rad/s at which the gain falls 3 dB below that at zero; True as its bounds are proved."""
    from workbench.design.frequency import bandwidth

    return bandwidth(system).frequency, True


def step_figure_of(system: Any, name: str) -> tuple[CertifiedValue, bool]:
    """A figure of the step answer, with twice its change by half of the samples as its error, which is an estimate.

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
    error = 2 * abs(fine - coarse) + 1e-9 * abs(fine) if math.isfinite(coarse) else abs(fine)
    if system.dt:
        error = 0.0 if name == "overshoot" else float(system.dt)
    return CertifiedValue(fine, max(fine - error, 0.0), fine + error), False


__all__ = ["FIGURE_OF", "bandwidth_of", "np", "step_figure_of"]
