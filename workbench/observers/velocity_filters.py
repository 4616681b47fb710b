"""Velocities through a filter of first order: of the velocity that is read, or of the positions alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import casadi as ca

from workbench.core import Signals, block, initial, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.core.claim import Claim
from workbench.core.dynamics import MOST_JOINTS
from workbench.loop.arm_ports import AbstractArmObserver
from workbench.loop.contracts import Inputs, Parts, Reads
from workbench.observers.full_state import FullState
from workbench.observers.promises import FILTER_FOLLOWS
from workbench.validation.refusals import whole


@block
class VelocityFilter(AbstractArmObserver):
    """Positions as they are read, velocities through a low-pass filter of first order, and no disturbance:

        qd_hat' = omega (qd - qd_hat),        q_hat = q,        D_hat = 0

    With exact readings the error E = qd - qd_hat obeys E' = qdd - omega E: it falls to |qdd| / omega. A computer steps
    it exactly, by exp(-omega h) over a period h in which the reading is held; noise of independent readings passes
    with the share tanh(omega h / 2) of its variance.

    Parameters
    ----------
    joints
        How many there are.
    omega
        The cut-off frequency.
    qd_hat
        (n,), the estimate at time 0.

    Raises
    ------
    ValueError
        If `joints` is not a positive whole number, or omega is not positive.
    """

    claims: ClassVar[tuple[Claim, ...]] = (FILTER_FOLLOWS,)

    joints: int
    omega: Scalar = parameter(unit="rad/s", low=0, strict=True, symbol="omega")
    qd_hat: Vector = initial(default=0.0, unit="rad/s", shape=("n",))

    def __post_init__(self) -> None:
        whole("VelocityFilter(joints=...)", self.joints, most=MOST_JOINTS, of=" of joints")

    @property
    def dof(self) -> int:
        """The number of joints; a negative one counts as none, which is refused."""
        return max(self.joints, 0)

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        """The reading of the positions, and the memory."""
        del t
        return Signals(q=y.q, qd=z["qd_hat"], d=ca.SX.zeros(self.dof))

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The filter."""
        del t, est, u
        return {"qd_hat": self.omega * (y.qd - z["qd_hat"])}

    @property
    def method(self) -> str:
        """Exact for a reading that is held."""
        return "exact step of the filter"

    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        """The filter over a period in which the reading is held."""
        del t, est, u
        return {"qd_hat": y.qd + (z["qd_hat"] - y.qd) * ca.exp(-self.omega * period)}

    def without(self) -> Mapping[str, AbstractArmObserver]:
        """The instruments themselves."""
        return {"velocity filter": FullState(self.dof)}


@block
class DirtyDerivative(AbstractArmObserver):
    """Positions as they are read, velocities from them by omega s / (s + omega), and no disturbance:

        q_hat' = omega (q - q_hat),        qd_hat = q_hat',        D_hat = 0

    The law is given q and qd_hat; q_hat is the filter's own. With exact readings E = qd - qd_hat obeys
    E' = qdd - omega E, as that of `VelocityFilter` does, but without a reading of the velocity: noise of the
    positions comes through about omega times as large. Where a computer steps it by explicit Euler with the period
    h, the filter is stable for omega h < 2 and rises without overshoot for omega h <= 1; at omega h = 1 it is the
    difference of two readings over h.

    Parameters
    ----------
    joints
        How many there are.
    omega
        The cut-off frequency.
    q_hat
        (n,), the filter's position at time 0: with the first reading qd_hat(0) = 0; each rad beside it makes a
        velocity of omega that is not there.

    Raises
    ------
    ValueError
        If `joints` is not a positive whole number, or omega is not positive.

    References
    ----------
    Loria (2016), Observers are unnecessary for output-feedback control of Lagrangian systems, IEEE Transactions on
    Automatic Control 61(4).
    """

    claims: ClassVar[tuple[Claim, ...]] = (FILTER_FOLLOWS,)
    measured: ClassVar[tuple[str, ...]] = ("q",)

    joints: int
    omega: Scalar = parameter(unit="rad/s", low=0, strict=True, symbol="omega")
    q_hat: Vector = initial(unit="rad", shape=("n",))

    def __post_init__(self) -> None:
        whole("DirtyDerivative(joints=...)", self.joints, most=MOST_JOINTS, of=" of joints")

    @property
    def dof(self) -> int:
        """The number of joints; a negative one counts as none, which is refused."""
        return max(self.joints, 0)

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        """The reading of the positions, and the rate of the memory."""
        del t
        return Signals(q=y.q, qd=self._velocity(z, y), d=ca.SX.zeros(self.dof))

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The filter."""
        del t, est, u
        return {"q_hat": self._velocity(z, y)}

    def without(self) -> Mapping[str, AbstractArmObserver]:
        """The instruments themselves, with a velocity that is measured too."""
        return {"velocity filter": FullState(self.dof)}

    def _velocity(self, z: Parts, y: Reads) -> ca.SX:
        qd_hat: ca.SX = self.omega * (y.q - z["q_hat"])
        return qd_hat
