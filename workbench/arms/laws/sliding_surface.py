"""The base of the sliding laws: the surface, the switching term, and the relay in discrete time."""

from dataclasses import replace
from typing import ClassVar, NamedTuple, Self

import casadi as ca

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.dynamics import AbstractArm, solve_definite
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core.block import Scalar, Vector
from workbench.core.claim import Claim, SignalValues
from workbench.core.validation.signatures import check_arguments

ROUNDING = 1e-7  # of rates that are exact but for the last digits
SWEEPS, GUESSES = 5, 4  # for three joints and more: enough for all of some thousand random matrices up to n = 7

SATURATIONS = {
    "clip": "sat(x) = x within -1 and 1, sign(x) outside: continuous, with a corner at the layer's edge",
    "tanh": "sat(x) = tanh(x): smooth, within 1e-4 of sign(x) only from 5 phi on",
    "sign": "sign(s), a relay without a layer, which chatters at the steps of its computer, or else of the solver",
}
SWITCHINGS = SATURATIONS | {
    "implicit": "a relay without a layer, by backward Euler over a sampling period; only in a sampled loop",
}


def _pulled_by_the_surface(y: SignalValues) -> ca.SX:
    """|e_i| |s_i| - Lambda_i e_i^2 - e_i e_i': >= 0, but for rounding, where e' = s - Lambda e."""
    e, s = y["e"], y["s"]
    return ca.fabs(e) * ca.fabs(s) - y["Lambda"] * e**2 - e * y["e'"] + ROUNDING


EXACT_ESTIMATES = Claim(
    "exact estimates",
    "q_hat = q and qd_hat = qd at all times, to 1e-7 rad and rad/s.",
    "`ArmFullState`",
    margin=lambda y: ROUNDING - ca.fabs(ca.vertcat(y["q_error"], y["qd_error"])),
)
SURFACE_PULLS_THE_ERROR = Claim(
    "the surface pulls the error",
    "e_i e_i' <= |e_i| |s_i| - Lambda_i e_i^2 + 1e-7 rad^2/s: within a layer |s_i| <= phi, |e_i| falls to "
    "phi / Lambda_i.",
    "Slotine and Li (1991), chapter 7",
    (EXACT_ESTIMATES,),
    _pulled_by_the_surface,
)


class SlidingVariables(NamedTuple):
    """The error and its rate, the sliding variable s, and the reference velocity and acceleration, each (n, 1)."""

    e: ca.SX
    ed: ca.SX
    s: ca.SX
    qd_r: ca.SX
    qdd_r: ca.SX


class AbstractSlidingMode(AbstractArmController):
    """The base class of laws with the sliding variable s = ed + Lambda e and a boundary layer of width phi.

    Parameters
    ----------
    Lambda
        Rate of decay of the error of each joint on the surface s = 0.
    phi
        Width of the boundary layer, in the unit of s.
    saturation
        The switching function in place of sat(s / phi).

    Examples
    --------
    >>> issubclass(wb.SlidingMode, wb.arms.laws.AbstractSlidingMode)
    True
    """

    claims: ClassVar[tuple[Claim, ...]] = (SURFACE_PULLS_THE_ERROR,)

    Lambda: Vector
    phi: Scalar
    saturation: str

    @check_arguments
    def signals(self, z: Parts, est: Reads, ref: Follows) -> Parts:
        """The sliding variable s, (n, 1)."""
        return {"s": self._sliding_variables(est, ref).s}

    def _sliding_variables(self, est: Reads, ref: Follows) -> SlidingVariables:
        """The surface qd = qd_r = qd_ref - Lambda e; qd_r' = qdd_r where the estimates are exact."""
        e, ed = est.q - ref.q, est.qd - ref.qd
        return SlidingVariables(e, ed, ed + self.Lambda * e, ref.qd - self.Lambda * e, ref.qdd - self.Lambda * ed)

    def _switching_torque(self, K: Vector, s: ca.SX, M: ca.SX) -> ca.SX:
        """K o sat(s / phi), (n, 1) in N m; "implicit" the torque of `relay` for M s' = -K o sign(s)."""
        if self.saturation == "implicit":
            return relay(s, M, K, self.sampling_period())
        torque: ca.SX = K * saturation(s, self.phi, self.saturation)
        return torque

    def sampling_period(self) -> float:
        """The sampling period in s; a ValueError in continuous time."""
        if self.period is None:
            raise ValueError(
                f"`{type(self).__name__}(saturation='implicit')` solves its relay over a sampling period, which "
                "continuous time has none of: take `ClosedLoop.digital(period)`, or another saturation."
            )
        return self.period

    def without_layer(self) -> dict[str, Self]:
        """A copy of the law without its boundary layer, by the name of that part; empty if it has none."""
        return {"boundary layer": replace(self, saturation="sign")} if self.saturation in ("clip", "tanh") else {}


def saturation(s: ca.SX, phi: Scalar, kind: str) -> ca.SX:
    """sat(s / phi), elementwise: sign(s), its jump spread over a layer phi; `kind` as in `SATURATIONS`."""
    if kind == "sign":
        return ca.sign(s)
    x: ca.SX = s / phi
    return ca.tanh(x) if kind == "tanh" else ca.fmax(ca.fmin(x, 1), -1)


def matrices(model: AbstractArm, est: Reads) -> tuple[ca.SX, ca.SX, ca.SX]:
    """M (n, n), C (n, n) and G (n, 1) as the designer's model gives them at the estimated state."""
    return model.mass_matrix(est.q), model.coriolis_matrix(est.q, est.qd), model.gravity_vector(est.q)


def relay(s: ca.SX, M: ca.SX, K: ca.SX, period: float) -> ca.SX:
    """The torque v of a set-valued relay that acts on s for one period h, M s' = -v with v_i in K_i Sgn(s_i):

        s+ = s - h M^-1 v,        v_i in K_i Sgn(s_i+),        Sgn(0) = [-1, 1]

    There is one such v, the point of the box |v_i| <= K_i that is nearest to M s / h in the metric of M^-1.

    For one joint and for two v has a closed form: the torque at which s_i+ = 0, within what the other joint can make of
    it, within the box. For more joints that is a start for projected Gauss-Seidel; then the saturated joints are
    guessed, by the rule of Newton's method. v is exact if `GUESSES` were enough, and in the box in any case.

    References
    ----------
    Acary and Brogliato (2010), Implicit Euler numerical scheme ... of sliding mode systems, SCL 59(5).
    Hintermueller et al. (2003), The primal-dual active set strategy as a semismooth Newton method, SIOPT 13(3).
    """
    n, K = s.numel(), ca.SX(K)
    A = period * solve_definite(M, ca.SX.eye(n))
    a = ca.diag(A)
    reach = ca.fabs(A) @ K - a * K  # how far all other joints together can move s_i
    v = clip(ca.fmin(ca.fmax(M @ s / period, (s - reach) / a), (s + reach) / a), K)
    if n > 2:
        for _ in range(SWEEPS):
            v = _sweep(A, s, K, v)
        for _ in range(GUESSES):
            v = _guess(A, s, K, v)
        v = _sweep(A, s, K, v)  # which leaves a solution where it is, and anything else in the box
    return v


def _sweep(A: ca.SX, s: ca.SX, K: ca.SX, v: ca.SX) -> ca.SX:
    """One sweep of projected Gauss-Seidel: joint by joint the exact v_i where all others are as they are."""
    v = ca.SX(v)
    for i in range(v.numel()):
        v[i] = clip(v[i] + (s[i] - A[i, :] @ v) / A[i, i], K[i])
    return v


def _guess(A: ca.SX, s: ca.SX, K: ca.SX, v: ca.SX) -> ca.SX:
    """v with the joints saturated that v and s+ together suggest, and s_i+ = 0 at all others."""
    wanted = v + (s - A @ v) / ca.diag(A)
    free = ca.fabs(wanted) <= K
    fixed = ca.if_else(free, 0, ca.sign(wanted) * K)
    D, rest = ca.diag(free), ca.diag(1 - free)
    return solve_definite(D @ A @ D + rest, free * (s - A @ fixed) + fixed)


def clip(x: ca.SX, limit: ca.SX) -> ca.SX:
    """x within -limit and limit, elementwise."""
    return ca.fmin(ca.fmax(x, -limit), limit)
