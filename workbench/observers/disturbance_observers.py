"""Disturbance observers that can be built: from the torque, the model and the estimated state."""

from __future__ import annotations

from typing import ClassVar

import casadi as ca

from workbench.core import AbstractArm, Signals, block, initial, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.core.claim import Claim
from workbench.loop.contracts import Inputs, Parts, Reads
from workbench.observers.disturbance import AbstractDisturbanceObserver
from workbench.observers.promises import CHEN_DISSIPATES, MOMENTUM_FOLLOWS


@block
class NonlinearDisturbanceObserver(AbstractDisturbanceObserver):
    """The nonlinear disturbance observer with gain L(q) = l M^-1(q), for M qdd + C qd + G + D = tau:

        D_hat = z - l qd
        z'    = l M^-1 (tau - C qd - G - D_hat)

    with M, C, G of `model` at the estimated state. As M qdd = tau - C qd - G - D,

        D_hat' = z' - l qdd = l M^-1 (D - D_hat),

    so with the right model and a true velocity the error E = D - D_hat obeys E' = D' - l M^-1(q) E:
    no acceleration is needed, a constant D is found at the rate l / max eig M at least, and
    otherwise |E| comes within (max eig M / l) times the bound of |D'|. What the model leaves out counts as D.

    Beside `Luenberger` qd_hat is not the derivative of q_hat's arm but of its copy, whose disturbance is
    -M L2 (q - q_hat), less D_hat where it is compensated: this is what D_hat follows. Ignored, that is D
    behind the observer; compensated, D_hat' = -l L2 (q - q_hat) is one more integrator in the
    observer's loop, which a large l makes unstable.

    Parameters
    ----------
    z
        (n,), the memory at time 0; l qd(0) makes D_hat(0) = 0.

    References
    ----------
    Chen, Ballance, Gawthrop and O'Reilly (2000), A nonlinear disturbance observer for robotic
    manipulators, IEEE Transactions on Industrial Electronics 47(4).
    Mohammadi, Tavakoli, Marquez and Hashemzadeh (2013), Nonlinear disturbance observer design for
    robotic manipulators, Control Engineering Practice 21(3) (the gain through M^-1, for any arm).
    """

    claims: ClassVar[tuple[Claim, ...]] = (CHEN_DISSIPATES,)

    model: AbstractArm
    l: Scalar = parameter(unit="kg m^2/s", low=0, strict=True, symbol="l")
    z: Vector = initial(default=0.0, unit="{force}", shape=("n",), symbol="z")

    @property
    def dof(self) -> int:
        """The number of joints of the model."""
        return self.model.dof

    @property
    def uses_truth(self) -> bool:
        """No."""
        return False

    def estimate(self, t: Number, z: Parts, y: Reads, est: Signals) -> ca.SX:
        """D_hat = z - l qd."""
        del t, y
        d: ca.SX = z["z"] - self.l * est.qd
        return d

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The rate of z, l M^-1 (tau - C qd - G - D_hat)."""
        del t, z, y
        return {"z": self.l * self.model.acceleration(est.q, est.qd, self.model.driven(u.tau) - est.d)}


@block
class MomentumObserver(AbstractDisturbanceObserver):
    """The observer of the generalized momentum p = M(q) qd, for M qdd + C qd + G + D = tau:

        p_hat' = tau + C^T qd - G - D_hat
        D_hat  = l (p_hat - p)

    with M, C, G of `model` at the estimated state. With the C of the Christoffel symbols
    M' = C + C^T, so p' = tau + C^T qd - G - D and, with the right model and a true velocity,

        D_hat' = l (D - D_hat)

    exactly: each joint by itself, and at the same rate wherever the arm is.

    Parameters
    ----------
    p_hat
        (n,), the memory at time 0; M(q(0)) qd(0) makes D_hat(0) = 0.

    References
    ----------
    De Luca and Mattone (2003), Actuator failure detection and isolation using generalized momenta,
    IEEE International Conference on Robotics and Automation.
    """

    claims: ClassVar[tuple[Claim, ...]] = (MOMENTUM_FOLLOWS,)
    noun: ClassVar[str] = "momentum"

    model: AbstractArm
    l: Scalar = parameter(unit="1/s", low=0, strict=True, symbol="l")
    p_hat: Vector = initial(default=0.0, unit="{force} s", shape=("n",))

    @property
    def dof(self) -> int:
        """The number of joints of the model."""
        return self.model.dof

    @property
    def uses_truth(self) -> bool:
        """No."""
        return False

    def estimate(self, t: Number, z: Parts, y: Reads, est: Signals) -> ca.SX:
        """D_hat = l (p_hat - M qd)."""
        del t, y
        p = self.model.mass_matrix(est.q) @ est.qd
        d: ca.SX = self.l * (z["p_hat"] - p)
        return d

    def rate(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The rate of p_hat, tau + C^T qd - G - D_hat."""
        del t, z, y
        C, G = self.model.coriolis_matrix(est.q, est.qd), self.model.gravity_vector(est.q)
        return {"p_hat": self.model.driven(u.tau) + C.T @ est.qd - G - est.d}
