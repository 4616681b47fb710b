"""AOSMC-RGS: the paper's law, as printed and in each of its readings."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import casadi as ca

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm, solve_definite
from workbench.arms.laws.algebraic_riccati import cayley_step, residual, stabilising_solution
from workbench.arms.laws.sliding_surface import SATURATIONS, AbstractSlidingMode, matrices, saturation
from workbench.blocks.loop.contracts import EULER, Follows, Parts, Reads, euler
from workbench.core import Entry, Layout, block, initial, option, parameter
from workbench.core.block import Matrix, Number, Scalar, Vector
from workbench.core.claim import Claim
from workbench.core.numbers import Bounds
from workbench.core.units import gain

VELOCITIES = {
    "printed": "(28) as printed: qdd_d and qd_d, which leaves Lambda e2 uncancelled in (30)",
    "reference": "qdd_r = qdd_d - Lambda e2 and qd_r = qd_d - Lambda e1: M s' + C s = tau_sw + D_hat - D",
}
FEEDFORWARDS = {
    "model": "(28): M, C and G of the model",
    "none": "tau_eq = D_hat: no model in the torque, to see what it is worth",
}
SIGNS = {
    "printed": "(33) as printed, with a minus",
    "raised": "(33) with a plus: the gain grows with the error",
    "zero": "K' = 0: K stays K(0), to see what (33) is worth",
}
SHAPES = {
    "outer": "the matrix (P s) sign(s)^T; jumps where a component of s changes sign",
    "elementwise": "diag((P s) o sign(s)); jumps where a component of s changes sign",
    "diagonal": "P diag(|s|); continuous",
    "norm": "P times the sum of |s_i|; continuous",
}
RICCATIS = {
    "forward": "(34) as printed, integrated forward from P(0): a forward-propagating Riccati equation",
    "frozen": "P' = 0: P stays P(0), to see what (34) is worth",
    "algebraic": "P' = 0 in (34) at every instant: P solves the algebraic equation of the present A = -M^-1 K",
}
INTEGRATORS = {
    "euler": "K and P by explicit Euler",
    "cayley": "P by a Cayley step of (34) with A as the period begins, which keeps it definite; K by explicit Euler",
}
DOUBLINGS = 10  # of the algebraic equation for three joints and more


def _leading_minors(X: ca.SX) -> ca.SX:
    """The leading principal minors (n, 1) of the symmetric part of X, (n, n) or its columns in one column."""
    n = math.isqrt(X.numel())
    X = ca.reshape(X, n, n)
    S = (X + X.T) / 2
    return ca.vertcat(*(ca.det(S[: k + 1, : k + 1]) for k in range(n)))


K_STAYS_DEFINITE = Claim(
    "K stays positive definite",
    "The symmetric part of the gain K(t) is positive definite at all times, as (29) asks.",
    "(29), (33)",
    margin=lambda y: _leading_minors(y["K"]),
)
P_STAYS_DEFINITE = Claim(
    "P stays positive definite",
    "P(t) of (34) is positive definite at all times, from such a P(0).",
    "(34)",
    margin=lambda y: _leading_minors(y["P"]),
)


@block
class AosmcRgs(AbstractSlidingMode):
    """Adaptive observer-based sliding mode control with Riccati gain synthesis, equations (25) to (34):

        e1  = q_hat - q_d,   e2 = qd_hat - qd_d,   s = e2 + Lambda e1                    (25), (26)
        tau = tau_eq + tau_sw                                                                 (27)
        tau_eq = M qdd_d + C qd_d + G + D_hat                                                 (28)
        tau_sw = -K sat(s / phi)                                                              (29)
        A = -M^-1 K,   B = Lambda                                                             (31)
        K' = -P s sign(s)                                                                     (33)
        P' = A^T P + P A - P B R^-1 B^T P + Q                                                 (34)

    with M, C, G of `model` at the estimates q_hat, qd_hat, and Q, R the weights of (32). Each slip of the print is a
    named option, whose first choice is the print. A symmetric K stays so in the shapes "elementwise" and "norm" of (33)
    only, and nothing keeps it definite. With riccati "algebraic" P is no state: it is solved for at each instant, and
    the signals "P" and "residual" show it and what it leaves of its equation relative to the terms.

    A computer steps K and P by `integrator`. Explicit Euler multiplies P by 1 - 2 h |a| for a mode a of A, and so loses
    it where a period h is longer than 1 / |a|; the Cayley step of (34) loses it at none.

    Raises
    ------
    ValueError
        If P, Q, R or the integrator do not suit `riccati`: "algebraic" takes no P, "frozen" neither Q nor R.

    References
    ----------
    Adaptive observer-based sliding mode control with time-varying learning using Riccati gain synthesis for robotic
    manipulators, sections 3.3 and 3.4.

    Examples
    --------
    >>> from workbench.arms.laws import AosmcRgs
    >>> from workbench.arms.observers import NonlinearDisturbanceObserver, StateAndDisturbanceObserver
    >>> law = AosmcRgs(wb.paper_arm(), [6.0, 6.0], 0.1, K=np.eye(2), P=np.eye(2), Q=np.eye(2), R=np.eye(2))
    >>> disturbance = NonlinearDisturbanceObserver(wb.paper_arm(), 20.0, [0.0, 0.0])
    >>> observer = StateAndDisturbanceObserver(wb.ArmFullState(2), disturbance)
    >>> plant, wanted = wb.Manipulator(wb.paper_arm(), q=[0.5, 0.0]), wb.Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    >>> wb.ClosedLoop(plant, observer, law, wanted).ode().states.size
    14
    """

    claims: ClassVar[tuple[Claim, ...]] = (K_STAYS_DEFINITE, P_STAYS_DEFINITE)
    estimates: ClassVar[tuple[str, ...]] = ("q", "qd", "d")

    model: AbstractArm
    Lambda: Vector = parameter(unit="1/s", low=0, strict=True, shape=("n",), symbol="Lambda")
    phi: Scalar = parameter(unit="{position}/s", low=0, strict=True, symbol="phi")
    K: Matrix = initial(unit="{force}", shape=("n", "n"), symbol="K")
    P: Matrix = initial(default=None, unit="{force}/{position}", shape=("n", "n"), symbol="P")
    Q: Matrix = parameter(
        default=None, unit="{force}/({position} s)", symmetric=True, definite="semi", shape=("n", "n"), symbol="Q"
    )
    R: Matrix = parameter(
        default=None, unit="{force}/({position} s)", symmetric=True, definite="positive", shape=("n", "n"), symbol="R"
    )
    velocity: str = option(VELOCITIES, default="printed")
    gain_sign: str = option(SIGNS, default="printed")
    gain_shape: str = option(SHAPES, default="outer")
    riccati: str = option(RICCATIS, default="forward")
    # no "implicit": (33) does not keep K such that M s' = -K sign(s) has one solution
    saturation: str = option(SATURATIONS, default="clip")
    feedforward: str = option(FEEDFORWARDS, default="model")
    integrator: str = option(INTEGRATORS, default="euler")

    def __post_init__(self) -> None:
        takes = {"forward": ("P", "Q", "R"), "frozen": ("P",), "algebraic": ("Q", "R")}[self.riccati]
        came = tuple(name for name in ("P", "Q", "R") if getattr(self, name) is not None)
        if came != takes:
            raise ValueError(
                f"`AosmcRgs(riccati='{self.riccati}')` must have {' and '.join(takes)} and no other of P, Q and R, as "
                f"{RICCATIS[self.riccati]}; got {' and '.join(came) or 'none'}."
            )
        if self.integrator == "cayley" and self.riccati != "forward":
            raise ValueError(
                f"`AosmcRgs(integrator='cayley')` is a step of (34), which riccati='{self.riccati}' does not "
                "take: leave it out."
            )
        for name in takes:
            bounds = Bounds(symmetric=True, definite="positive" if name == "R" else "semi")
            bounds.refuse_unsymmetric(f"AosmcRgs({name}=...)", getattr(self, name)[None])

    @property
    def mixed_units(self) -> str:
        reason = "A = -M^-1 K of (31) has the unit 1/s^2, and (34) takes it for a rate"
        return "" if self.riccati == "frozen" else reason

    @property
    def memory(self) -> Layout:
        K = Entry("K", self.K, self.force, symbol="K")
        return Layout((K,) if self.P is None else (K, Entry("P", self.P, gain(self.force, self.position), symbol="P")))

    def torque(self, t: Number, z: Parts, est: Reads, ref: Follows) -> ca.SX:
        M, C, G = matrices(self.model, est)
        _, _, s, qd_r, qdd_r = self._sliding_variables(est, ref)
        if self.velocity == "printed":
            qd_r, qdd_r = ref.qd, ref.qdd
        tau_eq = M @ qdd_r + C @ qd_r + G + est.d if self.feedforward == "model" else est.d
        tau_sw = -z["K"] @ saturation(s, self.phi, self.saturation)
        return tau_eq + tau_sw

    def rate(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Parts:
        s = self._sliding_variables(est, ref).s
        algebraic = self.riccati == "algebraic"
        growth = self._growth(self._algebraic(z, est)[0] if algebraic else z["P"], s)
        K_rate = {"raised": growth, "zero": ca.SX.zeros(growth.shape), "printed": -growth}[self.gain_sign]
        return {"K": K_rate} if algebraic else {"K": K_rate, "P": self._riccati(z, est)}

    @property
    def method(self) -> str:
        return "K by explicit Euler, P by a Cayley step of (34)" if self.integrator == "cayley" else EULER

    def advance(self, t: Number, z: Parts, est: Reads, ref: Follows, period: float) -> Parts:
        moved = euler(z, self.rate(t, z, est, ref), period)
        if self.integrator == "euler":
            return moved
        A, G, Q = self._riccati_matrices(z, est)
        return moved | {"P": cayley_step(A, G, Q, z["P"], period)}

    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        s = {"s": self._sliding_variables(est, ref).s}
        if self.riccati != "algebraic":
            return s
        P, left = self._algebraic(z, est)
        return s | {"P": P, "residual": left}

    def without(self) -> Mapping[str, AbstractArmController]:
        still = (
            replace(self, riccati="frozen", Q=None, R=None, integrator="euler") if self.riccati == "forward" else self
        )
        adaptation = {"adaptation of K": replace(still, gain_sign="zero")} if self.gain_sign != "zero" else {}
        riccati = {"Riccati equation": still} if still is not self else {}
        model = {"model in the torque": replace(self, feedforward="none")} if self.feedforward == "model" else {}
        return adaptation | riccati | model | self.without_layer()

    def _growth(self, P: ca.SX, s: ca.SX) -> ca.SX:
        """P s sign(s) of (33), (n, n), in the chosen reading."""
        match self.gain_shape:
            case "outer":
                return (P @ s) @ ca.sign(s).T
            case "elementwise":
                return ca.diag((P @ s) * ca.sign(s))
            case "diagonal":
                return P @ ca.diag(ca.fabs(s))
            case _:
                return P * ca.sum1(ca.fabs(s))

    def _riccati(self, z: Parts, est: Reads) -> ca.SX:
        if self.riccati == "frozen":
            return ca.SX.zeros(self.dof, self.dof)
        K, P, B = z["K"], z["P"], ca.diag(self.Lambda)
        A = -solve_definite(self.model.mass_matrix(est.q), K)
        rate: ca.SX = A.T @ P + P @ A - P @ B @ ca.solve(self.R, B.T @ P) + self.Q
        return rate

    def _algebraic(self, z: Parts, est: Reads) -> tuple[ca.SX, ca.SX]:
        """The stabilising P of (34) with P' = 0, (n, n), and its residual."""
        A, G, Q = self._riccati_matrices(z, est)
        P = stabilising_solution(A, G, Q, DOUBLINGS)
        return P, residual(A, G, Q, P)

    def _riccati_matrices(self, z: Parts, est: Reads) -> tuple[ca.SX, ca.SX, ca.SX]:
        """A, G = B R^-1 B^T and Q of (34), each (n, n)."""
        A, B = -solve_definite(self.model.mass_matrix(est.q), z["K"]), ca.SX(ca.diag(self.Lambda))
        return A, B @ ca.solve(self.R, B.T), self.Q
