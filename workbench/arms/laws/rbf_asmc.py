from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm
from workbench.arms.laws.adaptive_sliding_mode import (
    AbstractAdaptation,
    AbstractAdaptiveSlidingMode,
    AdaptiveSlidingMode,
    NoAdaptation,
    PlainAdaptation,
)
from workbench.arms.laws.sliding_surface import SWITCHINGS, matrices
from workbench.blocks.loop.contracts import EULER, Follows, Parts, Reads, euler
from workbench.core import Entry, Layout, block, initial, option, parameter
from workbench.core.block import Matrix, Number, Scalar, Vector


@block
class RbfAsmc(AbstractAdaptiveSlidingMode):
    """Adaptive sliding mode with a Gaussian network for the torque that the model leaves out:

        s    = ed + Lambda e,                        e = q - q_ref
        tau  = M qdd_r + C qd_r + G + W^T h(x) - K o sat(s / phi),     K(0) >= 0
        W'   = -Gamma h(x) s^T - sigma W,            W(0) = 0
        K_i' = gamma |s_i|                           (`adaptation`: Plain, DeadZone or Leakage)
        h_j(x) = exp(-sum_i ((x_i - c_ji) / b_i)^2 / 2),    x = (e, ed)

    with `centres` (m, 2n), `widths` (2n,) and all else as of `AdaptiveSlidingMode`. The leak sigma keeps W bounded
    where the layer, and what no W can learn, keep s from vanishing. A computer steps W with its leak by `integrator`,
    h(x) and s held over a period T: explicit Euler multiplies W by 1 - sigma T, which is stable for sigma T < 2 only,
    and "exact" by exp(-sigma T).

    References
    ----------
    Lewis et al. (1999), Neural Network Control of Robot Manipulators and Nonlinear Systems.

    Examples
    --------
    >>> from workbench.arms.laws import RbfAsmc
    >>> law = RbfAsmc(wb.paper_arm(), [6.0, 6.0], 0.1, 1.0, 1.0, 0.1, np.ones((3, 4)), np.ones(4), [1.0, 1.0])
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, controller=law, reference=wanted).ode().states.size
    12
    """

    model: AbstractArm
    Lambda: Vector = parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="Lambda")
    phi: Scalar = parameter(unit="{position}/s", low=0, strict=True, symbol="phi")
    gamma: Scalar = parameter(unit="{force}/{position}", low=0, strict=True, symbol="gamma")
    Gamma: Scalar = parameter(unit="{force}/{position}", low=0, strict=True, symbol="Gamma")
    sigma: Scalar = parameter(unit="1/s", low=0, symbol="sigma")
    centres: Matrix = parameter(unit="rad, rad/s", shape=("m", "k"), symbol="c")
    widths: Vector = parameter(unit="rad, rad/s", low=0, strict=True, shape=("k",), symbol="b")
    K: Vector = initial(unit="{force}", shape=("n",), symbol="K")
    adaptation: AbstractAdaptation = PlainAdaptation()
    saturation: str = option(SWITCHINGS, default="clip")
    integrator: str = option(
        {"euler": "K and W by explicit Euler", "exact": "W' exactly, K by explicit Euler"}, default="euler"
    )

    def __post_init__(self) -> None:
        self.check_gains()
        nodes, inputs = np.shape(self.centres)
        if inputs != 2 * self.dof or nodes == 0:
            raise ValueError(
                f"`RbfAsmc(centres=...)` must have shape (m, {2 * self.dof}) with m >= 1: each row is "
                f"a point (e, ed) of the {self.dof} joints. Got {np.shape(self.centres)}."
            )

    @property
    def memory(self) -> Layout:
        W = Entry("W", np.zeros((self.centres.shape[0], self.dof)), self.force, symbol="W")
        return self.gains + Layout((W,))

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        M, C, G = matrices(self.model, est)
        e, ed, s, qd_r, qdd_r = self._sliding_variables(est, ref)
        learned = z["W"].T @ self._h(e, ed)
        return M @ qdd_r + C @ qd_r + G + learned - self._switching_torque(z["K"], s, M)

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        e, ed, s, _, _ = self._sliding_variables(est, ref)
        return {
            "K": self.adaptation.rate(self.gamma * ca.fabs(s), s, z["K"]),
            "W": -self.Gamma * self._h(e, ed) @ s.T - self.sigma * z["W"],
        }

    @property
    def method(self) -> str:
        return f"exact step of W, K by {EULER}" if self.integrator == "exact" else EULER

    def advance(self, t: Number, z: Parts, est: Reads, ref: Follows, period: float) -> Parts:
        rates = self.rate(t, z, est, ref)
        moved = euler(z, rates, period)
        if self.integrator == "euler":
            return moved
        x = self.sigma * period
        # (1 - exp(-x)) / x, which is 1 where nothing is forgotten
        share = ca.if_else(x > 0, (1 - ca.exp(-x)) / ca.if_else(x > 0, x, 1), 1)
        return moved | {"W": z["W"] + period * share * rates["W"]}

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        e, ed, s, _, _ = self._sliding_variables(est, ref)
        return {"s": s, "learned": z["W"].T @ self._h(e, ed)}

    def without(self) -> Mapping[str, AbstractArmController]:
        plain = AdaptiveSlidingMode(
            self.model, self.Lambda, self.phi, self.gamma, self.K, self.adaptation, self.saturation
        )
        return {"network": plain, "adaptation": replace(self, adaptation=NoAdaptation())} | self.without_layer()

    def _h(self, e: ca.SX, ed: ca.SX) -> ca.SX:
        x = ca.vertcat(e, ed)
        nodes = range(self.centres.shape[0])
        far: list[ca.SX] = [ca.sumsqr((x - self.centres[j, :].T) / self.widths) for j in nodes]
        return ca.exp(-ca.vertcat(*far) / 2)
