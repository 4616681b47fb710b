"""Signals that repeat."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.core import block, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.signals.signal import AbstractSignal, Motion, clock, count


@block
class Sines(AbstractSignal):
    """x_i(t) = amplitude_i sin(frequency_i t + phase_i).

    Examples
    --------
    >>> wb.Sines(amplitude=[1.0, 0.5], frequency=[2.0, 3.0]).at(0.0).qd
    SX([2, 1.5])
    """

    amplitude: Vector = parameter(unit="{unit}", shape=("n",), symbol="a")
    frequency: Vector = parameter(unit="rad/s", shape=("n",), symbol="omega")
    phase: Vector = parameter(default=0.0, unit="rad", shape=("n",), symbol="theta")
    signal: str = "q"
    unit: str = "rad"

    @property
    def dof(self) -> int:
        """How many numbers it has, n."""
        return count(self.amplitude)

    def motion(self, t: Number) -> Motion:
        """The sines and their exact derivatives."""
        a, w = self.amplitude, self.frequency
        angle = w * t + self.phase
        return a * ca.sin(angle), a * w * ca.cos(angle), -a * w**2 * ca.sin(angle)


@block
class SquareWave(AbstractSignal):
    """x_i(t) = amplitude_i (square(pi f t) + 1) / 2: up at amplitude for 1/f seconds, down at 0 for the next.

    square(x) has the sign of sin(x) and is 1 at x = 0. A jump has no derivative; the derivatives are
    taken to be zero at all times, as if the jumps were not there. `SmoothSquareWave` has true ones.
    """

    amplitude: Vector = parameter(unit="{unit}", shape=("n",), symbol="a")
    frequency: Scalar = parameter(unit="Hz", low=0, strict=True, symbol="f")
    signal: str = "q"
    unit: str = "rad"

    @property
    def dof(self) -> int:
        """How many numbers it has, n."""
        return count(self.amplitude)

    def motion(self, t: Number) -> Motion:
        """The wave at t, and zeros for its derivatives."""
        down = ca.fmod(ca.floor(self.frequency * t), 2)
        zero = ca.SX.zeros(self.dof)
        return self.amplitude * (1 - down), zero, zero


@block
class SmoothSquareWave(AbstractSignal):
    """The square wave with each jump spread over a time `rise`, so that it has exact derivatives.

    x_i(t) = amplitude_i (tanh(sin(pi f t) / (pi f rise)) + 1) / 2: near a jump this is a tanh of
    time over `rise`.
    """

    amplitude: Vector = parameter(unit="{unit}", shape=("n",), symbol="a")
    frequency: Scalar = parameter(unit="Hz", low=0, strict=True, symbol="f")
    rise: Scalar = parameter(unit="s", low=0, strict=True, symbol="t_r")
    signal: str = "q"
    unit: str = "rad"

    @property
    def dof(self) -> int:
        """How many numbers it has, n."""
        return count(self.amplitude)

    def motion(self, t: Number) -> Motion:
        """The wave at t with its derivatives, taken by CasADi."""
        w = np.pi * self.frequency
        time = ca.SX.sym("t")
        q = self.amplitude * (ca.tanh(ca.sin(w * time) / (w * self.rise)) + 1) / 2
        qd = ca.jacobian(q, time)
        columns = ca.horzcat(q, qd, ca.jacobian(qd, time))
        x, xd, xdd = ca.horzsplit(ca.substitute(ca.densify(columns), time, t))
        return x, xd, xdd


@block
class PulseTrain(AbstractSignal):
    """From `time` on a pulse of height `level` and length `width` at the begin of every `period`; `base` elsewhere.

    A jump has no derivative; the derivatives are zero at all times, as if the jumps were not there.

    Raises
    ------
    ValueError
        If a pulse is not shorter than the period.

    Examples
    --------
    >>> wb.PulseTrain("v", "V", level=12.0, period=1.0, width=0.2).at(0.1).v
    SX(12)
    """

    signal: str
    unit: str
    level: Vector = parameter(unit="{unit}", shape=("n",), symbol="x_1")
    period: Scalar = parameter(unit="s", low=0, strict=True, symbol="P")
    width: Scalar = parameter(unit="s", low=0, strict=True, symbol="w")
    time: Scalar = parameter(default=0.0, unit="s", low=0, symbol="t_s")
    base: Vector = parameter(default=0.0, unit="{unit}", shape=("n",), symbol="x_0")

    def __post_init__(self) -> None:
        if self.width >= self.period:
            raise ValueError(
                f"`PulseTrain(width=...)` must be less than the period of {self.period:g} s, or pulses are one; got "
                f"{self.width:g} s."
            )

    @property
    def dof(self) -> int:
        """How many numbers it has, n."""
        return count(self.level)

    def motion(self, t: Number) -> Motion:
        """The pulses, and zeros for their derivatives."""
        before = (self.width - self.period) / 2  # amid a gap, where the time waits for the first begin
        s, zero = ca.fmax(clock(t) - self.time, before), ca.SX.zeros(self.dof)
        up = s - self.period * ca.floor(s / self.period) < self.width
        return ca.if_else(up, ca.SX(self.level), ca.SX(self.base)), zero, zero
