"""An arm with the forces of another one and the mass matrix I, so that no acceleration holds a quotient."""

from __future__ import annotations

import casadi as ca

from workbench.core import AbstractArm, block


@block
class UnitMassArm(AbstractArm):
    """M = I, with C and G of `arm`: its acceleration tau - C qd - G is M times that of `arm`.

    Normal forms have no quotients, and M^-1 is one; what is said of M times an acceleration needs none.
    """

    arm: AbstractArm

    @property
    def dof(self) -> int:
        """As many joints."""
        return self.arm.dof

    def mass_matrix(self, q: ca.SX) -> ca.SX:
        """I."""
        del q
        return ca.SX(ca.DM.eye(self.dof))

    def coriolis_matrix(self, q: ca.SX, qd: ca.SX) -> ca.SX:
        """That of the arm."""
        return self.arm.coriolis_matrix(q, qd)

    def gravity_vector(self, q: ca.SX) -> ca.SX:
        """That of the arm."""
        return self.arm.gravity_vector(q)
