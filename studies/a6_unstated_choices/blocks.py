"""Blocks whose readings are numbers: each slip and each gap of the print as a parameter that a sweep can vary.

All readings are so one equation, and one compiled loop runs them side by side.
"""

from __future__ import annotations

from typing import ClassVar

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.printed_arm import PrintedArm


def pick_part(reading: wb.core.Scalar, *parts: ca.SX) -> ca.SX:
    """The part whose place, counted from 0, is the number `reading`."""
    one = parts[-1]
    for place in reversed(range(len(parts) - 1)):
        one = ca.if_else(reading < place + 0.5, parts[place], one)
    return one


@wb.block
class EitherArm(wb.arms.AbstractArm):
    """The arm with (3) repaired where `misprint` is 0, and as printed where it is 1."""

    repaired: wb.arms.AbstractArm
    printed: PrintedArm
    misprint: wb.core.Scalar = wb.parameter(default=0.0, unit="", low=0, high=1)

    @property
    def dof(self) -> int:
        return self.repaired.dof

    def mass_matrix(self, q: ca.SX) -> ca.SX:
        return self.repaired.mass_matrix(q)

    def coriolis_matrix(self, q: ca.SX, qd: ca.SX) -> ca.SX:
        """Equation (3), either way."""
        return pick_part(self.misprint, *(arm.coriolis_matrix(q, qd) for arm in (self.repaired, self.printed)))

    def gravity_vector(self, q: ca.SX) -> ca.SX:
        return self.repaired.gravity_vector(q)


@wb.block
class EitherObserver(wb.arms.AbstractArmObserver):
    """Positions and velocities as measured where `inside` is 0, those of `state` where it is 1; D_hat by `d_hat`:

    eta' = -l (eta - D),    z' = eta,    D_hat = 0, eta or z where `d_hat` is 0, 1 or 2

    The observer of the state reads the command within -limit and limit where there is a limit.
    """

    uses_truth: ClassVar[bool] = True
    measured_signals: ClassVar[tuple[str, ...]] = ("q", "qd", "d")

    state: wb.arms.observers.Luenberger
    l: wb.core.Scalar = wb.parameter(unit="1/s", low=0, strict=True, symbol="l")
    inside: wb.core.Scalar = wb.parameter(default=1.0, unit="", low=0, high=1)
    d_hat: wb.core.Scalar = wb.parameter(default=0.0, unit="", low=0, high=2)
    limit: wb.core.Vector | None = wb.parameter(default=None, unit="N m", low=0, strict=True, shape=("n",))

    @property
    def model(self) -> wb.arms.AbstractArm:
        return self.state.model

    @property
    def memory(self) -> wb.Layout:
        """That of the observer of the state, eta and its integral."""
        zero = np.zeros(self.dof)
        return self.state.memory + wb.Layout((wb.core.Entry("eta", zero, "N m"), wb.core.Entry("z", zero, "N m s")))

    def estimate(self, t: ca.SX, z: wb.loop.Parts, y: wb.Signals) -> wb.Signals:
        seen = self.state.estimate(t, z, y)
        d = pick_part(self.d_hat, ca.SX.zeros(self.dof), z["eta"], z["z"])
        return wb.Signals(q=pick_part(self.inside, y.q, seen.q), qd=pick_part(self.inside, y.qd, seen.qd), d=d)

    def rate(self, t: ca.SX, z: wb.loop.Parts, y: wb.Signals, est: wb.Signals, u: wb.Signals) -> wb.loop.Parts:
        """(10), which sees its own estimates, and (24)."""
        if self.limit is not None:
            u = wb.Signals(u | {"tau": ca.fmin(ca.fmax(u.tau, -self.limit), self.limit)})
        return {**self.state.rate(t, z, y, est, u), "eta": -self.l * (z["eta"] - y.d), "z": z["eta"]}


@wb.block
class EitherAosmcRgs(wb.arms.laws.AbstractSlidingMode):
    """AOSMC-RGS in every reading, equations (25) to (34) as `AosmcRgs` has them:

    K' = P s sign(s), and -P s sign(s) where `minus` is 1                                            (33)
    P s sign(s) is outer, elementwise, diagonal or norm where `shape` is 0, 1, 2 or 3
    tau_eq with qd_d and qdd_d where `printed` is 1, with qd_r and qdd_r where it is 0               (28)
    """

    estimates: ClassVar[tuple[str, ...]] = ("q", "qd", "d")

    model: wb.arms.AbstractArm
    Lambda: wb.core.Vector = wb.parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="Lambda")
    phi: wb.core.Scalar = wb.parameter(unit="rad/s", low=0, strict=True, symbol="phi")
    K: wb.core.Matrix = wb.initial(unit="N m", shape=("n", "n"), symbol="K")
    P: wb.core.Matrix = wb.initial(unit="N m/rad", shape=("n", "n"), symbol="P")
    Q: wb.core.Scalar = wb.parameter(unit="N m/(rad s)", low=0, symbol="Q")
    R: wb.core.Scalar = wb.parameter(unit="N m/(rad s)", low=0, strict=True, symbol="R")
    minus: wb.core.Scalar = wb.parameter(default=0.0, unit="", low=0, high=1)
    shape: wb.core.Scalar = wb.parameter(default=0.0, unit="", low=0, high=3)
    printed: wb.core.Scalar = wb.parameter(default=0.0, unit="", low=0, high=1)

    def torque(self, t: ca.SX, z: wb.loop.Parts, est: wb.Signals, ref: wb.Signals) -> ca.SX:
        """(27) to (29)."""
        M, C = self.model.mass_matrix(est.q), self.model.coriolis_matrix(est.q, est.qd)
        G = self.model.gravity_vector(est.q)
        _, _, s, qd_r, qdd_r = self._sliding_variables(est, ref)
        qd, qdd = pick_part(self.printed, qd_r, ref.qd), pick_part(self.printed, qdd_r, ref.qdd)
        return ca.SX(M @ qdd + C @ qd + G + est.d - z["K"] @ ca.fmax(ca.fmin(s / self.phi, 1), -1))

    def rate(self, t: ca.SX, z: wb.loop.Parts, est: wb.Signals, ref: wb.Signals) -> wb.loop.Parts:
        """(33) and (34), with Q and R that number times I."""
        s, K, P, n = self._sliding_variables(est, ref).s, z["K"], z["P"], self.dof
        Ps, size = P @ s, ca.fabs(s)
        growth = pick_part(
            self.shape, Ps @ ca.sign(s).T, ca.diag(Ps * ca.sign(s)), P @ ca.diag(size), P * ca.sum1(size)
        )
        A, B = -wb.arms.solve_definite(self.model.mass_matrix(est.q), K), ca.diag(self.Lambda)
        return {
            "K": pick_part(self.minus, growth, -growth),
            "P": A.T @ P + P @ A - P @ B @ B.T @ P / self.R + self.Q * ca.SX.eye(n),
        }


@wb.block
class PlacedPid(wb.arms.AbstractArmController):
    """PID with a triple pole at -p_i for each joint by itself, and with the weight of `model` where `lifted` is 1:

        Kp = 3 p^2 J,   Ki = p^3 J,   Kd = 3 p J

    Where there is a limit, the integral of a joint stands still while its torque is beyond it.

    Parameters
    ----------
    poles, inertia
        (n,), p and J.
    """

    model: wb.arms.AbstractArm
    poles: wb.core.Vector = wb.parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="p")
    inertia: wb.core.Vector = wb.parameter(unit="kg m^2", low=0, strict=True, shape=("n",), symbol="J")
    lifted: wb.core.Scalar = wb.parameter(default=0.0, unit="", low=0, high=1)
    limit: wb.core.Vector | None = wb.parameter(default=None, unit="N m", low=0, strict=True, shape=("n",))
    integral: wb.core.Vector = wb.initial(default=0.0, unit="rad s", shape=("n",))

    def torque(self, t: ca.SX, z: wb.loop.Parts, est: wb.Signals, ref: wb.Signals) -> ca.SX:
        """Feedback, and the weight where it is lifted."""
        p, J = self.poles, self.inertia
        feedback = 3 * p**2 * J * (est.q - ref.q) + p**3 * J * z["integral"] + 3 * p * J * (est.qd - ref.qd)
        return ca.SX(self.lifted * self.model.gravity_vector(est.q) - feedback)

    def rate(self, t: ca.SX, z: wb.loop.Parts, est: wb.Signals, ref: wb.Signals) -> wb.loop.Parts:
        e = est.q - ref.q
        if self.limit is None:
            return {"integral": e}
        return {"integral": ca.if_else(ca.fabs(self.torque(t, z, est, ref)) > self.limit, 0, e)}


@wb.block
class EitherReference(wb.Reference):
    """The path of the first scenario where `jumps` is 0, that of the second where it is 1."""

    sines: wb.Sines
    square: wb.SquareWave
    jumps: wb.core.Scalar = wb.parameter(default=0.0, unit="", low=0, high=1)

    @property
    def gives(self) -> wb.Layout:
        return self.sines.gives

    @property
    def primary(self) -> tuple[str, ...]:
        return self.sines.primary

    def at(self, t: ca.SX) -> wb.Signals:
        square = self.square.at(t)
        return wb.Signals({name: pick_part(self.jumps, part, square[name]) for name, part in self.sines.at(t).items()})
