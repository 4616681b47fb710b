"""Signals that hold, jump, or go straight."""

import casadi as ca

from workbench.core import block, parameter
from workbench.core.block import Number, Vector
from workbench.signals.signal import AbstractSignal, Motion, clock


@block
class Hold(AbstractSignal):
    """A fixed value.

    Examples
    --------
    >>> wb.Hold([0.5, 0.0]).at(3.0).q
    SX([0.5, 0])
    """

    position: Vector = parameter(unit="{unit}", shape=("n",), symbol="q^*")
    signal: str = "q"
    unit: str = "rad"

    def motion(self, t: Number) -> Motion:
        zero = ca.SX.zeros(self.dof)
        return ca.SX(self.position), zero, zero


@block
class Step(AbstractSignal):
    """x_i(t) = start_i before time_i, level_i from then on; the derivatives are zero at all times.

    Examples
    --------
    >>> wb.Step("omega", "rad/s", level=1.0, time=0.1).at(0.2).omega
    SX(1)
    """

    signal: str
    unit: str
    level: Vector = parameter(unit="{unit}", shape=("n",), symbol="x_1")
    time: Vector = parameter(default=0.0, unit="s", low=0, shape=("n",), symbol="t_s")
    start: Vector = parameter(default=0.0, unit="{unit}", shape=("n",), symbol="x_0")

    def motion(self, t: Number) -> Motion:
        zero = ca.SX.zeros(self.dof)
        return ca.if_else(clock(t) >= self.time, ca.SX(self.level), ca.SX(self.start)), zero, zero


@block
class Ramp(AbstractSignal):
    """x_i(t) = start_i before time_i, start_i + slope_i (t - time_i) from then on.

    Examples
    --------
    >>> wb.Ramp("h", "m", slope=0.01, time=5.0, start=0.1).at(10.0).h
    SX(0.15)
    """

    signal: str
    unit: str
    slope: Vector = parameter(unit="{unit_of_rate}", shape=("n",), symbol="v")
    time: Vector = parameter(default=0.0, unit="s", low=0, shape=("n",), symbol="t_s")
    start: Vector = parameter(default=0.0, unit="{unit}", shape=("n",), symbol="x_0")

    def motion(self, t: Number) -> Motion:
        rate = ca.if_else(clock(t) >= self.time, ca.SX(self.slope), 0)
        return self.start + self.slope * ca.fmax(t - self.time, 0), rate, ca.SX.zeros(self.dof)
