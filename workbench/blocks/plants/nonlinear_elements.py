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
    """y = v - min(max(v, low), high): zero from low to high, and v minus the nearer end beyond them.

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
    """y = round(v / q) q in steps of the `quantum` q, by one of three rules of `rounding`; y = v where q is 0.

    Between two edges the derivative is zero, so a design must use the plant without the quantiser. In a loop in
    continuous time v may stay at an edge and y chatter, as with a relay; the error of a number then tells what the step
    of the simulation does. Converters of a computer are declared by `Instruments.of(adc=..., dac=...)`.

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
    """The play of a gear, whose driven side y rests within the `gap` b and is taken along at its ends:

        y = min(max(z, v - b/2), v + b/2),      z' = (y - z) / T,      z(0) = driven;

    without a `time_constant` z is y at the sample before, in discrete time and at the instants of a computer. This is
    the play operator of hysteresis. It is exact if v does not turn within a period, as a held command does not.

    With a `time_constant` T, y is within b/2 of v at all times, and exactly at that distance in contact. Where v turns
    with the curvature v'', y comes to rest v'' T^2 / 2 short of the play. After a jump of v the memory z still lacks
    the share exp(-t/T) of it. So T must be short compared with the turns of v, and the step must resolve T.

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
    driven_side: Vector = initial(default=0.0, unit="{unit}", shape=("*",))

    @property
    def recursion(self) -> bool:
        """True if it has no time constant."""
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
