"""From the torque that is commanded to the torque that acts."""

from __future__ import annotations

from abc import ABC, abstractmethod

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, block, parameter
from workbench.core.block import Scalar, Vector
from workbench.core.dynamics import MOST_JOINTS
from workbench.loop.contracts import Parts
from workbench.validation.shapes import Column
from workbench.validation.words import whole


class AbstractActuator(ABC):
    """A drive at each joint."""

    @abstractmethod
    def memory(self, dof: int) -> Layout:
        """The drive's own states for that many joints."""

    @abstractmethod
    def applied(self, z: Parts, tau: Column) -> ca.SX:
        """The torque that acts, (n, 1), in N m."""

    @abstractmethod
    def rate(self, z: Parts, tau: Column) -> Parts:
        """The derivative of each state."""


@block
class DirectDrive(AbstractActuator):
    """The torque acts at once, within -limit and limit where there is one."""

    limit: Vector | None = parameter(default=None, unit="N m", low=0, strict=True, shape=("n",), symbol="tau_max")

    def memory(self, dof: int) -> Layout:
        """None."""
        del dof
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
    limit: Vector | None = parameter(default=None, unit="N m", low=0, strict=True, shape=("n",), symbol="tau_max")

    def memory(self, dof: int) -> Layout:
        """The torque of each motor."""
        return Layout((Entry("tau_m", np.zeros(whole("memory(dof=...)", dof, most=MOST_JOINTS)), "N m"),))

    def applied(self, z: Parts, tau: Column) -> ca.SX:
        """The motor's torque, whatever is commanded now."""
        del tau
        return z["tau_m"]

    def rate(self, z: Parts, tau: Column) -> Parts:
        """The lag."""
        return {"tau_m": (_limited(tau, self.limit) - z["tau_m"]) / self.time_constant}


def _limited(tau: ca.SX, limit: Vector | None) -> ca.SX:
    return tau if limit is None else ca.fmin(ca.fmax(tau, -limit), limit)
