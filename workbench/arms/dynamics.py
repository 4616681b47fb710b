"""Dynamics: M(q) qdd + C(q, qd) qd + G(q) = tau, as CasADi expressions with their parameters."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core.block import Column, is_block
from workbench.core.expressions import refuse_misfit, refuse_unknown
from workbench.core.layout import Entry, Layout
from workbench.core.model_probe import AbstractModel, Probe
from workbench.core.notation import mathml
from workbench.core.notation.formula import Formula, System
from workbench.core.notation.reader import equations_of
from workbench.core.shapes import Shape
from workbench.core.symbolic_twin import SymbolicTwin, lift
from workbench.core.validation.refusals import Array, refusal, vector
from workbench.core.validation.signatures import check_arguments

MOST_JOINTS = 1_000  # of a block; the equations of far fewer take minutes


class AbstractArm(AbstractModel):
    """A block with a mass matrix, a Coriolis matrix and a gravity vector as expressions."""

    @property
    @abstractmethod
    def dof(self) -> int:
        """The number of joints n."""

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each joint's position: rad where it turns, m where it slides."""
        return ("rad",) * self.dof

    @property
    def motors(self) -> tuple[int, ...]:
        """The joints that have a motor, in order: all of them, unless the arm says otherwise."""
        return tuple(range(self.dof))

    @abstractmethod
    def mass_matrix(self, q: Column) -> ca.SX:
        """M(q), (n, n): in kg m^2 between two hinges, in kg between two slides, in kg m between a hinge and a slide."""

    @abstractmethod
    def coriolis_matrix(self, q: Column, qd: Column) -> ca.SX:
        """C(q, qd), (n, n), in the units of M per second."""

    @abstractmethod
    def gravity_vector(self, q: Column) -> ca.SX:
        """G(q), (n, 1), in N m where a joint turns, in N where it slides."""

    def probe(self) -> Probe:
        """An arm of as many joints whose M, C and G are symbols."""
        n = self.dof
        symbols = {"M": ca.SX.sym("M", n, n), "C": ca.SX.sym("C", n, n), "G": ca.SX.sym("G", n)}
        return Probe(_SymbolicArm(**symbols), symbols)

    def drawing(self, q: Column) -> tuple[Shape, ...] | None:
        """The picture of the arm, in m to the right and upward; None: no picture."""
        del q
        return None

    @check_arguments
    def recursion(self, q: Column, qd: Column, qdd: Column) -> ca.SX | None:
        """The torque, (n, 1), of an arm that has a recursion, which forms neither M nor C; else None."""
        return None

    @check_arguments
    def torque(self, q: Column, qd: Column, qdd: Column) -> ca.SX:
        """tau = M qdd + C qd + G, (n, 1), in N m or N, and the friction of an arm that has any."""
        tau = self.recursion(q, qd, qdd)
        if tau is None:
            tau = self.mass_matrix(q) @ qdd + self.coriolis_matrix(q, qd) @ qd + self.gravity_vector(q)
        return tau

    @check_arguments
    def joint_torques(self, tau: ca.SX) -> ca.SX:
        """The torque at each joint, (n, 1), where the motors' torques are `tau`: none at a joint without a motor."""
        if len(self.motors) == self.dof:
            return tau
        refuse_misfit("driven", "tau", tau, len(self.motors), 1, "a torque for each motor")
        joints = ca.SX(self.dof, 1)
        for i, joint in enumerate(self.motors):
            joints[joint] = tau[i]
        return joints

    @check_arguments
    def acceleration(self, q: Column, qd: Column, tau: Column) -> ca.SX:
        """qdd = M^-1 (tau - C qd - G), (n, 1), in rad/s^2 or m/s^2, by the LDL' factors of M."""
        bias = self.recursion(q, qd, ca.SX(self.dof, 1))
        net = tau - self.coriolis_matrix(q, qd) @ qd - self.gravity_vector(q) if bias is None else tau - bias
        return solve_definite(self.mass_matrix(q), net)


@dataclass(frozen=True, eq=False)
class _SymbolicArm(AbstractArm):
    """An arm whose matrices are symbols plus terms in their arguments, to find where equations have them."""

    M: ca.SX
    C: ca.SX
    G: ca.SX

    @property
    def dof(self) -> int:
        return int(self.G.numel())

    def mass_matrix(self, q: Column) -> ca.SX:
        return self.M + ca.sum1(q)

    def coriolis_matrix(self, q: Column, qd: Column) -> ca.SX:
        return self.C + ca.sum1(q) + ca.sum1(qd)

    def gravity_vector(self, q: Column) -> ca.SX:
        return self.G + ca.sum1(q)

    def acceleration(self, q: Column, qd: Column, tau: Column) -> ca.SX:
        return self.mass_matrix(q) @ (tau + self.coriolis_matrix(q, qd) @ qd + self.gravity_vector(q))


@check_arguments
def solve_definite(S: ca.SX, b: ca.SX) -> ca.SX:
    """S^-1 b for a symmetric positive definite S (n, n) and b (n, k), by the LDL' factors of S."""
    refuse_misfit("solve_definite", "S", S, S.shape[0], S.shape[0], "as it is square")
    refuse_misfit("solve_definite", "b", b, S.shape[0], b.shape[1], "with as many rows as S")
    D, LT, order = ca.ldl(ca.densify(S), False)
    return ca.densify(ca.ldl_solve(b, D, LT, order))


@dataclass(frozen=True, eq=False)
@check_arguments
class Dynamics:
    """The matrices of one arm over symbols q, qd and p."""

    name: str
    q: ca.SX
    qd: ca.SX
    M: ca.SX  # (n, n), as C; in q, qd and the symbols
    C: ca.SX
    G: ca.SX  # (n, 1)
    p: Layout
    symbols: ca.SX  # of p
    recursion: tuple[ca.SX, ca.SX] | None = None  # symbols of the acceleration, (n, 1), and the torque, with friction
    units: tuple[str, ...] = ()  # of each joint's position, "rad" or "m"; rad where none are given
    motors: tuple[int, ...] = ()  # the joints that have one; all where none are given

    def __post_init__(self) -> None:
        n = self.dof
        object.__setattr__(self, "units", self.units or ("rad",) * n)
        object.__setattr__(self, "motors", self.motors or tuple(range(n)))
        if len(self.units) != n or not set(self.units) <= {"rad", "m"}:
            raise refusal("Dynamics(units=...)", f"'rad' or 'm' for each of the {n} joints", self.units)
        if not set(self.motors) <= set(range(n)):
            raise ValueError(f"`Dynamics(motors=...)` must be joints counted from 0 to {n - 1}; got {self.motors}.")
        qdd, tau = self.recursion or (ca.SX.sym("qdd", n), ca.SX(n, 1))
        shapes = {"q": (n, 1), "qd": (n, 1), "M": (n, n), "C": (n, n), "G": (n, 1), "symbols": (self.p.size, 1)}
        for name, shape in shapes.items():
            refuse_misfit("Dynamics", name, getattr(self, name), *shape)
        for part in (qdd, tau):
            refuse_misfit("Dynamics", "recursion", part, n, 1)
        symbols = {"q": self.q, "qd": self.qd, "symbols": self.symbols}
        refuse_unknown("Dynamics", symbols, M=self.M, C=self.C, G=self.G)
        refuse_unknown("Dynamics", {**symbols, "qdd": qdd}, recursion=tau)

    @staticmethod
    @check_arguments
    def of(arm: AbstractArm, name: str = "", symbolic: bool = True) -> Dynamics:
        """The dynamics of an arm; the numbers of a block become symbols unless `symbolic` is False."""
        lifted = lift(arm) if symbolic and is_block(arm) else SymbolicTwin(arm, Layout(), ca.SX(0, 1))
        q, qd, qdd = (Layout((Entry(letter, np.zeros(arm.dof)),)).symbols() for letter in ("q", "qd", "qdd"))
        M = ca.densify(lifted.block.mass_matrix(q))
        C = ca.densify(lifted.block.coriolis_matrix(q, qd))
        G = ca.densify(lifted.block.gravity_vector(q))
        tau = lifted.block.recursion(q, qd, qdd)
        recursion = None if tau is None else (qdd, ca.densify(tau))
        label = name or type(arm).__name__
        return Dynamics(label, q, qd, M, C, G, lifted.layout, lifted.symbols, recursion, arm.units, arm.motors)

    @property
    def dof(self) -> int:
        """The number of joints n."""
        return int(self.q.numel())

    @cached_property
    def qdd(self) -> ca.SX:
        """The symbols of the acceleration, (n, 1)."""
        return Layout((Entry("qdd", np.zeros(self.dof)),)).symbols() if self.recursion is None else self.recursion[0]

    @cached_property
    def tau(self) -> ca.SX:
        """The torque that the acceleration takes, (n, 1): M qdd + C qd + G, and friction if the arm has any."""
        if self.recursion is not None:
            return self.recursion[1]
        return ca.densify(self.M @ self.qdd + self.C @ self.qd + self.G)

    @property
    def mass_matrix_rate(self) -> ca.SX:
        """M' = the derivative of M(q) along qd, (n, n)."""
        return ca.reshape(ca.jtimes(ca.vec(self.M), self.q, self.qd), self.dof, self.dof)

    @cached_property
    def _shared_expressions(self) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """M, C, G and tau with each common subexpression once."""
        M, C, G, tau = ca.cse([self.M, self.C, self.G, self.tau])
        return M, C, G, tau

    @cached_property
    def _function(self) -> ca.Function:
        return ca.Function("dynamics", [self.q, self.qd, self.symbols], self._shared_expressions[:3])

    @cached_property
    def inverse_dynamics(self) -> ca.Function:
        """(q, qd, qdd, p) -> tau (n, 1), dtau/dq (n, n), dtau/dqd (n, n); dtau/dqdd is M."""
        tau = self._shared_expressions[3]
        derivatives = [ca.densify(ca.jacobian(tau, by)) for by in (self.q, self.qd)]
        return ca.Function("inverse_dynamics", [self.q, self.qd, self.qdd, self.symbols], [tau, *derivatives])

    @cached_property
    def forward_dynamics(self) -> ca.Function:
        """(q, qd, tau, p) -> qdd (n, 1), dqdd/dq, dqdd/dqd, dqdd/dtau = M^-1, (n, n) each.

        With tau held, M qdd + bias = tau differentiates to M dqdd/dx = -dtau/dx, taken at that qdd.
        """
        M, n, tau = self._shared_expressions[0], self.dof, ca.SX.sym("tau", self.dof)
        bias = ca.substitute(self._shared_expressions[3], self.qdd, ca.SX.zeros(n))
        qdd = solve_definite(M, tau - bias)
        _, by_q, by_qd = self.inverse_dynamics(self.q, self.qd, qdd, self.symbols)
        solved = solve_definite(M, ca.horzcat(-by_q, -by_qd, ca.SX.eye(n)))
        return ca.Function("forward_dynamics", [self.q, self.qd, tau, self.symbols], [qdd, *ca.horzsplit(solved, n)])

    def _at(self, call: str, p: Array | None, **state: object) -> list[Array]:
        vectors = [vector(f"{call}({name}=...)", value, self.dof, "joints") for name, value in state.items()]
        return [*vectors, self.p.default if p is None else vector(f"{call}(p=...)", p, self.p.size, "parameters")]

    def matrices(self, q: object, qd: object, p: Array | None = None) -> tuple[Array, Array, Array]:
        """M (n, n), C (n, n) and G (n,) as numbers at a state, at nominal parameters unless p (np,) is given."""
        M, C, G = self._function(*self._at("Dynamics.matrices", p, q=q, qd=qd))
        return np.array(M), np.array(C), np.array(G).ravel()

    def torque(self, q: object, qd: object, qdd: object, p: Array | None = None) -> Array:
        """tau (n,) that an acceleration qdd (n,) takes at a state."""
        return np.array(self.inverse_dynamics(*self._at("Dynamics.torque", p, q=q, qd=qd, qdd=qdd))[0]).ravel()

    def acceleration(self, q: object, qd: object, tau: object, p: Array | None = None) -> Array:
        """qdd (n,) that the torque tau (n,) gives at a state."""
        return np.array(self.forward_dynamics(*self._at("Dynamics.acceleration", p, q=q, qd=qd, tau=tau))[0]).ravel()

    def __repr__(self) -> str:
        return f"<Dynamics of '{self.name}': {self.dof} joints, {self.p.size} parameters>"

    def _repr_html_(self) -> str:
        definitions, equations = equations_of({"M": self.M, "C": self.C, "G": self.G}, self.names())
        blocks: list[Formula] = [System(definitions), *equations] if definitions else [*equations]
        return "\n".join(mathml.emit(block) for block in blocks)

    def names(self) -> dict[str, str]:
        """The printed name of each symbol of the expressions, by the name of the SX."""
        joints = {f"{v}[{i}]": f"{v}_{i + 1}" for v in ("q", "qd") for i in range(self.dof)}
        return joints | self.p.printed_names()
