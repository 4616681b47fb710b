"""The weight of the reference in the proportional action, for a limit of the peak from the reference to the output."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex
from workbench.design.pid_design.pid_designs import PidDesign
from workbench.design.pid_design.process import Process

FINE = 4.0  # times the frequencies of a search
HALVINGS = 40


def weight_for_peak(design: PidDesign, peak: float) -> float:
    """The largest b from 0 to 1 with which |y/r| has at most a peak, with c = 0; 0 if none has."""
    omega, fixed, weighted = _parts(design)
    del omega
    low, high = 0.0, 1.0
    if _peak(fixed, weighted, 1.0) <= peak:
        return 1.0
    for _ in range(HALVINGS):  # the peak is a convex function of b, and 1 is beyond
        middle = (low + high) / 2
        low, high = (middle, high) if _peak(fixed, weighted, middle) <= peak else (low, middle)
    return low


def reference_peak(design: PidDesign) -> float:
    """The peak of |y/r| for the weights of a design, at the frequencies of a search."""
    omega, fixed, weighted = _parts(design)
    if design.N is not None:
        s = 1j * omega
        fixed = fixed + weighted / design.k * design.c * design.kd * s / (1 + s / design.N) if design.k else fixed
    return max(1.0, _peak(fixed, weighted, design.b))


def _parts(design: PidDesign) -> tuple[Array, Complex, Complex]:
    """The frequencies, and y/r by the integral and by the proportional action with b = 1."""
    process = Process.of("tune_pid", design.plant, design.delay)
    omega = process.frequencies(FINE)[1:]
    s = 1j * omega
    law = design.loop_filter
    closed = 1 / (process.inverse(omega) + np.polyval(law.num[0][0], s) / np.polyval(law.den[0][0], s))
    return omega, design.ki / s * closed, design.k * closed


def _peak(fixed: Complex, weighted: Complex, b: float) -> float:
    return float(np.abs(fixed + b * weighted).max())
