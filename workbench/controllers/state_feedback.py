"""State feedback: the torque that the reference takes, and a linear gain on the error about it."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from workbench.controllers.checks import halves
from workbench.core import AbstractArm, Layout, block, parameter
from workbench.core.block import Matrix
from workbench.loop.arm import AbstractArmController
from workbench.loop.contracts import Follows, Parts, Reads
from workbench.validation.shapes import Number


@block
class StateFeedback(AbstractArmController):
    """Feedforward along the reference, and linear feedback of the whole state:

        tau = tau_ref - Kp e - Kd ed,             e = q - q_ref,
        tau_ref = M qdd_ref + C qd_ref + G        at q_ref, qd_ref, of `model`

    where `model` is the arm as the designer believes it to be. With [Kp Kd] = R^-1 B' P of the equations
    linearised about a rest point this is the LQR: optimal there, and near it almost so. The feedforward
    needs the derivatives of the reference, and a reference that jumps has none.

    Parameters
    ----------
    Kp, Kd
        (n, n), full matrices: a joint may answer the error of another.

    Raises
    ------
    ValueError
        If a gain is not finite or not of shape (n, n), or Kd drives motion on and damps none.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, chapter 3.
    Siciliano, Sciavicco, Villani and Oriolo (2009), Robotics: Modelling, Planning and Control, section 8.5.
    """

    model: AbstractArm
    Kp: Matrix = parameter(unit="N m/rad", shape=("n", "n"), symbol="K_p")
    Kd: Matrix = parameter(unit="N m s/rad", shape=("n", "n"), symbol="K_d")

    def __post_init__(self) -> None:
        # at rest the eigenvalues of the loop add up to -tr(M^-1 Kd), M being positive definite
        damping = np.linalg.eigvalsh((self.Kd + self.Kd.T) / 2)
        if damping[-1] <= 0 and damping[0] < 0:
            raise ValueError(
                "`StateFeedback(Kd=...)` must damp: tau holds -Kd ed, and a Kd whose symmetric part has negative "
                "eigenvalues and no positive one makes every rest of an arm without friction unstable. Got "
                f"{np.array2string(self.Kd, separator=', ')}. A gain of u = +K x must change its sign."
            )

    @staticmethod
    def of(model: AbstractArm, K: Any) -> StateFeedback:
        """The law u = -K [e; ed], with K (n, 2n) as a regulator's design gives it.

        Raises
        ------
        ValueError
            If K is no matrix (n, 2n) of finite numbers.
        """
        return StateFeedback(model, *halves("StateFeedback.of(K=...)", K, model.dof))

    @property
    def dof(self) -> int:
        """The number of joints of the model."""
        return self.model.dof

    @property
    def memory(self) -> Layout:
        """None."""
        return Layout()

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        """The law as it stands above."""
        del t, z
        e, ed = est.q - ref.q, est.qd - ref.qd
        tau: ca.SX = self.model.torque(ref.q, ref.qd, ref.qdd) - self.Kp @ e - self.Kd @ ed
        return tau

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """Nothing to remember."""
        del t, z, est, ref
        return {}

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        """Nothing that the loop does not show already."""
        del z, est, ref
        return {}
