"""Elements with corners and jumps: a dead zone, a quantiser, and backlash with its memory."""

from collections.abc import Mapping

import casadi as ca
import numpy as np

from workbench.blocks.loop.quantisation import ROUNDING, quantise, refuse_quantum
from workbench.blocks.plants.elements import AbstractElement, Memory, within
from workbench.core import block, initial, option, parameter
from workbench.core.block import Column, Vector


@block
class DeadZone(AbstractElement):
    """A dead zone of a signal v:  y = v - min(max(v, low), high).

    The output is zero for v from `low` to `high`. Outside, it is v minus the nearer of the two.

    Parameters
    ----------
    low
        The lower end of the dead zone.
    high
        The upper end of the dead zone, at least `low`.

    Examples
    --------
    >>> motor = wb.EquippedPlant(wb.DCMotor(), actuators=(wb.DeadZone("v", low=-0.5, high=0.5),))
    >>> motor.inputs.names
    ('v',)
    """

    low: Vector = parameter(unit="{unit}", shape=("*",), symbol="v_min")
    high: Vector = parameter(unit="{unit}", shape=("*",), symbol="v_max")

    def __post_init__(self) -> None:
        if np.any(self.low > self.high):
            raise ValueError(
                f"`DeadZone(low=..., high=...)` of '{self.signal}' must have low <= high; got {self.low} and "
                f"{self.high}."
            )

    def output(self, z: Memory, v: Column) -> ca.SX:
        return v - within(v, self.low, self.high)


@block
class Quantiser(AbstractElement):
    """A quantiser of a signal v:  y = round(v / q) q, a multiple of the `quantum` q.

    The derivative of y is zero between two steps, so a design must use the plant without the quantiser. In a loop in
    continuous time v may stay where y jumps, and y then chatters as the output of a relay does. The estimated error of
    a metric then shows the effect of the step of the simulation. Converters of a computer are declared by
    `Instruments.of(adc=..., dac=...)`.

    Parameters
    ----------
    quantum
        The step q between two values of y; y = v for q = 0.
    rounding
        The rule of rounding.

    Examples
    --------
    >>> encoder = wb.Quantiser("theta", quantum=2 * np.pi / 1024)
    >>> wb.EquippedPlant(wb.DCMotor(measurement="position"), sensors=(encoder,)).truths.names
    ('theta_true',)
    """

    quantum: Vector = parameter(unit="{unit}", low=0, shape=("*",), symbol="q")
    rounding: str = option(ROUNDING, default="nearest")

    def __post_init__(self) -> None:
        refuse_quantum("Quantiser(quantum=...)", self.signal, self.quantum)

    def output(self, z: Memory, v: Column) -> ca.SX:
        return quantise(v, self.quantum + 0 * v, self.rounding)


@block
class Backlash(AbstractElement):
    """The backlash (play) of a gear: the driven side y stays still until the driving side v has crossed the gap b.

        y = min(max(z, v - b/2), v + b/2),      z' = (y - z) / T        with a time constant T

    Without a time constant, z is the value of y at the sample before. The element is then the play operator of
    hysteresis, in discrete time or at the instants of a computer. It is exact if v does not reverse within a period,
    and a held command does not.

    With a time constant T, the distance of y to v is at most b/2, and exactly b/2 in contact. Where v reverses with the
    second derivative v'', y stops v'' T^2 / 2 before the play operator would. After a jump of v, the fraction exp(-t/T)
    of the jump is still missing in z. So T must be short compared with the time between reversals of v, and the step of
    a simulation must resolve T.

    The state is z. An `EquippedPlant` calls it `v.driven_side`.

    Parameters
    ----------
    gap
        The width b of the gap.
    time_constant
        The time constant T, or None for the play operator.
    start
        The driven side z at t = 0.

    References
    ----------
    Visintin (1994), Differential Models of Hysteresis, section III.2.
    Gelb and Vander Velde (1968), Multiple-Input Describing Functions and Nonlinear System Design, appendix B.

    Examples
    --------
    >>> gear = wb.Backlash("theta", gap=0.02, time_constant=1e-3)
    >>> wb.EquippedPlant(wb.DCMotor(measurement="position"), sensors=(gear,)).states.names
    ('theta', 'omega', 'i', 'theta.driven_side')
    """

    gap: Vector = parameter(unit="{unit}", low=0, shape=("*",), symbol="b")
    time_constant: Vector = parameter(default=None, unit="s", low=0, strict=True, shape=("*",), symbol="T")
    start: Vector = initial(default=0.0, unit="{unit}", shape=("*",))
    state_name = "driven_side"

    @property
    def recursion(self) -> bool:
        """True if there is no time constant: the memory then moves from sample to sample."""
        return self.time_constant is None

    def output(self, z: Memory, v: Column) -> ca.SX:
        return within(z["driven_side"], v - self.gap / 2, v + self.gap / 2)

    def rate(self, z: Memory, v: Column) -> Mapping[str, ca.SX]:
        if self.time_constant is None:
            raise ValueError(
                "`Backlash.rate(...)` needs a `time_constant`: without one its memory moves from sample to sample, by "
                "`update`."
            )
        return {"driven_side": (self.output(z, v) - z["driven_side"]) / self.time_constant}

    def update(self, z: Memory, v: Column) -> Mapping[str, ca.SX]:
        return {"driven_side": self.output(z, v)}
