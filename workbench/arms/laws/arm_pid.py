from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import Entry, Layout, block, parameter
from workbench.core.block import Number, Vector
from workbench.core.units import gain


@block
class ArmPID(AbstractArmController):
    """A PID law for each joint of an arm, with gravity compensation if a `model` is given:

        tau = -(Kp e + Ki z + Kd ed) + G(q),      z' = e,  z(0) = 0,      e = q - q_ref.

    Without a model the term G(q) is left out. There is no anti-windup: the integral winds up while a torque is limited.

    Parameters
    ----------
    Kp
        Proportional gain of each joint.
    Ki
        Integral gain of each joint.
    Kd
        Derivative gain of each joint.
    model
        The arm as the designer models it, with one joint for each gain, or None for no gravity compensation.

    References
    ----------
    Siciliano, Sciavicco, Villani and Oriolo (2009), Robotics: Modelling, Planning and Control, chapter 8.

    Examples
    --------
    >>> law = wb.ArmPID(Kp=[50.0, 50.0], Ki=[10.0, 10.0], Kd=[10.0, 10.0], model=wb.paper_arm())
    >>> law.reads.names, law.follows.names, law.drives["tau"].units
    (('q', 'qd'), ('q', 'qd', 'qdd'), ('N m', 'N m'))
    """

    Kp: Vector = parameter(unit="{force}/{position}", low=0, shape=("n",), symbol="K_p")
    Ki: Vector = parameter(unit="{force}/({position} s)", low=0, shape=("n",), symbol="K_i")
    Kd: Vector = parameter(unit="{force} s/{position}", low=0, shape=("n",), symbol="K_d")
    model: AbstractArm | None = None

    def __post_init__(self) -> None:
        if self.model is not None and self.model.dof != self.dof:
            raise ValueError(
                f"`ArmPID(model=...)` must have one joint for each gain, as G(q) is added to tau: "
                f"got a model of {self.model.dof} joints and {self.dof} gains."
            )

    @property
    def dof(self) -> int:
        return int(self.Kp.shape[0])

    @property
    def memory(self) -> Layout:
        return Layout((Entry("integral", np.zeros(self.dof), gain(self.position, "1", 1), symbol="z"),))

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        e, ed = est.q - ref.q, est.qd - ref.qd
        tau: ca.SX = -(self.Kp * e + self.Ki * z["integral"] + self.Kd * ed)
        return tau if self.model is None else tau + self.model.gravity_vector(est.q)

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        return {"integral": est.q - ref.q}

    def without(self) -> Mapping[str, AbstractArmController]:
        integral = {"integral action": replace(self, Ki=0 * self.Ki)} if self.Ki.any() else {}
        derivative = {"derivative action": replace(self, Kd=0 * self.Kd)} if self.Kd.any() else {}
        gravity = {"gravity compensation": replace(self, model=None)} if self.model is not None else {}
        return integral | derivative | gravity
