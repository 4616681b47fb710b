"""A wanted signal with its derivatives, and several of them side by side."""

from abc import abstractmethod
from collections import Counter

import casadi as ca
import numpy as np

from workbench.blocks.loop.environment import AbstractReference
from workbench.core import Entry, Layout, Signals, block
from workbench.core.block import Number, quantities
from workbench.core.units import per_second
from workbench.core.validation.refusals import Array

Motion = tuple[ca.SX, ca.SX, ca.SX]  # a signal, its first and its second derivative, each (n, 1)
ROUNDING = 2.0**-50  # more than k h may lack of the decimal number that is meant: 30 times 0.03 is less than 0.9


class AbstractSignal(AbstractReference):
    """A reference signal x(t) of n numbers, with its first and second derivatives xd and xdd.

    Every number of x is one component. A vector field (n,) has one entry for each component; a single number stands for
    n equal ones.

    Parameters
    ----------
    signal
        Name of the signal x. The reference of a loop is named as the output of the plant that follows it: "q" for a
        `Manipulator`. A disturbance is named as an input or an output, see `DisturbedPlant`.
    unit
        Unit of the signal, as "rad"; or one unit for each component, as "m, rad".
    """

    signal: str
    unit: str

    @property
    def dof(self) -> int:
        """The number n of components of the signal: the length of its first vector field."""
        return next(count(getattr(self, field.name)) for field, number in quantities(self) if number.shape == ("n",))

    @abstractmethod
    def motion(self, t: Number) -> Motion:
        """The signal at time t [s], its first and its second derivative, each of shape (n, 1)."""

    @property
    def unit_of_rate(self) -> str:
        """The unit of the first derivative, as "rad/s"."""
        return per_second(self.unit)

    @property
    def unit_of_curvature(self) -> str:
        """The unit of the second derivative, as "rad/s^2"."""
        return per_second(self.unit, 2)

    @property
    def gives(self) -> Layout:
        """The signal and its derivatives, `x`, `xd` and `xdd`, with their units."""
        units = (self.unit, self.unit_of_rate, self.unit_of_curvature)
        return Layout(
            tuple(Entry(self.signal + "d" * order, np.zeros(self.dof), unit) for order, unit in enumerate(units))
        )

    @property
    def primary(self) -> tuple[str, ...]:
        """The name of the signal, without its derivatives."""
        return (self.signal,)

    def at(self, t: Number) -> Signals:
        """The signal and its derivatives at time t [s], by name."""
        return Signals(dict(zip(self.gives.names, self.motion(t), strict=True)))


@block
class CombinedReference(AbstractReference):
    """Several references for different signals, combined into one reference.

    `primary` are the names of all its signals that are not derivatives of another one.

    Parameters
    ----------
    parts
        The references. No two of them may have a signal of the same name.

    Examples
    --------
    >>> both = wb.CombinedReference((wb.Step("h_1", "cm", 12.4), wb.Ramp("h_2", "cm", 0.1)))
    >>> both.primary
    ('h_1', 'h_2')
    """

    parts: tuple[AbstractReference, ...]

    def __post_init__(self) -> None:
        count = Counter(name for part in self.parts for name in part.gives.names)
        if twice := [name for name, times in count.items() if times > 1]:
            raise ValueError(
                "`CombinedReference(parts=...)` must be references of different signals, as a law follows one of "
                f"each name; '{twice[0]}' comes {count[twice[0]]} times."
            )

    @property
    def gives(self) -> Layout:
        """The signals of all parts, with their units."""
        return sum((part.gives for part in self.parts), Layout())

    @property
    def primary(self) -> tuple[str, ...]:
        """The primary signals of all parts: those that are not derivatives."""
        return tuple(name for part in self.parts for name in part.primary)

    def at(self, t: Number) -> Signals:
        """The signals of all parts at time t [s]."""
        return Signals({name: value for part in self.parts for name, value in part.at(t).items()})


def clock(t: Number) -> ca.SX:
    """The time t = k h enlarged by its rounding, for comparison with the instant of an event."""
    return t * (1 + ROUNDING)


def count(value: ca.SX | Array | float) -> int:
    """The length of a vector; one number is a vector of one."""
    shape = shape_of(value)
    return shape[0] if shape else 1


def shape_of(value: ca.SX | Array | float) -> tuple[int, ...]:
    """The shape of numbers or symbols."""
    shape: tuple[int, ...] = value.shape if isinstance(value, ca.SX) else np.shape(value)
    return shape
