"""Adaptive sliding mode: a switching gain that learns its own size."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from workbench.controllers.adaptation import AbstractAdaptation, AbstractAdaptiveSlidingMode, Plain
from workbench.controllers.sliding_mode import SlidingMode
from workbench.controllers.sliding_surface import SWITCHINGS, matrices
from workbench.core import AbstractArm, block, initial, option, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.loop.arm_ports import AbstractArmController
from workbench.loop.contracts import Follows, Parts, Reads


@block
class AdaptiveSlidingMode(AbstractAdaptiveSlidingMode):
    """Computed torque on a sliding surface, with a switching gain that learns its own size:

        s    = ed + Lambda e,                   e = q - q_ref
        tau  = M qdd_r + C qd_r + G - K o sat(s / phi)
        K_i' = gamma |s_i|                      (`adaptation`: Plain, DeadZone or Leakage)

    where o multiplies joint by joint, qd_r = qd_ref - Lambda e, qdd_r = qdd_ref - Lambda ed, and
    M, C, G are those of `model`: the arm as the designer believes it to be, not the arm that is
    simulated.

    With sign for sat and |D_i| <= K_i*, V = s^T M s / 2 + sum (K_i - K_i*)^2 / (2 gamma) does not
    grow in the plain form. In a boundary layer the plain gain grows without end; its robust forms
    give that up for an error that no longer tends to zero.

    Parameters
    ----------
    Lambda
        (n,), the rate at which the error decays on the surface, one a joint.
    K
        (n,), K(0).

    Raises
    ------
    ValueError
        If a number is out of its bounds or has the wrong shape, or K(0) has a negative entry.

    References
    ----------
    Slotine and Li (1991), Applied Nonlinear Control, chapter 9 (s and qd_r for manipulators).
    Plestan, Shtessel, Bregeault and Poznyak (2010), New methodologies for adaptive sliding mode
    control, International Journal of Control 83(9) (gains that grow with |s|, and their drift).
    """

    model: AbstractArm
    Lambda: Vector = parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="Lambda")
    phi: Scalar = parameter(unit="{position}/s", low=0, strict=True, symbol="phi")
    gamma: Scalar = parameter(unit="{force}/{position}", low=0, strict=True, symbol="gamma")
    K: Vector = initial(unit="{force}", shape=("n",), symbol="K")
    adaptation: AbstractAdaptation = Plain()
    saturation: str = option(SWITCHINGS, default="clip")

    def __post_init__(self) -> None:
        self.check_gains()

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        """The torque by the equations of the class."""
        M, C, G = matrices(self.model, est)
        _, _, s, qd_r, qdd_r = self._sliding(est, ref)
        return M @ qdd_r + C @ qd_r + G - self._switching(z["K"], s, M)

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """K' by the chosen form of adaptation."""
        s = self._sliding(est, ref).s
        return {"K": self.adaptation.rate(self.gamma * ca.fabs(s), s, z["K"])}

    def without(self) -> Mapping[str, AbstractArmController]:
        """The ablations: the law with constant gain K(0), and without its boundary layer."""
        still = SlidingMode(self.model, self.Lambda, self.K, self.phi, self.saturation)
        return {"adaptation": still} | self.without_layer()
