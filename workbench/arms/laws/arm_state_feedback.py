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
    """Feedforward along the reference, and linear feedback of the whole state:

        tau = tau_ref - Kp e - Kd ed,             e = q - q_ref,
        tau_ref = M qdd_ref + C qd_ref + G        at q_ref, qd_ref, of `model`

    where `model` is the arm as the designer believes it to be; of an arm with passive joints tau is that of its m
    motors, each of which may answer the error of any joint. With [Kp Kd] = R^-1 B' P of the equations linearised about
    a rest point this is the LQR. Where every joint has a motor, a Kd that drives motion on and damps none is refused.

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
        """The law u = tau_ref - K [e; ed] of a regulator's design, or of its K (m, 2n) alone.

        The feedforward tau_ref and the error are those of the reference, so the point is wherever that is.
        """
        gain, _ = gain_of(K)
        return ArmStateFeedback(model, *halves("ArmStateFeedback.of(K=...)", gain, model.dof, len(model.motors)))

    @property
    def drives(self) -> Layout:
        return motors(self.model)

    @property
    def stiffness(self) -> str:
        """The unit of Kp, column by column where its entries differ."""
        return self._gain("/")

    @property
    def damping(self) -> str:
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
