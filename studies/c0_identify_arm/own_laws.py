"""Two laws of this study: torques that were designed beforehand, and a law that makes up for a modelled friction."""

from __future__ import annotations

import casadi as ca

import workbench as wb


@wb.block
class PlayedTorque(wb.arms.AbstractArmController):
    """The torques of a designed experiment, which no reading changes:  tau_j = c_j + sum_k a_jk sin(w_k t + phi_jk)."""

    model: wb.arms.mechanics.PlanarArm
    constant: wb.Array = wb.parameter(unit="N m", shape=("n",))
    amplitudes: wb.Array = wb.parameter(unit="N m", shape=("n", "k"))
    frequencies: wb.Array = wb.parameter(unit="rad/s", shape=("k",))
    phases: wb.Array = wb.parameter(unit="rad", shape=("n", "k"))

    def torque(self, t, z, est, ref):  # type: ignore[no-untyped-def]
        """The torques at a time."""
        rows = [ca.sum2(self.amplitudes[j, :] * ca.sin(self.frequencies.T * t + self.phases[j, :])) for j in (0, 1)]
        return self.constant + ca.vertcat(*rows)


@wb.block
class FrictionCompensation(wb.arms.AbstractArmController):
    """A law without memory and the friction that is modelled, at the velocity of the reference:

    tau = tau_law + F(qd_ref)
    """

    estimates = ("q", "qd", "d")  # D_hat for laws that read it; zero beside an observer of the state alone

    law: wb.arms.AbstractArmController
    friction: wb.arms.Friction

    @property
    def dof(self) -> int:
        """The number of joints."""
        return self.law.dof

    @property
    def units(self) -> tuple[str, ...]:
        """The units of the joints."""
        return self.law.units

    def torque(self, t, z, est, ref):  # type: ignore[no-untyped-def]
        """The torque of the law and of the friction."""
        return self.law.torque(t, z, est, ref) + self.friction.torque(ref.qd)
