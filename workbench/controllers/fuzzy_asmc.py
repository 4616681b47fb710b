"""Fuzzy adaptive sliding mode: a rule base says how fast the switching gain learns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import casadi as ca
import numpy as np

from workbench.controllers.adaptation import AbstractAdaptation, Plain
from workbench.controllers.adaptive_sliding_mode import AdaptiveSlidingMode
from workbench.controllers.checks import gains_that_start_at
from workbench.controllers.fuzzy import RuleBase
from workbench.controllers.promises import GAINS_STAY_POSITIVE, SURFACE_PULLS_THE_ERROR
from workbench.controllers.switching import SWITCHINGS, layered, matrices, sliding, switched
from workbench.core import AbstractArm, Entry, Layout, block, initial, option, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.core.claim import Claim
from workbench.core.port import per_second
from workbench.loop.arm_ports import AbstractArmController
from workbench.loop.contracts import Follows, Parts, Reads


@block
class FuzzyAsmc(AbstractArmController):
    """Adaptive sliding mode whose gain learns faster or slower as a fuzzy rule base says:

        s    = ed + Lambda e,                        e = q - q_ref
        tau  = M qdd_r + C qd_r + G - K o sat(s / phi)
        K_i' = gamma r(|s_i|, v_i) |s_i|             (`adaptation`: Plain, DeadZone or Leakage)
        v_i  = (|s_i| - z_i) / lag,    z_i' = v_i,    z(0) = 0

    where o multiplies joint by joint, r is the `rules`, qd_r = qd_ref - Lambda e,
    qdd_r = qdd_ref - Lambda ed, and M, C, G are those of `model`: the arm as the designer believes it.

    The trend d|s_i|/dt would need the acceleration, which nobody measures; v_i is that trend behind a
    first-order lag. As z starts at zero, v_i tells of a rise during the first few lags of a run that
    starts off the surface. In the plain form the gain never falls, and grows while s_i and r are
    not zero; the Lyapunov argument of `AdaptiveSlidingMode` takes a constant rate and is not carried over.

    The paper names this rival and prints none of its rules; these are ours.

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
    Wang (1997), A Course in Fuzzy Systems and Control (product inference, centre-average defuzzifier).
    """

    claims: ClassVar[tuple[Claim, ...]] = (
        SURFACE_PULLS_THE_ERROR,
        GAINS_STAY_POSITIVE,
    )

    model: AbstractArm
    Lambda: Vector = parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="Lambda")
    phi: Scalar = parameter(unit="{position}/s", low=0, strict=True, symbol="phi")
    gamma: Scalar = parameter(unit="{force}/{position}", low=0, strict=True, symbol="gamma")
    lag: Scalar = parameter(unit="s", low=0, strict=True, symbol="T_v")
    K: Vector = initial(unit="{force}", shape=("n",), symbol="K")
    rules: RuleBase = RuleBase()
    adaptation: AbstractAdaptation = Plain()
    saturation: str = option(SWITCHINGS, default="clip")

    def __post_init__(self) -> None:
        gains_that_start_at("FuzzyAsmc", self.K, self.force)
        self.adaptation.check(self.dof)

    @property
    def dof(self) -> int:
        """The number of joints of the model."""
        return self.model.dof

    @property
    def memory(self) -> Layout:
        """The gains, and |s| behind the lag."""
        slow = Entry("s_slow", np.zeros(self.dof), per_second(self.position), symbol="z")
        return Layout((gains_that_start_at("FuzzyAsmc", self.K, self.force), slow))

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        """The law as it stands above."""
        del t
        M, C, G = matrices(self.model, est)
        _, _, s, qd_r, qdd_r = sliding(est, ref, self.Lambda)
        return M @ qdd_r + C @ qd_r + G - switched(self, z["K"], s, M)

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        """K' by the rules and the chosen form of adaptation; z' = v."""
        del t
        s = sliding(est, ref, self.Lambda).s
        v = self._trend(z, s)
        r = self.rules.strength(ca.fabs(s), v)
        return {"K": self.adaptation.rate(self.gamma * r * ca.fabs(s), s, z["K"]), "s_slow": v}

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The sliding variable s, and what the rules say: r."""
        s = sliding(est, ref, self.Lambda).s
        return {"s": s, "r": self.rules.strength(ca.fabs(s), self._trend(z, s))}

    def without(self) -> Mapping[str, AbstractArmController]:
        """Adaptive sliding mode without rules, sliding mode with K(0) for good, and the law less its layer."""
        plain = AdaptiveSlidingMode(
            self.model, self.Lambda, self.phi, self.gamma, self.K, self.adaptation, self.saturation
        )
        layer = {"boundary layer": replace(self, saturation="sign")} if layered(self) else {}
        return {"fuzzy rules": plain, "adaptation": plain.without()["adaptation"]} | layer

    def _trend(self, z: Parts, s: ca.SX) -> ca.SX:
        v: ca.SX = (ca.fabs(s) - z["s_slow"]) / self.lag
        return v
