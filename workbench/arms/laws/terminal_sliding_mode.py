from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import casadi as ca
import numpy as np

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm
from workbench.arms.laws.sliding_surface import (
    EXACT_ESTIMATES,
    ROUNDING,
    SATURATIONS,
    AbstractSlidingMode,
    matrices,
    saturation,
)
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import block, option, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.core.claim import Claim, SignalValues

TINY = np.finfo(float).tiny


def _moved_by_the_terminal_surface(y: SignalValues) -> ca.SX:
    power = ca.sign(y["e'"]) * ca.fabs(y["e'"]) ** y["gamma"]
    return ROUNDING - ca.fabs(power - y["beta"] * (y["surface"] - y["e"]))


TERMINAL_SURFACE_MOVES_THE_ERROR = Claim(
    "the terminal surface moves the error",
    "|e_i'|^gamma sign(e_i') = beta_i (s_i - e_i), to 1e-7 in units of beta_i e_i: while |s_i| <= phi, |e_i| falls to "
    "phi in finite time.",
    "Feng, Yu and Man (2002)",
    (EXACT_ESTIMATES,),
    _moved_by_the_terminal_surface,
)


@block
class NonsingularTerminalSlidingMode(AbstractSlidingMode):
    """Computed torque on a terminal sliding surface, joint by joint, with a reaching law:

        s   = e + sig(ed)^gamma / beta,                  e = q - q_ref,   1 < gamma < 2
        tau = M (qdd_ref - (beta / gamma) sig(ed)^(2 - gamma) - u) + C qd + G
        u   = k1 s + k2 |s|^rho sat(s / phi),            0 <= rho < 1

    where sig(x)^a = |x|^a sign(x), and M, C, G are those of `model`, the arm as the designer believes it to be. The
    authors write p / q for gamma; rho = 0 and k1 = 0 make u their relay, rho > 0 the continuous reaching law of the
    second source.

    With the right model s' = -(gamma / beta) |ed|^(gamma - 1) (u + M^-1 D). On the surface e ends after gamma / (gamma
    - 1) beta^(-1/gamma) |e|^(1 - 1/gamma). Under D a relay needs k2_i > |M^-1 D|_i; with rho > 0 |s_i| falls to (|M^-1
    D|_i / k2_i)^(1/rho) at most. With the layer |e| falls to phi only.

    References
    ----------
    Feng, Yu and Man (2002), Non-singular terminal sliding mode control of rigid manipulators, Automatica 38(12).
    Yu et al. (2005), Continuous finite-time control ... with terminal sliding mode, Automatica 41(11).

    Examples
    --------
    >>> from workbench.arms.laws import NonsingularTerminalSlidingMode
    >>> law = NonsingularTerminalSlidingMode(wb.paper_arm(), [1.0, 1.0], 1.5, [5.0, 5.0], [5.0, 5.0], 0.5, 0.1, "tanh")
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, controller=law, reference=wanted).ode().states.size
    4
    """

    claims: ClassVar[tuple[Claim, ...]] = (TERMINAL_SURFACE_MOVES_THE_ERROR,)

    model: AbstractArm
    beta: Vector = parameter(unit="{position}^(gamma-1)/s^gamma", low=0, strict=True, shape=("n",), symbol="beta")
    gamma: Scalar = parameter(unit="", low=1, high=2, strict=True, symbol="gamma")
    k1: Vector = parameter(unit="1/s^2", low=0, shape=("n",), symbol="k_1")
    k2: Vector = parameter(unit="{position}^(1-rho)/s^2", low=0, shape=("n",), symbol="k_2")
    rho: Scalar = parameter(unit="", low=0, high=1, symbol="rho")
    phi: Scalar = parameter(unit="{position}", low=0, strict=True, symbol="phi")
    saturation: str = option(SATURATIONS, default="clip")

    def __post_init__(self) -> None:
        if self.rho == 1:
            raise ValueError(
                "`NonsingularTerminalSlidingMode(rho=...)` must be below 1, since only below it s reaches zero in "
                "finite time; got 1. The part of the reaching law in proportion to s is k1."
            )

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        M, C, G = matrices(self.model, est)
        ed, s = est.qd - ref.qd, self._surface(est, ref)
        u = self.k1 * s + self.k2 * _power(s, self.rho) * saturation(s, self.phi, self.saturation)
        along = self.beta / self.gamma * _power(ed, 2 - self.gamma) * ca.sign(ed)
        tau: ca.SX = M @ (ref.qdd - along - u) + C @ est.qd + G
        return tau

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The sliding variable s in rad, named apart from that of a linear surface, which is in rad/s."""
        return {"surface": self._surface(est, ref)}

    def without(self) -> Mapping[str, AbstractArmController]:
        linear = {"linear reaching": replace(self, k1=0 * self.k1)} if self.k1.any() else {}
        switched = {"switched reaching": replace(self, k2=0 * self.k2)} if self.k2.any() else {}
        return linear | switched | self.without_layer()

    def _surface(self, est: Reads, ref: Follows) -> ca.SX:
        e, ed = est.q - ref.q, est.qd - ref.qd
        s: ca.SX = e + _power(ed, self.gamma) * ca.sign(ed) / self.beta
        return s


def _power(x: ca.SX, a: Scalar) -> ca.SX:
    """|x|^a, elementwise; the smallest float below the power keeps its derivative finite at x = 0."""
    power: ca.SX = ca.fmax(ca.fabs(x), TINY) ** a
    return power
