"""Full state: readings taken as estimates, with the velocity as measured, filtered, or derived from positions."""

from collections.abc import Mapping
from typing import ClassVar

import casadi as ca

from workbench.arms.arm_contracts import AbstractArmObserver, AbstractJoints
from workbench.arms.dynamics import MOST_JOINTS
from workbench.blocks.loop.contracts import Inputs, Parts, Reads
from workbench.core import Signals, block, initial, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.core.claim import Claim
from workbench.core.claim import SignalValues as Run
from workbench.core.validation.refusals import whole


def _filter_margin(y: Run) -> ca.SX:
    """|E_i| |qdd_i| - omega E_i^2 - E_i E_i': >= 0, but for rounding, where E' = qdd - omega E."""
    E = y["qd_error"]
    return ca.fabs(E) * ca.fabs(y["qd'"]) - y["omega"] * E**2 - E * y["qd_error'"] + 1e-7


FILTER_FOLLOWS = Claim(
    "the filter follows qd",
    "E = qd - qd_hat has E_i E_i' <= |E_i| |qdd_i| - omega E_i^2 + 1e-7 rad^2/s^3: |E_i| falls to |qdd_i| / omega.",
    "the equation of a low-pass filter of first order",
    margin=_filter_margin,
)


class AbstractJointCounter(AbstractJoints):
    """The base class of blocks without a model, which have the number of joints as a field.

    Parameters
    ----------
    joints
        The number of joints n.
    """

    joints: int

    def check_joints(self) -> None:
        """Refuse a number of joints that is not whole and positive."""
        whole(f"{type(self).__name__}(joints=...)", self.joints, most=MOST_JOINTS, of=" of joints")

    @property
    def dof(self) -> int:
        """The number of joints n."""
        return max(self.joints, 0)


@block
class ArmFullState(AbstractJointCounter, AbstractArmObserver):
    """The measured positions and velocities of an arm as the estimates, without an observer.

    The estimates are q_hat = q, qd_hat = qd and D_hat = 0.

    Examples
    --------
    >>> wb.ArmFullState(2).reads.names, wb.ArmFullState(2).gives["qd"].shape
    (('q', 'qd'), (2,))
    """

    noun: ClassVar[str] = ""  # no observer at all

    joints: int

    def __post_init__(self) -> None:
        self.check_joints()

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return Signals(q=y.q, qd=y.qd, d=ca.SX.zeros(self.dof))


@block
class VelocityFilter(AbstractJointCounter, AbstractArmObserver):
    """The measured positions of an arm, and the measured velocities behind a first-order low-pass filter:

        qd_hat' = omega (qd - qd_hat),        q_hat = q,        D_hat = 0

    With exact readings the error E = qd - qd_hat obeys E' = qdd - omega E, and decays to |qdd| / omega. A computer
    holds the reading for a period h and steps the filter exactly, by exp(-omega h). The variance of white noise of the
    readings is then reduced to the fraction tanh(omega h / 2).

    Parameters
    ----------
    omega
        Bandwidth of the filter.
    qd_hat
        Output of the filter.

    Examples
    --------
    >>> from workbench.arms.observers import VelocityFilter
    >>> law = wb.SlidingMode(wb.paper_arm(), [6.0, 6.0], [40.0, 20.0], 0.1)
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, VelocityFilter(2, 100.0, [0.0, 0.0]), law, wanted).ode().states.size
    6
    """

    noun: ClassVar[str] = "velocity filter"

    claims: ClassVar[tuple[Claim, ...]] = (FILTER_FOLLOWS,)

    joints: int
    omega: Scalar = parameter(unit="rad/s", low=0, strict=True, symbol="omega")
    qd_hat: Vector = initial(default=0.0, unit="rad/s", shape=("n",))

    def __post_init__(self) -> None:
        self.check_joints()

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return Signals(q=y.q, qd=z["qd_hat"], d=ca.SX.zeros(self.dof))

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        return {"qd_hat": self.omega * (y.qd - z["qd_hat"])}

    @property
    def method(self) -> str:
        return "exact step of the filter"

    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        return {"qd_hat": y.qd + (z["qd_hat"] - y.qd) * ca.exp(-self.omega * period)}

    def without(self) -> Mapping[str, AbstractArmObserver]:
        return {"velocity filter": ArmFullState(self.dof)}


@block
class DirtyDerivative(AbstractJointCounter, AbstractArmObserver):
    """The measured positions of an arm, and velocities derived from them by the filter omega s / (s + omega):

        q_hat' = omega (q - q_hat),        qd_hat = q_hat',        D_hat = 0

    The law gets q and qd_hat. With exact readings the error E = qd - qd_hat obeys E' = qdd - omega E. The noise of the
    velocities is about omega times the noise of the positions. The explicit Euler step of a computer with the period h
    is stable for omega h < 2.

    Parameters
    ----------
    omega
        Bandwidth of the filter.
    q_hat
        State of the filter. It should begin at the first reading of q: each rad of difference makes a velocity of
        omega in the first estimate.

    References
    ----------
    Loria (2016), Observers are unnecessary for output-feedback control of Lagrangian systems, IEEE TAC 61(4).

    Examples
    --------
    >>> from workbench.arms.observers import DirtyDerivative
    >>> law = wb.SlidingMode(wb.paper_arm(), [6.0, 6.0], [40.0, 20.0], 0.1)
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, DirtyDerivative(2, 100.0, [0.5, 0.0]), law, wanted).ode().states.size
    6
    """

    claims: ClassVar[tuple[Claim, ...]] = (FILTER_FOLLOWS,)
    measured_signals: ClassVar[tuple[str, ...]] = ("q",)

    joints: int
    omega: Scalar = parameter(unit="rad/s", low=0, strict=True, symbol="omega")
    q_hat: Vector = initial(unit="rad", shape=("n",))

    def __post_init__(self) -> None:
        self.check_joints()

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return Signals(q=y.q, qd=self.omega * (y.q - z["q_hat"]), d=ca.SX.zeros(self.dof))

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        return {"q_hat": self.omega * (y.q - z["q_hat"])}

    def without(self) -> Mapping[str, AbstractArmObserver]:
        return {"velocity filter": ArmFullState(self.dof)}
