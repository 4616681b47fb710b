"""Disturbances of an arm, with their bounds."""

from __future__ import annotations

import math

import casadi as ca

from workbench.core import block, parameter
from workbench.core.block import Number, Vector
from workbench.loop.surroundings import AbstractDisturbance


@block
class SineTorque(AbstractDisturbance):
    """D_i(t) = amplitude_i sin(frequency_i t + phase_i)."""

    amplitude: Vector = parameter(unit="N m", shape=("n",), symbol="delta")
    frequency: Vector = parameter(unit="rad/s", shape=("n",), symbol="omega_d")
    phase: Vector = parameter(default=0.0, unit="rad", shape=("n",), symbol="theta_d")

    @property
    def dof(self) -> int:
        """The number of joints."""
        return int(self.amplitude.shape[0])

    def at(self, t: Number) -> ca.SX:
        """The sines."""
        torque: ca.SX = self.amplitude * ca.sin(self.frequency * t + self.phase)
        return torque

    @property
    def D_max(self) -> float:
        """The norm of the amplitudes: reached if all sines peak at once."""
        return math.hypot(*map(float, self.amplitude))

    @property
    def L_D(self) -> float:
        """The norm of amplitude times frequency: reached if all slopes peak at once."""
        return math.hypot(*(float(a) * float(w) for a, w in zip(self.amplitude, self.frequency, strict=True)))
