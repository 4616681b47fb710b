from collections.abc import Mapping
from typing import ClassVar

import casadi as ca

from workbench.arms.arm_contracts import AbstractArmObserver
from workbench.arms.dynamics import AbstractArm
from workbench.arms.observers.arm_full_state import ArmFullState
from workbench.blocks.loop.contracts import EULER, Inputs, Parts, Reads, euler
from workbench.core import Signals, block, initial, option, parameter
from workbench.core.block import Matrix, Number, Vector
from workbench.core.claim import Claim

THEOREM_1 = Claim(
    "Theorem 1",
    "Whatever positive definite L1, L2, zero is a globally exponentially stable error of the observer (10).",
    "Theorem 1, (23)",
    (Claim("gains of Theorem 1", "L1 and L2 are symmetric and positive definite, and nothing more.", "Theorem 1"),),
)


@block
class Luenberger(AbstractArmObserver):
    """A nonlinear observer of Luenberger's structure, fed by positions only, equation (10) of the paper:

        q_hat'  = qd_hat + L1 (q - q_hat)
        qd_hat' = M^-1(q_hat) (tau - C(q_hat, qd_hat) qd_hat - G(q_hat)) + L2 (q - q_hat)

    with M, C, G of `model`: the arm as the designer believes it to be. As printed it settles at a biased state where a
    disturbance acts; "compensated" has tau - D_hat in place of tau, with the D_hat of `StateAndDisturbanceObserver`, or
    0 without one.

    A computer steps it by `integrator`, with e = q - q_hat, v = qd_hat and a = M^-1 (...) as a period h begins:

        "euler"   q_hat+ = q_hat + h (v + L1 e),                        v+ = v + h (a + L2 e)
        "cayley"  q_hat+ = q_hat + h (v + h a / 2 + (L1 + h L2) w),     v+ = v + h (a + L2 w)
                  (I + h L1 / 2 + h^2 L2 / 4) w = e

    Where a is right the errors obey L = [-L1, I; -L2, 0]. Explicit Euler multiplies a mode l of it by 1 + h l, which
    grows where h |l|^2 > -2 Re l; the Cayley step by (1 + h l / 2) / (1 - h l / 2), which decays where l does. Nothing
    is asked of L1, L2, as theorem 1 for any positive definite ones fails.

    References
    ----------
    Adaptive observer-based sliding mode control with time-varying learning using Riccati gain synthesis for robotic
    manipulators, section 3.1.

    Examples
    --------
    >>> from workbench.arms.observers import Luenberger
    >>> law = wb.SlidingMode(wb.paper_arm(), [6.0, 6.0], [40.0, 20.0], 0.1)
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> observer = Luenberger(wb.paper_arm(), 80.0 * np.eye(2), 1600.0 * np.eye(2), [0.5, 0.0], [0.0, 0.0])
    >>> wb.ClosedLoop(plant, observer, law, wanted).ode().states.size
    8
    """

    claims: ClassVar[tuple[Claim, ...]] = (THEOREM_1,)
    measured_signals: ClassVar[tuple[str, ...]] = ("q",)

    model: AbstractArm
    L1: Matrix = parameter(unit="1/s", shape=("n", "n"), symbol="L_1")
    L2: Matrix = parameter(unit="1/s^2", shape=("n", "n"), symbol="L_2")
    q_hat: Vector = initial(unit="{position}", shape=("n",))
    qd_hat: Vector = initial(default=0.0, unit="{position}/s", shape=("n",))
    disturbance: str = option(
        {
            "ignored": "(10) as printed: the observer knows of no disturbance",
            "compensated": "tau - D_hat in place of tau",
        },
        default="ignored",
    )
    integrator: str = option(
        {
            "euler": "(10) by explicit Euler",
            "cayley": "the correction of (10) by its Cayley transform, the model by what its acceleration makes",
        },
        default="euler",
    )

    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return Signals(q=z["q_hat"], qd=z["qd_hat"], d=ca.SX.zeros(self.dof))

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        q_hat, qd_hat = z["q_hat"], z["qd_hat"]
        tau = self.model.joint_torques(u.tau)
        torque = tau - est.d if self.disturbance == "compensated" else tau
        return {
            "q_hat": qd_hat + self.L1 @ (y.q - q_hat),
            "qd_hat": self.model.acceleration(q_hat, qd_hat, torque) + self.L2 @ (y.q - q_hat),
        }

    @property
    def method(self) -> str:
        return "Cayley step of (10)" if self.integrator == "cayley" else EULER

    def advance(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs, period: float) -> Parts:
        rates = self.rate(t, z, y, est, u)
        if self.integrator == "euler":
            return euler(z, rates, period)
        h, L1, L2, e = period, ca.SX(self.L1), ca.SX(self.L2), y.q - z["q_hat"]
        a = rates["qd_hat"] - L2 @ e
        w = ca.solve(ca.SX.eye(self.dof) + h / 2 * L1 + h**2 / 4 * L2, e)
        return {
            "q_hat": z["q_hat"] + h * (z["qd_hat"] + h / 2 * a + (L1 + h * L2) @ w),
            "qd_hat": z["qd_hat"] + h * (a + L2 @ w),
        }

    def without(self) -> Mapping[str, AbstractArmObserver]:
        return {"state observer": ArmFullState(self.dof)}
