"""Filters of the true disturbance: the paper's (24) as printed, and its repair. No instrument feeds them."""

from __future__ import annotations

from typing import ClassVar

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Signals, block, parameter
from workbench.core.block import Number, Scalar
from workbench.core.claim import Claim
from workbench.core.dynamics import MOST_JOINTS
from workbench.loop.contracts import Inputs, Parts, Reads
from workbench.observers.disturbance import AbstractDisturbanceObserver
from workbench.observers.promises import ORACLE_FOLLOWS, PRINTED_FOLLOWS
from workbench.validation.refusals import whole


@block
class PrintedFilter(AbstractDisturbanceObserver):
    """The paper's disturbance observer as printed, equation (24):

        eta' = -l (eta - D),    eta(0) = 0
        D_hat = integral of eta from 0 to t

    It needs the unknown D itself; and as eta follows D, D_hat follows the integral of D, not D.

    Parameters
    ----------
    joints
        How many there are.

    References
    ----------
    Adaptive observer-based sliding mode control with time-varying learning using Riccati gain
    synthesis for robotic manipulators, section 3.2.
    """

    claims: ClassVar[tuple[Claim, ...]] = (PRINTED_FOLLOWS,)

    joints: int
    l: Scalar = parameter(unit="1/s", low=0, strict=True, symbol="l")

    def __post_init__(self) -> None:
        whole("PrintedFilter(joints=...)", self.joints, most=MOST_JOINTS, of=" of joints")

    @property
    def dof(self) -> int:
        """The number of joints."""
        return self.joints

    @property
    def uses_truth(self) -> bool:
        """Yes: D is what it filters."""
        return True

    @property
    def memory(self) -> Layout:
        """The filter's eta and its integral, in the units that (24) would have them."""
        zero = np.zeros(self.joints)
        return Layout((Entry("eta", zero, "N m", symbol="eta"), Entry("D_hat", zero, "N m s")))

    def estimate(self, t: Number, z: Parts, y: Reads, est: Signals) -> ca.SX:
        """The integral of eta."""
        del t, y, est
        return z["D_hat"]

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """(24)."""
        del t, est, u
        return {"eta": -self.l * (z["eta"] - y.d), "D_hat": z["eta"]}


@block
class OracleFilter(AbstractDisturbanceObserver):
    """The smallest repair of equation (24): the filter's state is the estimate,

        D_hat' = -l (D_hat - D),    D_hat(0) = 0.

    An oracle still: it is told the true D. What it is good for is to show what a perfect instrument
    would be worth.

    Parameters
    ----------
    joints
        How many there are.
    """

    claims: ClassVar[tuple[Claim, ...]] = (ORACLE_FOLLOWS,)
    noun: ClassVar[str] = "oracle"

    joints: int
    l: Scalar = parameter(unit="1/s", low=0, strict=True, symbol="l")

    def __post_init__(self) -> None:
        whole("OracleFilter(joints=...)", self.joints, most=MOST_JOINTS, of=" of joints")

    @property
    def dof(self) -> int:
        """The number of joints."""
        return self.joints

    @property
    def uses_truth(self) -> bool:
        """Yes: D is what it filters."""
        return True

    @property
    def memory(self) -> Layout:
        """The estimate."""
        return Layout((Entry("D_hat", np.zeros(self.joints), "N m"),))

    def estimate(self, t: Number, z: Parts, y: Reads, est: Signals) -> ca.SX:
        """The memory."""
        del t, y, est
        return z["D_hat"]

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The filter."""
        del t, est, u
        return {"D_hat": -self.l * (z["D_hat"] - y.d)}
