"""The weight of the reference in the proportional action, for a limit of the peak from the reference to the output."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.design.matrices import Complex
from workbench.design.pid_design.derivative_action import DerivativeAction
from workbench.design.pid_design.process import Process

FINE = 4.0  # times the frequencies of a search
HALVINGS = 40


@dataclass(frozen=True, eq=False)
class ReferenceResponse:
    """y/r of a loop at the frequencies of a search, by the integral, the proportional and the derivative action."""

    integral: Complex
    proportional: Complex
    derivative: Complex

    @staticmethod
    def of(process: Process, k: float, ki: float, kd: float, N: float | None) -> ReferenceResponse:
        """The response of a process with a PID law, with weights of one."""
        omega = process.frequencies(FINE)[1:]
        s = 1j * omega
        rate = DerivativeAction(kd, N if N is not None else np.inf).response(omega)
        closed = 1 / (process.inverse(omega) + k + ki / s + rate)
        return ReferenceResponse(np.asarray(ki / s * closed), np.asarray(k * closed), np.asarray(rate * closed))

    def peak(self, b: float, c: float) -> float:
        """The largest |y/r| for two weights."""
        return max(1.0, float(np.abs(self.integral + b * self.proportional + c * self.derivative).max()))

    def weight_for(self, peak: float) -> float:
        """The largest b from 0 to 1 with which |y/r| has at most a peak, with c = 0; 0 if none has."""
        low, high = 0.0, 1.0
        if self.peak(1.0, 0.0) <= peak:
            return 1.0
        for _ in range(HALVINGS):  # the peak is a convex function of b, and 1 is beyond
            middle = (low + high) / 2
            low, high = (middle, high) if self.peak(middle, 0.0) <= peak else (low, middle)
        return low
