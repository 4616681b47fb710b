"""Full state: the instruments are believed."""

from __future__ import annotations

from typing import ClassVar

import casadi as ca

from workbench.core import Signals, block
from workbench.core.block import Number
from workbench.core.dynamics import MOST_JOINTS
from workbench.loop.arm_ports import AbstractArmObserver
from workbench.loop.contracts import Parts, Reads
from workbench.validation.refusals import whole


@block
class FullState(AbstractArmObserver):
    """Positions and velocities as they are measured, and no disturbance: q_hat = q, qd_hat = qd, D_hat = 0.

    Parameters
    ----------
    joints
        How many there are.

    Raises
    ------
    ValueError
        If `joints` is not a positive whole number.

    Examples
    --------
    >>> wb.FullState(2).reads.names, wb.FullState(2).gives["qd"].shape
    (('q', 'qd'), (2,))
    """

    noun: ClassVar[str] = ""  # no observer at all

    joints: int

    def __post_init__(self) -> None:
        whole("FullState(joints=...)", self.joints, most=MOST_JOINTS, of=" of joints")

    @property
    def dof(self) -> int:
        """The number of joints."""
        return self.joints

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        """What the instruments say."""
        del t, z
        return Signals(q=y.q, qd=y.qd, d=ca.SX.zeros(self.dof))
