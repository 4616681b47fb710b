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
    """A block with a number of joints, whose units come from its model."""

    if TYPE_CHECKING:

        @property
        def model(self) -> AbstractArm | None: ...  # noqa: D102

    @property
    def dof(self) -> int:
        """The number of joints n: that of the model, unless the block counts its own."""
        if self.model is None:
            raise AttributeError(f"`{type(self).__name__}` has neither a model nor a `dof` of its own.")
        return int(self.model.dof)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each joint's position, as the block's model has it; any where it has no model."""
        return units_of(self)

    @property
    def position(self) -> str:
        """The unit of the joints' positions, for the units of numbers: rad where there is no model to tell."""
        return unit(motion(units_or_rad(self.units), ("q",)))

    @property
    def force(self) -> str:
        """The unit of the force on the joints, for the units of numbers: N m where there is no model to tell."""
        return unit(torques("tau", units_or_rad(self.units)))


class AbstractArmController(AbstractJoints, AbstractController):
    """A law for an arm with a motor at each joint: from its `estimates`, of q, qd and d, and the wanted motion to the
    torques.
    """

    estimates: ClassVar[tuple[str, ...]] = ("q", "qd")
    hint_on_reads = "It is made for manipulators: take a law of any plant, as `PID` or `StateFeedback` is."

    if TYPE_CHECKING:

        def without(self) -> Mapping[str, AbstractArmController]: ...  # noqa: D102

    @property
    def reads(self) -> Layout:
        """The `estimates`, each (n,)."""
        return _ports(self.units, self.estimates)

    @property
    def follows(self) -> Layout:
        """Wanted positions, velocities and accelerations, each (n,)."""
        return motion(self.units)

    @property
    def drives(self) -> Layout:
        """The torques, (n,)."""
        return torques("tau", self.units)

    @property
    def signal_units(self) -> Mapping[str, str]:
        """The unit of the sliding variable s."""
        return {"s": unit(motion(units_or_rad(self.units), ("qd",)))}

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        """The torques."""
        return Signals(tau=self.torque(t, z, est, ref))

    @abstractmethod
    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        """The command, (n, 1): a torque in N m where a joint turns, a force in N where it slides."""


class AbstractArmObserver(AbstractJoints, AbstractObserver):
    """An observer of an arm that reads its `measured_signals`, of q, qd and, where it uses the truth, d, and gives all
    three.
    """

    measured_signals: ClassVar[tuple[str, ...]] = ("q", "qd")
    hint_on_reads = "It is made for manipulators."

    if TYPE_CHECKING:

        def without(self) -> Mapping[str, AbstractArmObserver]: ...  # noqa: D102

    @property
    def inputs(self) -> Layout:
        """The torques of its model's motors; none where it has no model."""
        model = getattr(self, "model", None)
        return Layout() if model is None else motors(model)

    @property
    def reads(self) -> Layout:
        """The `measured`, each (n,)."""
        return _ports(self.units, self.measured_signals)

    @property
    def gives(self) -> Layout:
        """Positions, velocities and disturbance, each (n,)."""
        return _ports(self.units, ("q", "qd", "d"))


def units_of(block: AbstractJoints) -> tuple[str, ...]:
    """The units of the joints of a block's model, any where it has none."""
    model = getattr(block, "model", None)
    return (ANY,) * block.dof if model is None else tuple(model.units)


def _ports(units: tuple[str, ...], names: Iterable[str]) -> Layout:
    parts = (torques(name, units) if name == "d" else motion(units, (name,)) for name in names)
    return sum(parts, Layout())
