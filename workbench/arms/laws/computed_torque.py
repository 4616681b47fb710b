from typing import ClassVar

import casadi as ca

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm
from workbench.arms.laws.sliding_surface import EXACT_ESTIMATES, ROUNDING, matrices
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import block, parameter
from workbench.core.block import Number, Vector
from workbench.core.claim import Claim

EXACT_DISTURBANCE = Claim(
    "the exact disturbance",
    "D_hat = D at all times, to 1e-9 N m.",
    "`OracleFilter`, or no disturbance",
    margin=lambda y: 1e-9 - ca.fabs(y["d_error"]),
)
ERROR_IS_LINEAR = Claim(
    "the error is linear",
    "With the right model e'' + Kd e' + Kp e = 0, to 1e-7 rad/s^2.",
    "Siciliano et al. (2009), section 8.5.2",
    (EXACT_ESTIMATES, EXACT_DISTURBANCE),
    lambda y: ROUNDING - ca.fabs(y["ed'"] + y["Kd"] * y["ed"] + y["Kp"] * y["e"]),
)


@block
class ComputedTorque(AbstractArmController):
    """Feedback linearisation, with compensation of the disturbance that the observer estimates:

        tau = M (qdd_ref - Kd ed - Kp e) + C qd + G + D_hat,        e = q - q_ref

    with M, C, G of `model`, the arm as the designer believes it to be, at the estimated state. With the right model and
    exact estimates e'' + Kd e' + Kp e = M^-1 (D_hat - D): joints of the frequency w and the damping ratio zeta by
    Kp = w^2, Kd = 2 zeta w. Beside an observer without a disturbance D_hat = 0.

    References
    ----------
    Siciliano et al. (2009), Robotics: Modelling, Planning and Control, section 8.5.2 (inverse dynamics control).
    Chen et al. (2000), A nonlinear disturbance observer for robotic manipulators, IEEE TIE 47(4).

    Examples
    --------
    >>> from workbench.arms.laws import ComputedTorque
    >>> from workbench.arms.observers import MomentumObserver, StateAndDisturbanceObserver
    >>> law = ComputedTorque(wb.paper_arm(), Kp=[100.0, 100.0], Kd=[20.0, 20.0])
    >>> observer = StateAndDisturbanceObserver(wb.ArmFullState(2), MomentumObserver(wb.paper_arm(), 20.0, [0.0, 0.0]))
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, observer, law, wanted).ode().states.size
    6
    """

    claims: ClassVar[tuple[Claim, ...]] = (ERROR_IS_LINEAR,)
    estimates: ClassVar[tuple[str, ...]] = ("q", "qd", "d")

    model: AbstractArm
    Kp: Vector = parameter(unit="1/s^2", low=0, shape=("n",), symbol="K_p")
    Kd: Vector = parameter(unit="1/s", low=0, shape=("n",), symbol="K_d")

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        M, C, G = matrices(self.model, est)
        e, ed = est.q - ref.q, est.qd - ref.qd
        tau: ca.SX = M @ (ref.qdd - self.Kd * ed - self.Kp * e) + C @ est.qd + G + est.d
        return tau
