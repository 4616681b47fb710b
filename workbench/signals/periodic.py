"""References and disturbances as expressions in time, with their exact derivatives and bounds."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

from workbench.core import Layout, Signals, block, parameter
from workbench.core.block import Scalar, Vector
from workbench.loop import AbstractDisturbance, AbstractReference
from workbench.loop.arm import motion
from workbench.validation.shapes import Number


@block
class Sines(AbstractReference):
    """q_i(t) = amplitude_i sin(frequency_i t + phase_i)."""

    amplitude: Vector = parameter(unit="rad", shape=("n",), symbol="a")
    frequency: Vector = parameter(unit="rad/s", shape=("n",), symbol="omega")
    phase: Vector = parameter(default=0.0, unit="rad", shape=("n",), symbol="theta")

    @property
    def dof(self) -> int:
        """The number of joints."""
        return int(self.amplitude.shape[0])

    @property
    def says(self) -> Layout:
        """Positions, velocities and accelerations."""
        return motion(("rad",) * self.dof)

    @property
    def primary(self) -> tuple[str, ...]:
        """The positions."""
        return ("q",)

    def at(self, t: Number) -> Signals:
        """The sines and their exact derivatives."""
        a, w = self.amplitude, self.frequency
        angle = w * t + self.phase
        return Signals(q=a * ca.sin(angle), qd=a * w * ca.cos(angle), qdd=-a * w**2 * ca.sin(angle))


@block
class SquareWave(AbstractReference):
    """q_i(t) = amplitude_i (square(pi f t) + 1) / 2: up at amplitude for 1/f seconds, down at 0 for the next.

    square(x) has the sign of sin(x) and is 1 at x = 0. A jump has no derivative; the derivatives are
    taken to be zero at all times, as if the jumps were not there. `SmoothSquareWave` has true ones.
    """

    amplitude: Vector = parameter(unit="rad", shape=("n",), symbol="a")
    frequency: Scalar = parameter(unit="Hz", low=0, strict=True, symbol="f")

    @property
    def dof(self) -> int:
        """The number of joints."""
        return int(self.amplitude.shape[0])

    @property
    def says(self) -> Layout:
        """Positions, velocities and accelerations."""
        return motion(("rad",) * self.dof)

    @property
    def primary(self) -> tuple[str, ...]:
        """The positions."""
        return ("q",)

    def at(self, t: Number) -> Signals:
        """The wave at t, and zeros for its derivatives."""
        down = ca.fmod(ca.floor(self.frequency * t), 2)
        zero = ca.SX.zeros(self.dof)
        return Signals(q=self.amplitude * (1 - down), qd=zero, qdd=zero)


@block
class SmoothSquareWave(AbstractReference):
    """The square wave with each jump spread over a time `rise`, so that it has exact derivatives.

    q_i(t) = amplitude_i (tanh(sin(pi f t) / (pi f rise)) + 1) / 2: near a jump this is a tanh of
    time over `rise`.
    """

    amplitude: Vector = parameter(unit="rad", shape=("n",), symbol="a")
    frequency: Scalar = parameter(unit="Hz", low=0, strict=True, symbol="f")
    rise: Scalar = parameter(unit="s", low=0, strict=True, symbol="t_r")

    @property
    def dof(self) -> int:
        """The number of joints."""
        return int(self.amplitude.shape[0])

    @property
    def says(self) -> Layout:
        """Positions, velocities and accelerations."""
        return motion(("rad",) * self.dof)

    @property
    def primary(self) -> tuple[str, ...]:
        """The positions."""
        return ("q",)

    def at(self, t: Number) -> Signals:
        """The wave at t with its derivatives, taken by CasADi."""
        w = np.pi * self.frequency
        time = ca.SX.sym("t")
        q = self.amplitude * (ca.tanh(ca.sin(w * time) / (w * self.rise)) + 1) / 2
        qd = ca.jacobian(q, time)
        columns = ca.horzcat(q, qd, ca.jacobian(qd, time))
        parts = ca.horzsplit(ca.substitute(ca.densify(columns), time, t))
        return Signals(dict(zip(self.says.names, parts, strict=True)))


@block
class Hold(AbstractReference):
    """A fixed position."""

    position: Vector = parameter(unit="rad", shape=("n",), symbol="q^*")

    @property
    def dof(self) -> int:
        """The number of joints."""
        return int(self.position.shape[0])

    @property
    def says(self) -> Layout:
        """Positions, velocities and accelerations."""
        return motion(("rad",) * self.dof)

    @property
    def primary(self) -> tuple[str, ...]:
        """The positions."""
        return ("q",)

    def at(self, t: Number) -> Signals:
        """The position, at rest."""
        del t
        zero = ca.SX.zeros(self.dof)
        return Signals(q=ca.SX(self.position), qd=zero, qdd=zero)


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
