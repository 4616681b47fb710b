from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import casadi as ca
import numpy as np

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm
from workbench.arms.laws.sliding_surface import SWITCHINGS, AbstractSlidingMode, clip, matrices, saturation
from workbench.blocks.loop.contracts import EULER, Follows, Parts, Reads
from workbench.core import Entry, Layout, block, option, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.core.claim import Claim
from workbench.core.units import per_second

TINY = np.finfo(float).tiny
SWITCHED_RATE_IS_BOUNDED = Claim(
    "the integral part has a bounded rate",
    "|w_i'| <= 1.01 k2_i at all times, k2_i with a slack of 1 %, so that the torque is continuous.",
    "Levant (1993)",
    margin=lambda y: 1.01 * y["k2"] - ca.fabs(y["w'"]),
)


@block
class SuperTwisting(AbstractSlidingMode):
    """The super-twisting algorithm on each joint of a sliding surface:

        s   = ed + Lambda e,                     e = q - q_ref
        tau = M (qdd_r + u) + C qd + G
        u_i = -k1_i |s_i|^(1/2) sat(s_i / phi) + w_i
        w_i' = -k2_i sat(s_i / phi),             w(0) = 0

    where qd_r = qd_ref - Lambda e, qdd_r = qdd_ref - Lambda ed, and M, C, G are those of `model`. With the right model
    s' = u - M^-1 D exactly: the joints are uncoupled and the published conditions on k1, k2 apply to each. With sign
    for sat, s reaches zero in finite time against any perturbation whose derivative is bounded by L, if k2 > L and k1
    is large enough; with the layer s comes to rest at about phi L / k2.

    "sign" chatters where it is sampled; "implicit" is one backward Euler step of both lines over the sampling period h,
    with sat, s and w in u those of its end, which does not chatter and leaves s of the order of h:

        s+ + h k1 |s+|^(1/2) sign(s+) + h^2 k2 sign(s+) = s + h w.

    References
    ----------
    Levant (1993), Sliding order and sliding accuracy in sliding mode control, International Journal of Control 58(6).
    Moreno and Osorio (2012), Strict Lyapunov functions for the super-twisting algorithm, IEEE TAC 57(4).
    Brogliato et al. (2020), The implicit discretization of the supertwisting ... algorithm, IEEE TAC 65(8).

    Examples
    --------
    >>> from workbench.arms.laws import SuperTwisting
    >>> law = SuperTwisting(wb.paper_arm(), [6.0, 6.0], [8.0, 8.0], [4.0, 4.0], 0.1, "sign")
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, controller=law, reference=wanted).ode().states.size
    6
    """

    claims: ClassVar[tuple[Claim, ...]] = (SWITCHED_RATE_IS_BOUNDED,)

    model: AbstractArm
    Lambda: Vector = parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="Lambda")
    k1: Vector = parameter(unit="({position}/s^3)^(1/2)", low=0, shape=("n",), symbol="k_1")
    k2: Vector = parameter(unit="{position}/s^3", low=0, shape=("n",), symbol="k_2")
    phi: Scalar = parameter(unit="{position}/s", low=0, strict=True, symbol="phi")
    saturation: str = option(SWITCHINGS, default="clip")

    @property
    def memory(self) -> Layout:
        return Layout((Entry("w", np.zeros(self.dof), per_second(self.position, 2), symbol="w"),))

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        M, C, G = matrices(self.model, est)
        _, _, s, _, qdd_r = self._sliding_variables(est, ref)
        root, sigma, w = self._switching_terms(s, z["w"])
        u = -self.k1 * root * sigma + w
        tau: ca.SX = M @ (qdd_r + u) + C @ est.qd + G
        return tau

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        _, sigma, _ = self._switching_terms(self._sliding_variables(est, ref).s, z["w"])
        return {"w": -self.k2 * sigma}

    @property
    def method(self) -> str:
        return "backward Euler" if self.saturation == "implicit" else EULER

    def without(self) -> Mapping[str, AbstractArmController]:
        lines = {"integral part": replace(self, k2=0 * self.k2), "root part": replace(self, k1=0 * self.k1)}
        return lines | self.without_layer()

    def _switching_terms(self, s: ca.SX, w: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """|s|^(1/2), sat(s / phi) and the integral part that go into u; "implicit" those at the end of the period."""
        if self.saturation != "implicit":
            return _root(s), saturation(s, self.phi, self.saturation), w
        h = self.sampling_period()
        free, least = s + h * w, ca.SX(h**2 * self.k2)  # where s would go by itself, and what sign(s) brings to rest
        sigma = clip(free / ca.fmax(least, TINY), ca.SX(1))
        a, left = h * self.k1, ca.fmax(ca.fabs(free) - least, 0)
        root = (ca.sqrt(a**2 + 4 * left) - a) / 2  # of |s+| + a |s+|^(1/2) = left
        return root, sigma, w - h * self.k2 * sigma


def _root(s: ca.SX) -> ca.SX:
    """|s|^(1/2), elementwise; the smallest float under the root keeps its derivative finite at s = 0."""
    return ca.sqrt(ca.fmax(ca.fabs(s), TINY))
