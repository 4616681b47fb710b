"""Elements of actuators and sensors: from the signal that comes in to the one that goes out, number by number.

A number of an element is one for all numbers of its signal, or a vector with one for each.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import field, replace
from types import MappingProxyType
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, block, initial, parameter
from workbench.core.block import Vector, initial_states
from workbench.core.port import ANY
from workbench.loop.instruments import quantised

NOISE = (
    "white noise in continuous time has no step, so give the instruments to `digital(period, instruments)`, or take a "
    "`ColouredNoise` in place of that"
)


@block
class AbstractElement(ABC):
    """One element in the way of a signal v, from which its output y follows.

    Parameters
    ----------
    signal
        The name of an input or an output of the plant.
    unit
        That of the signal, which the plant knows.
    """

    WAYS: ClassVar[Mapping[str, str]] = MappingProxyType({"Sensor": NOISE, "Instruments": NOISE})

    signal: str
    unit: str = field(default=ANY, init=False)

    def memory(self, entry: Entry) -> Layout:
        """The element's own states in the way of a signal, one for each of its numbers."""
        return Layout(tuple(replace(own, default=spread(own.default, entry)) for own in initial_states(self).entries))

    @abstractmethod
    def output(self, z: Mapping[str, ca.SX], v: ca.SX) -> ca.SX:
        """What goes out, (k, 1), where v, (k, 1), comes in."""

    def rate(self, z: Mapping[str, ca.SX], v: ca.SX) -> Mapping[str, ca.SX]:
        """The derivative of each of its states."""
        del z, v
        return {}


@block
class Saturation(AbstractElement):
    """y = min(max(v, low), high).

    Parameters
    ----------
    low, high
        The limits, in the unit of the signal.

    Examples
    --------
    >>> wb.Equipped(wb.DCMotor(), actuators=(wb.Saturation("v", low=-12.0, high=12.0),)).inputs.names
    ('v',)
    """

    low: Vector = parameter(unit="{unit}", shape=("*",), symbol="v_min")
    high: Vector = parameter(unit="{unit}", shape=("*",), symbol="v_max")

    def __post_init__(self) -> None:
        _refuse_no_room(self)

    def output(self, z: Mapping[str, ca.SX], v: ca.SX) -> ca.SX:
        """The signal within its limits."""
        del z
        return _within(v, self.low, self.high)


@block
class DeadZone(AbstractElement):
    """y = v - min(max(v, low), high): nothing between low and high, and what is beyond them.

    Parameters
    ----------
    low, high
        The ends of the zone, in the unit of the signal.
    """

    low: Vector = parameter(unit="{unit}", shape=("*",), symbol="v_min")
    high: Vector = parameter(unit="{unit}", shape=("*",), symbol="v_max")

    def __post_init__(self) -> None:
        _refuse_no_room(self)

    def output(self, z: Mapping[str, ca.SX], v: ca.SX) -> ca.SX:
        """What is beyond the zone."""
        del z
        return v - _within(v, self.low, self.high)


@block
class Quantiser(AbstractElement):
    """y = floor(v / quantum + 1/2) quantum, the nearest multiple of the quantum; y = v where that is 0.

    Parameters
    ----------
    quantum
        The height of a step, in the unit of the signal.
    """

    quantum: Vector = parameter(unit="{unit}", low=0, shape=("*",), symbol="b")

    def output(self, z: Mapping[str, ca.SX], v: ca.SX) -> ca.SX:
        """The signal in steps."""
        del z
        return quantised(v, self.quantum + 0 * v)


@block
class FirstOrder(AbstractElement):
    """The lag of first order, 1 / (T s + 1):  y' = (v - y) / T,  y(0) = lag.

    Parameters
    ----------
    time_constant
        T, in s.
    lag
        y at the start, in the unit of the signal.

    Examples
    --------
    >>> wb.Equipped(wb.DCMotor(), actuators=(wb.FirstOrder("v", time_constant=0.02),)).states.names
    ('omega', 'i', 'v.lag')
    """

    time_constant: Vector = parameter(unit="s", low=0, strict=True, shape=("*",), symbol="T")
    lag: Vector = initial(0.0, unit="{unit}", shape=("*",))

    def output(self, z: Mapping[str, ca.SX], v: ca.SX) -> ca.SX:
        """The lag's state."""
        del v
        return z["lag"]

    def rate(self, z: Mapping[str, ca.SX], v: ca.SX) -> Mapping[str, ca.SX]:
        """The lag."""
        return {"lag": (v - z["lag"]) / self.time_constant}


@block
class SecondOrder(AbstractElement):
    """The lag of second order, omega_n^2 / (s^2 + 2 zeta omega_n s + omega_n^2):

    y'' = omega_n^2 (v - y) - 2 zeta omega_n y',  y(0) = lag,  y'(0) = lag_rate.

    Parameters
    ----------
    natural_frequency, damping
        omega_n in rad/s, and zeta.
    lag, lag_rate
        y and y' at the start, in the unit of the signal and that per second.
    """

    natural_frequency: Vector = parameter(unit="rad/s", low=0, strict=True, shape=("*",), symbol="omega_n")
    damping: Vector = parameter(unit="1", low=0, shape=("*",), symbol="zeta")
    lag: Vector = initial(0.0, unit="{unit}", shape=("*",))
    lag_rate: Vector = initial(0.0, unit="{unit}/s", shape=("*",))

    def output(self, z: Mapping[str, ca.SX], v: ca.SX) -> ca.SX:
        """The lag's state."""
        del v
        return z["lag"]

    def rate(self, z: Mapping[str, ca.SX], v: ca.SX) -> Mapping[str, ca.SX]:
        """The lag."""
        omega_n, zeta = self.natural_frequency, self.damping
        return {"lag": z["lag_rate"], "lag_rate": omega_n**2 * (v - z["lag"]) - 2 * zeta * omega_n * z["lag_rate"]}


@block
class RateLimit(AbstractElement):
    """A lag whose rate has limits:  y' = min(max((v - y) / T, low), high),  y(0) = limited.

    The shorter T, the nearer is y to the ideal limiter, whose rate is v' wherever the limits allow it; beside a change
    within the limits y is late by T.

    Parameters
    ----------
    low, high
        The lowest rate, negative, and the highest, positive, in the unit of the signal per second.
    time_constant
        T in s, which the step of a simulation must resolve.
    limited
        y at the start, in the unit of the signal.

    Examples
    --------
    >>> limit = wb.RateLimit("v", low=-100.0, high=100.0, time_constant=1e-3)
    >>> wb.Equipped(wb.DCMotor(), actuators=(limit,)).states.names
    ('omega', 'i', 'v.limited')
    """

    low: Vector = parameter(unit="{unit}/s", high=0, strict=True, shape=("*",), symbol="r_min")
    high: Vector = parameter(unit="{unit}/s", low=0, strict=True, shape=("*",), symbol="r_max")
    time_constant: Vector = parameter(unit="s", low=0, strict=True, shape=("*",), symbol="T")
    limited: Vector = initial(0.0, unit="{unit}", shape=("*",))

    def output(self, z: Mapping[str, ca.SX], v: ca.SX) -> ca.SX:
        """The limiter's state."""
        del v
        return z["limited"]

    def rate(self, z: Mapping[str, ca.SX], v: ca.SX) -> Mapping[str, ca.SX]:
        """The lag within its limits."""
        return {"limited": _within((v - z["limited"]) / self.time_constant, self.low, self.high)}


@block
class Backlash(AbstractElement):
    """The play of a gear:  y' = (e - min(max(e, -gap/2), gap/2)) / T  with e = v - y,  y(0) = driven.

    Within the gap y rests; at its edges v takes y with it. It is the play operator of hysteresis, whose contact is
    spread over T (the Yosida approximation of its differential inclusion): as T goes to 0, y goes to the play of v.

    Parameters
    ----------
    gap
        The whole width of the gap, in the unit of the signal.
    time_constant
        T in s, by which y is late in contact, and which the step of a simulation must resolve.
    driven
        y at the start, in the unit of the signal.

    References
    ----------
    Visintin (1994), Differential Models of Hysteresis.
    Gelb and Vander Velde (1968), Multiple-Input Describing Functions and Nonlinear System Design, appendix B.
    """

    gap: Vector = parameter(unit="{unit}", low=0, shape=("*",), symbol="b")
    time_constant: Vector = parameter(unit="s", low=0, strict=True, shape=("*",), symbol="T")
    driven: Vector = initial(0.0, unit="{unit}", shape=("*",))

    def output(self, z: Mapping[str, ca.SX], v: ca.SX) -> ca.SX:
        """The side that is driven."""
        del v
        return z["driven"]

    def rate(self, z: Mapping[str, ca.SX], v: ca.SX) -> Mapping[str, ca.SX]:
        """The side that is driven rests in the gap, and moves with what is beyond it."""
        e = v - z["driven"]
        return {"driven": (e - _within(e, -self.gap / 2, self.gap / 2)) / self.time_constant}


def spread(value: Any, entry: Entry) -> Any:
    """One number for each number of a signal."""
    return np.broadcast_to(value, entry.shape)


def _within(v: ca.SX, low: Vector, high: Vector) -> ca.SX:
    return ca.fmin(ca.fmax(v, low), high)


def _refuse_no_room(element: Saturation | DeadZone) -> None:
    if np.any(element.low >= element.high):
        raise ValueError(
            f"`{type(element).__name__}(low=..., high=...)` of '{element.signal}' must leave room between them; got "
            f"{element.low} and {element.high}."
        )
