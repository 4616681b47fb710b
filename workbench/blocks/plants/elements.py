"""Elements of actuators and sensors: a saturation, a lag, a rate limit, and a transport delay.

A field of an element is one number, which holds for every component of its signal, or a vector with one number for each
component.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import field, replace
from types import MappingProxyType
from typing import Annotated, ClassVar

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, block, initial, parameter
from workbench.core.block import Column, Scalar, Vector, initial_states, quantities
from workbench.core.units import ANY
from workbench.core.validation.refusals import Array, whole

NOISE = "white noise in continuous time has no step, so give the instruments to `digital(period, instruments)`"
MOST_ORDER = 50  # of a Pade approximant: each is a state
Memory = Annotated[Mapping[str, ca.SX], "_own"]  # of an element in the way of the signal v, (n, 1)


@block
class AbstractElement(ABC):
    """An element of an actuator or a sensor: it takes the signal v of a plant and passes on y, in the same unit.

    It stands in the `actuators` or `sensors` of an `EquippedPlant`. The memory of an element, if it has one, moves in
    continuous time by `rate`. If `recursion` is true, it moves from sample to sample by `update` instead. An element
    without a memory serves plants in continuous and in discrete time.

    Parameters
    ----------
    signal
        Name of the signal v: an input of the plant for an actuator, an output for a sensor.
    """

    WAYS: ClassVar[Mapping[str, str]] = MappingProxyType({"Sensor": NOISE, "Instruments": NOISE})

    signal: str
    unit: str = field(default=ANY, init=False)
    state_name: ClassVar[str] = ""  # of its state, where the field with the initial value has another name

    @property
    def recursion(self) -> bool:
        """True if the memory moves from sample to sample."""
        return False

    def memory(self, entry: Entry) -> Layout:
        """The states of the element for a signal, each with one number for each component of the signal."""
        self._refuse_size(entry)
        own = [(self.state_name or e.name, e) for e in initial_states(self).entries]
        return Layout(tuple(replace(e, name=name, default=broadcast(e.default, entry)) for name, e in own))

    def _own(self, size: int) -> Layout:
        """The memory in the way of a signal of that size."""
        entry = Entry(self.signal, np.zeros(size))
        self._refuse_size(entry)
        return self.memory(entry)

    def _refuse_size(self, entry: Entry) -> None:
        """Refuse a signal for whose numbers a vector of the element has another count."""
        for f, quantity in quantities(self):
            value = getattr(self, f.name)
            shape = value.shape if isinstance(value, ca.SX) else np.shape(value)
            size = int(np.prod(shape, dtype=int))
            if quantity.shape == ("*",) and size > 1 and size != entry.size:
                kind = type(self).__name__
                raise ValueError(
                    f"`{kind}({f.name}=...)` of '{self.signal}' must be one number, or one for each number of the "
                    f"signal, which has {entry.size}; got {size}."
                )

    @abstractmethod
    def output(self, z: Memory, v: Column) -> ca.SX:
        """The output y of the element, (k, 1), for the memory z and the input v, (k, 1)."""

    def rate(self, z: Memory, v: Column) -> Mapping[str, ca.SX]:
        """The derivative of each state of the memory z, for the input v, (k, 1); empty without a memory."""
        return {}

    def update(self, z: Memory, v: Column) -> Mapping[str, ca.SX]:
        """The value of each state at the next sample, for the memory z and the input v, (k, 1); empty without one."""
        return {}


@block
class Saturation(AbstractElement):
    """A saturation of a signal v:  y = min(max(v, low), high).

    Parameters
    ----------
    low
        The lower limit of y, less than `high`.
    high
        The upper limit of y.

    Examples
    --------
    >>> wb.EquippedPlant(wb.DCMotor(), actuators=(wb.Saturation("v", low=-12.0, high=12.0),)).inputs.names
    ('v',)
    """

    low: Vector = parameter(unit="{unit}", shape=("*",), symbol="v_min")
    high: Vector = parameter(unit="{unit}", shape=("*",), symbol="v_max")

    def __post_init__(self) -> None:
        if np.any(self.low >= self.high):
            raise ValueError(
                f"`Saturation(low=..., high=...)` of '{self.signal}' must leave room between them; got {self.low} and "
                f"{self.high}."
            )

    def output(self, z: Memory, v: Column) -> ca.SX:
        return within(v, self.low, self.high)


@block
class FirstOrder(AbstractElement):
    """A first-order lag of a signal v, with the transfer function 1 / (T s + 1):  y' = (v - y) / T.

    The state of the lag is the output y. An `EquippedPlant` calls it `v.lag`.

    Parameters
    ----------
    time_constant
        The time constant T.
    start
        The output at t = 0.

    Examples
    --------
    >>> wb.EquippedPlant(wb.DCMotor(), actuators=(wb.FirstOrder("v", time_constant=0.02),)).states.names
    ('omega', 'i', 'v.lag')
    """

    time_constant: Vector = parameter(unit="s", low=0, strict=True, shape=("*",), symbol="T")
    start: Vector = initial(0.0, unit="{unit}", shape=("*",))
    state_name = "lag"

    def output(self, z: Memory, v: Column) -> ca.SX:
        return z["lag"]

    def rate(self, z: Memory, v: Column) -> Mapping[str, ca.SX]:
        return {"lag": (v - z["lag"]) / self.time_constant}


@block
class RateLimit(AbstractElement):
    """A rate limiter with a first-order lag:  y' = min(max((v - y) / T, low), high).

    For a short time constant T, y is close to the output of an ideal rate limiter. The step of a simulation must
    resolve T. While the rate is within its limits, y lags behind v by T. The state is the output y. An `EquippedPlant`
    calls it `v.limited_signal`.

    Parameters
    ----------
    low
        The lowest rate y', a negative number.
    high
        The highest rate y'.
    time_constant
        The time constant T of the lag.
    start
        The output at t = 0.

    Examples
    --------
    >>> limit = wb.RateLimit("v", low=-100.0, high=100.0, time_constant=1e-3)
    >>> wb.EquippedPlant(wb.DCMotor(), actuators=(limit,)).states.names
    ('omega', 'i', 'v.limited_signal')
    """

    low: Vector = parameter(unit="{unit}/s", high=0, strict=True, shape=("*",), symbol="r_min")
    high: Vector = parameter(unit="{unit}/s", low=0, strict=True, shape=("*",), symbol="r_max")
    time_constant: Vector = parameter(unit="s", low=0, strict=True, shape=("*",), symbol="T")
    start: Vector = initial(0.0, unit="{unit}", shape=("*",))
    state_name = "limited_signal"

    def output(self, z: Memory, v: Column) -> ca.SX:
        return z["limited_signal"]

    def rate(self, z: Memory, v: Column) -> Mapping[str, ca.SX]:
        return {"limited_signal": within((v - z["limited_signal"]) / self.time_constant, self.low, self.high)}


@block
class PadeDelay(AbstractElement):
    """A Pade approximation of order n of a transport delay exp(-T s), in balanced realisation.

    Its gain is 1 at all frequencies. Its phase differs from -omega T by less than 0.08 rad up to omega T = n. The delay
    of a computer is a whole number of periods, and needs no approximation: take `digital(period, delay=...)`.

    Parameters
    ----------
    time
        The delay T.
    order
        The order n of numerator and denominator, from 1 to 50. Each component of the signal has n states.
    past
        The constant value of v before t = 0. An exact delay gives it until T; the approximation swings about it.

    Examples
    --------
    >>> wb.EquippedPlant(wb.DCMotor(), actuators=(wb.PadeDelay("v", time=0.1, order=2),)).states.names
    ('omega', 'i', 'v.delayed')
    """

    time: Scalar = parameter(unit="s", low=0, strict=True, symbol="T")
    order: int
    past: Vector = initial(0.0, unit="{unit}", shape=("*",))

    def __post_init__(self) -> None:
        whole("PadeDelay(order=...)", self.order, most=MOST_ORDER)

    def memory(self, entry: Entry) -> Layout:
        """The states of the delay, (n,) or (n, k), scaled: at equilibrium the first is the signal, the others are 0."""
        self._refuse_size(entry)
        first = np.eye(self.order)[0]
        past = broadcast(self.past, entry)
        units = [unit for unit in entry.units for _ in first]
        unit = entry.unit if len(set(units)) == 1 else ", ".join(units)
        return Layout((Entry("delayed", np.multiply.outer(first, past), unit),))

    def output(self, z: Memory, v: Column) -> ca.SX:
        _, _, C, D = pade(self.order)
        return ca.mtimes(z["delayed"].T, ca.DM(C)) + D * v

    def rate(self, z: Memory, v: Column) -> Mapping[str, ca.SX]:
        A, B, _, _ = pade(self.order)
        return {"delayed": (ca.mtimes(ca.DM(A), z["delayed"]) + ca.mtimes(ca.DM(B), v.T)) / self.time}


def pade(order: int) -> tuple[Array, Array, Array, float]:
    r"""The Pade approximant [n/n] of exp(-s) as x' = A x + B v, y = C x + D v: (n, n), (n,), (n,) and a number.

    It is (c - 1) / (c + 1), where c is Lambert's continued fraction of coth(s/2) cut after n terms,

        c = 1/w + 1 / (3/w + 1 / (5/w + ...)),   w = s/2,

    a ladder of n integrators; each scaled to the energy that it holds, both Gramians are the unit matrix. A constant
    signal v rests at x = (v, 0, ..., 0).

    References
    ----------
    NIST Digital Library of Mathematical Functions, equation 4.39.1 (tanh, whose reciprocal is c).
    Glover and Yuan (2012), Balanced realisations of all-pass systems using exact arithmetic, CDC.
    """
    k = np.arange(1, order + 1)
    r = np.sqrt(2.0 * k - 1)
    driven = (k % 2 == order % 2).astype(float)  # those that the signal drives, every second one
    signs = np.where(k[:, None] > k, -1.0, 0.0) * np.outer(driven, 1 - driven)
    A = 2 * np.outer(r, r) * (signs - signs.T - np.outer(driven, driven))
    sign = (-1.0) ** order
    return A, 2 * r * driven, -2 * sign * r * driven, sign


def broadcast(value: Array, entry: Entry) -> Array:
    """One number for each number of a signal."""
    return np.broadcast_to(value, entry.shape)


def within(v: ca.SX, low: Vector, high: Vector) -> ca.SX:
    """The signal, limited to between low and high."""
    return ca.fmin(ca.fmax(v, low), high)
