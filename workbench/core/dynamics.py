"""Dynamics: M(q) qdd + C(q, qd) qd + G(q) = tau, as CasADi expressions with their parameters."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from workbench.core.block import is_block
from workbench.core.layout import Array, Entry, Layout, vector
from workbench.core.lift import Lifted, lift
from workbench.core.show import matrices_to_html
from workbench.core.sockets import require


class AbstractArm(ABC):
    """A block that can say its mass matrix, Coriolis matrix and gravity vector as expressions."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number of joints n."""

    @abstractmethod
    def mass_matrix(self, q: ca.SX) -> ca.SX:
        """M(q), (n, n), in kg m^2."""

    @abstractmethod
    def coriolis_matrix(self, q: ca.SX, qd: ca.SX) -> ca.SX:
        """C(q, qd), (n, n), in kg m^2/s."""

    @abstractmethod
    def gravity_vector(self, q: ca.SX) -> ca.SX:
        """G(q), (n, 1), in N m."""

    def acceleration(self, q: ca.SX, qd: ca.SX, tau: ca.SX) -> ca.SX:
        """qdd = M^-1 (tau - C qd - G), (n, 1), in rad/s^2, by the LDL' factors of M."""
        torque = tau - self.coriolis_matrix(q, qd) @ qd - self.gravity_vector(q)
        return solve_definite(self.mass_matrix(q), torque)


def solve_definite(S: ca.SX, b: ca.SX) -> ca.SX:
    """S^-1 b for a symmetric positive definite S (n, n) and b (n, k), by the LDL' factors of S."""
    D, LT, order = ca.ldl(ca.densify(S), False)
    return ca.densify(ca.ldl_solve(b, D, LT, order))


@dataclass(frozen=True, eq=False)
class Dynamics:
    """The matrices of one arm over symbols q, qd and p: what a user of models sees of a robot.

    Attributes
    ----------
    M, C, G
        (n, n), (n, n) and (n, 1) expressions in `q`, `qd` and the parameters' symbols.
    p
        Names, units, bounds and nominal values of the parameters.
    """

    name: str
    q: ca.SX
    qd: ca.SX
    M: ca.SX
    C: ca.SX
    G: ca.SX
    p: Layout
    symbols: ca.SX

    @staticmethod
    def of(arm: AbstractArm, name: str = "") -> Dynamics:
        """The dynamics of an arm, each of its numbers a symbol if it is a block.

        Raises
        ------
        ValueError
            If `arm` is none.
        """
        require("Dynamics.of(arm=...)", arm, AbstractArm)
        lifted = lift(arm) if is_block(arm) else Lifted(arm, Layout(), ca.SX(0, 1))
        q, qd = (Layout((Entry(letter, np.zeros(arm.dof)),)).symbols() for letter in ("q", "qd"))
        return Dynamics(
            name or type(arm).__name__,
            q,
            qd,
            ca.densify(lifted.block.mass_matrix(q)),
            ca.densify(lifted.block.coriolis_matrix(q, qd)),
            ca.densify(lifted.block.gravity_vector(q)),
            lifted.layout,
            lifted.symbols,
        )

    @property
    def dof(self) -> int:
        """The number of joints n."""
        return int(self.q.numel())

    @property
    def mass_matrix_rate(self) -> ca.SX:
        """M' = the derivative of M(q) along qd, (n, n)."""
        return ca.reshape(ca.jtimes(ca.vec(self.M), self.q, self.qd), self.dof, self.dof)

    @cached_property
    def _function(self) -> ca.Function:
        return ca.Function("dynamics", [self.q, self.qd, self.symbols], [self.M, self.C, self.G], {"cse": True})

    def matrices(self, q: Any, qd: Any, p: Array | None = None) -> tuple[Array, Array, Array]:
        """M (n, n), C (n, n) and G (n,) as numbers at a state, at nominal parameters unless p (np,) is given.

        Raises
        ------
        ValueError
            If q, qd or p is no vector of that many numbers.
        """
        q = vector("Dynamics.matrices(q=...)", q, self.dof, "joints")
        qd = vector("Dynamics.matrices(qd=...)", qd, self.dof, "joints")
        p = self.p.default if p is None else vector("Dynamics.matrices(p=...)", p, self.p.size, "parameters")
        M, C, G = self._function(q, qd, p)
        return np.array(M), np.array(C), np.array(G).ravel()

    def acceleration(self, q: Any, qd: Any, tau: Any, p: Array | None = None) -> Array:
        """qdd (n,) that the torque tau (n,) gives at a state.

        Raises
        ------
        ValueError
            If q, qd, tau or p is no vector of that many numbers.
        """
        M, C, G = self.matrices(q, qd, p)
        tau = vector("Dynamics.acceleration(tau=...)", tau, self.dof, "joints")
        return np.asarray(np.linalg.solve(M, tau - C @ vector("qd", qd, self.dof, "joints") - G))

    def _repr_html_(self) -> str:
        """What a notebook shows: the matrices as equations."""
        return matrices_to_html({"M": self.M, "C": self.C, "G": self.G}, self.names())

    def names(self) -> dict[str, str]:
        """How each symbol of the expressions is printed: the name of the SX to that of the book."""
        joints = {f"{v}[{i}]": f"{v}_{i + 1}" for v in ("q", "qd") for i in range(self.dof)}
        return joints | self.p.printed()
