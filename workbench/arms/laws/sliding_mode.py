from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm
from workbench.arms.laws.sliding_surface import SWITCHINGS, AbstractSlidingMode, matrices
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import block, option, parameter
from workbench.core.block import Number, Scalar, Vector


@block
class SlidingMode(AbstractSlidingMode):
    """Sliding-mode control of an arm: computed torque on a sliding surface, and a switching torque:

        s   = ed + Lambda e,                    e = q - q_ref
        tau = M qdd_r + C qd_r + G - K sat(s / phi)

    where qd_r = qd_ref - Lambda e, qdd_r = qdd_ref - Lambda ed, and M, C, G are those of `model`.

    With the right model M s' + C s = -K sat(s / phi) - D. If K_i > |D_i|, V = s^T M s / 2 decreases while every joint
    is outside its boundary layer |s_i| <= phi. Inside the layer, |e_i| decays to at most phi / Lambda_i: the price of
    a torque that does not chatter. The relays "sign" and "implicit" have no layer.

    Parameters
    ----------
    model
        The arm as the designer models it. It may differ from the arm that is simulated.
    K
        Switching torque of each joint, which should exceed the unknown torques D.

    References
    ----------
    Slotine and Li (1991), Applied Nonlinear Control, chapters 7 (sliding control and the boundary layer) and 9.

    Examples
    --------
    >>> law = wb.SlidingMode(model=wb.paper_arm(), Lambda=[6.0, 6.0], K=[40.0, 20.0], phi=0.1)
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, controller=law, reference=wanted).follows
    ('q',)
    """

    model: AbstractArm
    Lambda: Vector = parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="Lambda")
    K: Vector = parameter(unit="{force}", low=0, shape=("n",), symbol="K")
    phi: Scalar = parameter(unit="{position}/s", low=0, strict=True, symbol="phi")
    saturation: str = option(SWITCHINGS, default="clip")

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        M, C, G = matrices(self.model, est)
        _, _, s, qd_r, qdd_r = self._sliding_variables(est, ref)
        return M @ qdd_r + C @ qd_r + G - self._switching_torque(self.K, s, M)

    def without(self) -> Mapping[str, AbstractArmController]:
        return {"switching torque": replace(self, K=0 * self.K)} | self.without_layer()
