"""The ports of a robot arm: positions q, velocities qd, the disturbance d, and the torques tau of its motors."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
import numpy as np

from workbench.arms.dynamics import AbstractArm
from workbench.blocks.loop.contracts import AbstractController, AbstractObserver, Follows, Parts, Reads
from workbench.core import Entry, Layout, Signals
from workbench.core.block import Number
from workbench.core.units import ANY, join_units

ORDERS = {"q": "", "qd": "/s", "qdd": "/s^2"}


def motion(units: Iterable[str], names: Iterable[str] = ORDERS) -> Layout:
    """Positions, velocities and accelerations of joints whose positions have these units."""
    held = tuple(units)
    return _port(tuple((name, tuple(u if u == ANY else f"{u}{ORDERS[name]}" for u in held)) for name in names))


def torques(name: str, units: Iterable[str]) -> Layout:
    """The generalised forces on joints whose positions have these units: N m for rad, N for m."""
    return _port(((name, tuple({"rad": "N m", "m": "N"}.get(unit, ANY) for unit in units)),))


def motors(arm: AbstractArm) -> Layout:
    """The torques of the joints that have a motor."""
    return torques("tau", (arm.units[joint] for joint in arm.motors))


def units_or_rad(units: Iterable[str]) -> tuple[str, ...]:
    """The units of joints, with rad for those whose unit is unknown."""
    return tuple("rad" if each == ANY else each for each in units)


def unit(port: Layout) -> str:
    """The unit of a port of one signal."""
    return port.entries[0].unit


@lru_cache(maxsize=256)  # a loop asks for its ports hundreds of times while it is made
def _port(units_of_each: tuple[tuple[str, tuple[str, ...]], ...]) -> Layout:
    return Layout(tuple(_entry(name, units) for name, units in units_of_each))


def _entry(name: str, units: tuple[str, ...]) -> Entry:
    return Entry(name, np.zeros(len(units)), join_units(units))


class AbstractJoints(ABC):  # noqa: B024 (what is abstract in it is for the type checker)
    """The base class of blocks for an arm, whose number of joints and units come from the model of the arm.

    Parameters
    ----------
    model
        The arm as the designer models it. It may differ from the arm that is simulated.
    """

    if TYPE_CHECKING:

        @property
        def model(self) -> AbstractArm | None: ...  # noqa: D102

    @property
    def dof(self) -> int:
        """The number of joints n."""
        if self.model is None:
            raise AttributeError(f"`{type(self).__name__}` has neither a model nor a `dof` of its own.")
        return int(self.model.dof)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of the position of each joint, from the model; without a model, any unit."""
        return units_of(self)

    @property
    def position(self) -> str:
        """The unit of positions in the units of parameters, one for each joint if they differ; rad without a model."""
        return unit(motion(units_or_rad(self.units), ("q",)))

    @property
    def force(self) -> str:
        """The unit of torques in the units of parameters, one for each joint if they differ; N m without a model."""
        return unit(torques("tau", units_or_rad(self.units)))


class AbstractArmController(AbstractJoints, AbstractController):
    """The base class of laws for arms: from estimates and the reference motion to the torques of the motors.

    In the methods, est has the `estimates` (of q, qd and d), ref the references of q, qd and qdd, and z the memory.
    """

    estimates: ClassVar[tuple[str, ...]] = ("q", "qd")
    hint_on_reads = "It is made for manipulators: take a law of any plant, as `PID` or `StateFeedback` is."

    if TYPE_CHECKING:

        def without(self) -> Mapping[str, AbstractArmController]: ...  # noqa: D102

    @property
    def reads(self) -> Layout:
        """The estimates that the law reads, of shape (n,): q and qd, and d for some laws."""
        return _ports(self.units, self.estimates)

    @property
    def follows(self) -> Layout:
        """The references of positions q, velocities qd and accelerations qdd, each (n,)."""
        return motion(self.units)

    @property
    def drives(self) -> Layout:
        """The commanded torques tau, (n,)."""
        return torques("tau", self.units)

    @property
    def signal_units(self) -> Mapping[str, str]:
        """The unit of the sliding variable s."""
        return {"s": unit(motion(units_or_rad(self.units), ("qd",)))}

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        """The commanded torques tau at time t [s], from the memory z, the estimates est and the references ref."""
        return Signals(tau=self.torque(t, z, est, ref))

    @abstractmethod
    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        """The command, (n, 1): a torque in N m for a joint that turns, a force in N for a joint that slides."""


class AbstractArmObserver(AbstractJoints, AbstractObserver):
    """The base class of observers of arms: from `measured_signals` to estimates of q, qd and the disturbance d.

    The measured signals are q and qd, or one of them, and also d if the observer uses the truth.
    """

    measured_signals: ClassVar[tuple[str, ...]] = ("q", "qd")
    hint_on_reads = "It is made for manipulators."

    if TYPE_CHECKING:

        def without(self) -> Mapping[str, AbstractArmObserver]: ...  # noqa: D102

    @property
    def inputs(self) -> Layout:
        """The torques of the motors of the model; none without a model."""
        model = getattr(self, "model", None)
        return Layout() if model is None else motors(model)

    @property
    def reads(self) -> Layout:
        """The measured signals that the observer reads, each (n,)."""
        return _ports(self.units, self.measured_signals)

    @property
    def gives(self) -> Layout:
        """The estimates of positions q, velocities qd and disturbance d, each (n,)."""
        return _ports(self.units, ("q", "qd", "d"))


def units_of(block: AbstractJoints) -> tuple[str, ...]:
    """The units of the joints of a block's model, any where it has none."""
    model = getattr(block, "model", None)
    return (ANY,) * block.dof if model is None else tuple(model.units)


def _ports(units: tuple[str, ...], names: Iterable[str]) -> Layout:
    parts = (torques(name, units) if name == "d" else motion(units, (name,)) for name in names)
    return sum(parts, Layout())
