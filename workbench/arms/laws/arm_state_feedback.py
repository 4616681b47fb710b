from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.arms.arm_contracts import AbstractArmController, motors
from workbench.arms.dynamics import AbstractArm
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import Layout, block, parameter
from workbench.core.block import Matrix, Number
from workbench.core.point import gain_of
from workbench.core.units import join_units
from workbench.core.validation.refusals import Array, as_array, refusal


@block
class ArmStateFeedback(AbstractArmController):
    """Linear state feedback for an arm, with the feedforward torque of the reference motion:

        tau = tau_ref - Kp e - Kd ed,             e = q - q_ref,
        tau_ref = M qdd_ref + C qd_ref + G        of `model` at q_ref, qd_ref

    tau has one entry for each of the m motors; for an arm with passive joints m is less than n. With
    [Kp Kd] = R^-1 B' P of the equations linearised about an equilibrium, this is the LQR. `ArmStateFeedback.of` makes
    it from the design. If every joint has a motor, a Kd that damps no motion, and only adds energy, is refused.

    Parameters
    ----------
    model
        The arm as the designer models it, with n joints and m motors.
    Kp
        Gain of the errors of position, in N m or N per rad or m.
    Kd
        Gain of the errors of velocity, in N m or N per rad/s or m/s.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, chapter 3.
    Siciliano, Sciavicco, Villani and Oriolo (2009), Robotics: Modelling, Planning and Control, section 8.5.

    Examples
    --------
    >>> arm = wb.robot("cart-pole")
    >>> linear = wb.linearize(wb.open_loop(wb.Manipulator(arm, q=[0.0, 0.0])), 0.0, np.zeros(4), at_rest=True)
    >>> design = wb.lqr(linear, Q=np.eye(4), R=[[1.0]])
    >>> design.K.shape, wb.ArmStateFeedback.of(arm, design).drives["tau"].unit
    ((1, 4), 'N')
    """

    model: AbstractArm
    Kp: Matrix = parameter(unit="{stiffness}", shape=("m", "n"), symbol="K_p")
    Kd: Matrix = parameter(unit="{damping}", shape=("m", "n"), symbol="K_d")

    def __post_init__(self) -> None:
        if len(self.Kp) != (count := len(self.model.motors)):
            raise ValueError(
                f"`ArmStateFeedback(Kp=...)` must have a row for each motor of `model`, which has {count}; got shape "
                f"{self.Kp.shape}."
            )
        if count < self.dof:
            return
        # at rest the eigenvalues of the loop add up to -tr(M^-1 Kd), M being positive definite
        damping = np.linalg.eigvalsh((self.Kd + self.Kd.T) / 2)
        if damping[-1] <= 0 and damping[0] < 0:
            raise ValueError(
                "`ArmStateFeedback(Kd=...)` must damp: tau holds -Kd ed, and a Kd whose symmetric part has negative "
                "eigenvalues and no positive one makes every rest of an arm without friction unstable. Got "
                f"{np.array2string(self.Kd, separator=', ')}. A gain of u = +K x must change its sign."
            )

    @staticmethod
    def of(model: AbstractArm, K: object) -> ArmStateFeedback:
        """The law tau = tau_ref - K [e; ed] from the design of a regulator.

        The operating point of the design is not used: tau_ref and the errors are those of the reference.

        Parameters
        ----------
        model
            The arm as the designer models it.
        K
            The result of `lqr` or `place` for the linearised arm, or its gain (m, 2n) alone.
        """
        gain, _ = gain_of(K)
        return ArmStateFeedback(model, *halves("ArmStateFeedback.of(K=...)", gain, model.dof, len(model.motors)))

    @property
    def drives(self) -> Layout:
        """The commanded torques tau, one for each motor."""
        return motors(self.model)

    @property
    def stiffness(self) -> str:
        """The unit of Kp; if its entries differ, one for each entry, column by column."""
        return self._gain("/")

    @property
    def damping(self) -> str:
        """The unit of Kd; if its entries differ, one for each entry, column by column."""
        return self._gain(" s/")

    def _gain(self, over: str) -> str:
        each = [f"{force}{over}{unit}" for unit in self.model.units for force in self.drives["tau"].units]
        return join_units(each)

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        e, ed = est.q - ref.q, est.qd - ref.qd
        along = self.model.torque(ref.q, ref.qd, ref.qdd)[list(self.model.motors)]
        tau: ca.SX = along - self.Kp @ e - self.Kd @ ed
        return tau


def halves(call: str, K: object, dof: int, rows: int) -> tuple[Array, Array]:
    """The gains of e and of ed from K (..., rows, 2n), or a refusal."""
    gain = as_array(K)
    if gain is None:
        raise refusal(call, "a matrix of numbers", K)
    if gain.ndim < 2 or gain.shape[-2:] != (rows, 2 * dof):
        count = f"{rows} row{'s' if rows > 1 else ''}, one a {'joint' if rows == dof else 'motor'}"
        raise ValueError(f"`{call}` must have {count}, and {2 * dof} columns, for [e; ed]; got shape {gain.shape}.")
    return gain[..., :dof], gain[..., dof:]
