"""Full state: the instruments are believed."""

from __future__ import annotations

from typing import ClassVar

import casadi as ca

from workbench.core import Layout, block
from workbench.core.dynamics import MOST_JOINTS
from workbench.loop.contracts import AbstractObserver
from workbench.loop.ports import Estimate, Measurement, Parts
from workbench.validation.shapes import Column, Number
from workbench.validation.words import whole


@block
class FullState(AbstractObserver):
    """Positions and velocities as they are measured, and no disturbance: q_hat = q, qd_hat = qd, D_hat = 0.

    Parameters
    ----------
    joints
        How many there are.

    Raises
    ------
    ValueError
        If `joints` is not a positive whole number.
    """

    noun: ClassVar[str] = ""  # no observer at all

    joints: int

    def __post_init__(self) -> None:
        whole("FullState(joints=...)", self.joints, most=MOST_JOINTS, of=" of joints")

    @property
    def dof(self) -> int:
        """The number of joints."""
        return self.joints

    @property
    def uses_truth(self) -> bool:
        """No: a velocity can be measured."""
        return False

    @property
    def memory(self) -> Layout:
        """None."""
        return Layout()

    def estimate(self, t: Number, z: Parts, y: Measurement) -> Estimate:
        """What the instruments say."""
        del t, z
        return Estimate(y.q, y.qd, ca.SX.zeros(self.dof))

    def rate(self, t: Number, z: Parts, y: Measurement, est: Estimate, tau: Column) -> Parts:
        """Nothing to remember."""
        del t, z, y, est, tau
        return {}
