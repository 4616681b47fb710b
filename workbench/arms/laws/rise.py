from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm
from workbench.arms.laws.sliding_surface import SATURATIONS, AbstractSlidingMode, saturation
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import block, initial, option, parameter
from workbench.core.block import Number, Scalar, Vector


@block
class Rise(AbstractSlidingMode):
    """The robust integral of the sign of the error, which needs no model:

        s   = ed + Lambda e,                                        e = q - q_ref
        tau = tau_ref - (ks + 1) s - w
        w'  = (ks + 1) alpha s + beta sat(s / phi),                 w(0) = w_0

    where tau_ref = 0 or, where a `model` is given, M qdd_ref + C qd_ref + G at q_ref, qd_ref, and the 1 has the unit of
    ks. The authors write e_1 = -e, alpha_1 for Lambda, e_2 = -s, alpha_2 for alpha, and begin at w_0 = -(ks + 1) s(0).

    With sign for sat, where the torque that is left unknown along the reference has a derivative within b1_i and a
    second one within b2_i, beta_i > b1_i + b2_i / alpha_i and ks large enough for the start take e to zero by a
    continuous torque. For one joint of inertia M, ks + 1 < Lambda M leaves a limit cycle.

    References
    ----------
    Xian et al. (2004), A ... asymptotic tracking control strategy for uncertain nonlinear systems, IEEE TAC 49(7).
    Patre et al. (2008), Asymptotic tracking for ... structured and unstructured uncertainties, IEEE TCST 16(2).

    Examples
    --------
    >>> from workbench.arms.laws import Rise
    >>> law = Rise([20.0, 20.0], [10.0, 10.0], [5.0, 5.0], [1.0, 1.0], 0.1, [0.0, 0.0], wb.paper_arm(), "clip")
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, controller=law, reference=wanted).ode().states.size
    6
    """

    mixed_units = "the 1 beside ks has the unit of ks, as its authors print it"

    Lambda: Vector = parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="Lambda")
    alpha: Vector = parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="alpha")
    ks: Vector = parameter(unit="{force} s/{position}", low=0, shape=("n",), symbol="k_s")
    beta: Vector = parameter(unit="{force}/s", low=0, shape=("n",), symbol="beta")
    phi: Scalar = parameter(unit="{position}/s", low=0, strict=True, symbol="phi")
    w: Vector = initial(default=0.0, unit="{force}", shape=("n",), symbol="w")
    model: AbstractArm | None = None
    saturation: str = option(SATURATIONS, default="clip")

    def __post_init__(self) -> None:
        if self.model is not None and self.model.dof != self.dof:
            raise ValueError(
                "`Rise(model=...)` must have one joint for each number of Lambda, as the torque of the reference is "
                f"added to tau: got a model of {self.model.dof} joints and {self.dof} numbers."
            )

    @property
    def dof(self) -> int:
        return int(self.Lambda.shape[0])

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        tau: ca.SX = -(self.ks + 1) * self._sliding_variables(est, ref).s - z["w"]
        return tau if self.model is None else tau + self.model.torque(ref.q, ref.qd, ref.qdd)

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        s = self._sliding_variables(est, ref).s
        return {"w": (self.ks + 1) * self.alpha * s + self.beta * saturation(s, self.phi, self.saturation)}

    def without(self) -> Mapping[str, AbstractArmController]:
        sign = {"integral of the sign": replace(self, beta=0 * self.beta)} if self.beta.any() else {}
        model = {"feedforward": replace(self, model=None)} if self.model is not None else {}
        return sign | self.without_layer() | model
