"""What acts at the joints of an arm: drives, from the torque that is commanded to the one that acts, and friction."""

from __future__ import annotations

from abc import ABC, abstractmethod
from copy import copy
from typing import Self

import casadi as ca

from workbench.core import Layout, block, parameter
from workbench.core.block import Column, Scalar, Vector
from workbench.core.dynamics import MOST_JOINTS
from workbench.loop.arm import torques
from workbench.loop.contracts import Parts
from workbench.validation.refusals import whole
from workbench.validation.signatures import door


class AbstractAtJoints:
    """What has a number for each of some joints.

    Attributes
    ----------
    units
        The unit of each joint's position, which the arm tells; rad where none are given.
    """

    units: tuple[str, ...] = ()

    @door
    def at(self, units: tuple[str, ...]) -> Self:
        """The same at joints whose positions have these units."""
        part = copy(self)
        object.__setattr__(part, "units", units)
        return part

    @property
    def force(self) -> str:
        """The unit of what acts, joint by joint where they differ: N m where one turns, N where it slides."""
        return torques("tau", self.units or ("rad",))["tau"].unit


class AbstractActuator(AbstractAtJoints, ABC):
    """A drive at each joint that has a motor."""

    @abstractmethod
    def memory(self, motors: int) -> Layout:
        """The drives' own states for that many motors."""

    @abstractmethod
    def applied(self, z: Parts, tau: Column) -> ca.SX:
        """The torque that acts, (motors, 1), in N m or N."""

    @abstractmethod
    def rate(self, z: Parts, tau: Column) -> Parts:
        """The derivative of each state."""


@block
class DirectDrive(AbstractActuator):
    """The torque acts at once, within -limit and limit where there is one."""

    limit: Vector | None = parameter(default=None, unit="{force}", low=0, strict=True, shape=("n",), symbol="tau_max")

    def memory(self, motors: int) -> Layout:
        """None."""
        del motors
        return Layout()

    def applied(self, z: Parts, tau: Column) -> ca.SX:
        """The command, limited."""
        del z
        return _limited(tau, self.limit)

    def rate(self, z: Parts, tau: Column) -> Parts:
        """Nothing to drive."""
        del z, tau
        return {}


@block
class FirstOrderLag(AbstractActuator):
    """The torque follows the (limited) command: tau_m' = (tau - tau_m) / time_constant, tau_m(0) = 0."""

    time_constant: Scalar = parameter(unit="s", low=0, strict=True, symbol="T_m")
    limit: Vector | None = parameter(default=None, unit="{force}", low=0, strict=True, shape=("n",), symbol="tau_max")

    def memory(self, motors: int) -> Layout:
        """The torque of each motor."""
        count = whole("memory(motors=...)", motors, most=MOST_JOINTS)
        return torques("tau_m", self.units or ("rad",) * count)

    def applied(self, z: Parts, tau: Column) -> ca.SX:
        """The motor's torque, whatever is commanded now."""
        del tau
        return z["tau_m"]

    def rate(self, z: Parts, tau: Column) -> Parts:
        """The lag."""
        return {"tau_m": (_limited(tau, self.limit) - z["tau_m"]) / self.time_constant}


def _limited(tau: ca.SX, limit: Vector | None) -> ca.SX:
    return tau if limit is None else ca.fmin(ca.fmax(tau, -limit), limit)


@block
class Friction(AbstractAtJoints):
    """F(qd) = viscous qd + coulomb tanh(qd / speed): Coulomb friction with its jump spread over `speed`."""

    viscous: Vector = parameter(unit="{force_by_speed}", low=0, shape=("n",), symbol="b")
    coulomb: Vector = parameter(unit="{force}", low=0, shape=("n",), symbol="f_c")
    speed: Scalar = parameter(default=0.01, unit="{speed_unit}", low=0, strict=True, symbol="v_s")

    @property
    def force_by_speed(self) -> str:
        """The unit of viscous friction, joint by joint where they differ."""
        return ", ".join(f"{force} s/{'m' if force == 'N' else 'rad'}" for force in self.force.split(", "))

    @property
    def speed_unit(self) -> str:
        """The unit of a speed; of both where some joints turn and others slide."""
        return " or ".join(dict.fromkeys(f"{unit}/s" for unit in self.units or ("rad",)))

    def torque(self, qd: Column) -> ca.SX:
        """F(qd), (n, 1), in N m or N."""
        friction: ca.SX = self.viscous * qd + self.coulomb * ca.tanh(qd / self.speed)
        return friction
