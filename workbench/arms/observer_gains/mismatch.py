"""The Jacobian of the acceleration, which drives the error of an observer, as a polynomial in speeds and torques.

With f(q, qd, tau) = M^-1 (tau - C qd - G) the mismatch (14) is, by the mean value theorem,

    Delta = f(x, tau) - f(x_hat, tau) = J x~,    J in the hull of [df/dq, df/dqd] between estimate and state.

C is linear in qd, so J is a polynomial whose coefficients depend on positions alone:

    J(q, qd, tau) = sum_k y_k J_k(q),    y = (1, tau_i, qd_i, qd_i qd_j).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.arms.dynamics import Dynamics, solve_definite
from workbench.arms.observer_gains.gains import Gains, Region
from workbench.arms.properties import nominal
from workbench.core.notation.normal_form import NotInClass, normal_forms
from workbench.core.notation.program import Walk, walk
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, require
from workbench.core.validation.signatures import check_arguments
from workbench.proofs.interval import Interval, evaluate, jumps

MOST = 4  # joints
# Bernstein's coefficients of s and s^2, of degree two, on [-1, 0] and [0, 1] together.
NODES, SQUARES = (-1.0, -0.5, 0.0, 0.5, 1.0), (1.0, 0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
@show
class Mismatch:
    """J = [df/dq, df/dqd] of one arm at nominal parameters, and its coefficients J_k over boxes of positions.

    `function` is (q, qd, tau) -> J (n, 2n), entry by entry, column by column. `coefficients` are the J_k and `slopes`
    their derivatives by q, as operations over q and the parameters, which have the values `numbers`. The equations are
    the same after a whole turn of any joint if they are `periodic`, which is proved by their normal form.
    """

    joints: int
    function: ca.Function
    coefficients: Walk
    slopes: Walk
    names: tuple[str, ...]
    numbers: Mapping[str, float]
    periodic: bool

    @staticmethod
    @check_arguments
    def of(dynamics: Dynamics) -> Mismatch:
        """The mismatch of an arm; a `ValueError` if its acceleration may jump or bend, or is not quadratic in the
        velocities.
        """
        require("Mismatch.of(dynamics)", dynamics, Dynamics)
        q, qd, n = dynamics.q, dynamics.qd, dynamics.dof
        tau = ca.SX.sym("tau", n)
        bias = ca.substitute(dynamics.tau, dynamics.qdd, ca.SX.zeros(n))
        f = solve_definite(dynamics.M, tau - bias)
        J = ca.vec(ca.densify(ca.jacobian(f, ca.vertcat(q, qd))))
        # where J jumps, as that of |qd| qd or |q|, neither its polynomial nor its slopes bound it
        if found := jumps(walk(ca.vertcat(f, J)), [symbol.name() for symbol in ca.symvar(ca.vertcat(q, qd))]):
            raise ValueError(
                f"`Mismatch.of(dynamics)` needs a smooth acceleration; that of '{dynamics.name}' or its Jacobian holds "
                f"{found[0]}."
            )
        parts = ca.cse(_coefficients(J, qd, tau))
        if ca.depends_on(parts, ca.vertcat(qd, tau)):
            raise ValueError(
                "`Mismatch.of(dynamics)` needs an acceleration that is quadratic in the velocities, as that of an arm "
                f"without friction is; that of '{dynamics.name}' is not."
            )
        values = nominal(dynamics)
        numbers = ca.substitute(J, dynamics.symbols, ca.SX(dynamics.p.default))
        return Mismatch(
            n,
            ca.Function("J", [q, qd, tau], [numbers], {"cse": True}),
            walk(parts, cse=True),
            walk(ca.vec(ca.densify(ca.jacobian(parts, q))), cse=True),
            tuple(q[i].name() for i in range(n)),
            values,
            _periodic(dynamics),
        )

    @check_arguments
    def at(self, q: Array, qd: Array, tau: Array) -> Array:
        """J (N, n, 2n) at states and torques, (N, n) each."""
        self._refuse_misfit("at", q, qd, tau)
        found = np.array(self.function(q.T, qd.T, tau.T)).T
        return np.asarray(found.reshape(len(q), 2 * self.joints, self.joints).transpose(0, 2, 1))

    @check_arguments
    def monomials(self, qd: Array, squares: Array, tau: Array) -> Array:
        """y (N, K) for speeds, their squares and torques, (N, n) each."""
        self._refuse_misfit("monomials", qd, squares, tau)
        pairs = [
            squares[:, i] if i == j else qd[:, i] * qd[:, j]
            for i, j in itertools.combinations_with_replacement(range(self.joints), 2)
        ]
        return np.column_stack([np.ones(len(qd)), tau, qd, *pairs])

    @check_arguments
    def vertices(self, region: Region) -> Array:
        """Points y (V, K) whose hull holds the y of all speeds and torques of a region of up to four joints.

        A polynomial lies in the hull of its coefficients in Bernstein's basis; here of degree two in each speed, on
        both sides of zero. In the torques J is affine, so their corners serve (Farouki 2012, Computer Aided Geometric
        Design 29).
        """
        n = self.joints
        if region.joints != n:
            raise ValueError(f"`vertices(region)` must be of {n} joints, as the mismatch is; got {region.joints}.")
        if n > MOST:
            raise ValueError(
                f"`vertices(region)` has 10^n vertices for n joints, so it is for {MOST} joints or fewer; got {n}."
            )
        places = np.array(list(itertools.product(range(len(NODES)), repeat=n)))
        corners = np.array(list(itertools.product((-1.0, 1.0), repeat=n))) * region.torque
        where, which = (part.ravel() for part in np.meshgrid(range(len(places)), range(len(corners)), indexing="ij"))
        qd = np.array(NODES)[places] * region.speed
        squares = np.array(SQUARES)[places] * region.speed**2
        return np.unique(self.monomials(qd[where], squares[where], corners[which]), axis=0)

    def _refuse_misfit(self, call: str, *parts: Array) -> None:
        if any(part.shape != (len(np.atleast_1d(parts[0])), self.joints) for part in parts):
            shapes = ", ".join(str(part.shape) for part in parts)
            raise ValueError(f"`{call}(...)` must be N rows of {self.joints} numbers each; got shapes {shapes}.")

    @check_arguments
    def expand(self, c: Array, r: Array) -> tuple[Array, Array, Array]:
        """A (B, K, n, 2n), L (B, n, K, n, 2n), R (B, K, n, 2n) with |J_k(q) - A_k - sum_l L_lk (q_l - c_l)| <= R_k.

        That holds for |q - c| <= r, (B, n) each, by intervals of the J_k at c and of their derivatives over the box.
        """
        self._refuse_misfit("expand", c, r)
        n = self.joints
        K = len(self.coefficients.entries) // (2 * n**2)
        still = {name: Interval(*[np.full(len(c), number)] * 2) for name, number in self.numbers.items()}
        thin = {name: Interval(c[:, i], c[:, i]) for i, name in enumerate(self.names)}
        ends = np.nextafter(c - r, -np.inf), np.nextafter(c + r, np.inf)
        wide = {name: Interval(ends[0][:, i], ends[1][:, i]) for i, name in enumerate(self.names)}
        with np.errstate(all="ignore"):
            A, R = _stack_intervals(evaluate(self.coefficients, thin | still), (K, 2 * n, n))
            L, spread = _stack_intervals(evaluate(self.slopes, wide | still), (n, K, 2 * n, n))
            R = R + (r[:, :, None, None, None] * spread).sum(axis=1)
        return A.swapaxes(-1, -2), L.swapaxes(-1, -2), R.swapaxes(-1, -2)


def _coefficients(J: ca.SX, qd: ca.SX, tau: ca.SX) -> ca.SX:
    """The J_k, each a column, one below the other: by derivatives where speeds and torques are zero."""
    zero = [ca.vertcat(qd, tau)], [ca.SX.zeros(qd.numel() + tau.numel())]
    by_speed = ca.jacobian(J, qd)
    columns = [J, *ca.horzsplit(ca.jacobian(J, tau)), *ca.horzsplit(by_speed)]
    found = [ca.substitute([column], *zero)[0] for column in columns]
    for i in range(qd.numel()):
        curve = ca.jacobian(by_speed[:, i], qd)
        found += [curve[:, j] / (2 if i == j else 1) for j in range(i, qd.numel())]
    return ca.densify(ca.vertcat(*found))


def _stack_intervals(parts: list[Interval], shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Middles and radii of intervals of entries, (B, *shape); where there is no bound the radius is infinite."""
    middle = np.stack([part.middle for part in parts], axis=1)
    radius = np.stack([part.radius for part in parts], axis=1)
    lost = np.logical_not(np.isfinite(middle) & np.isfinite(radius))
    middle, radius = np.where(lost, 0.0, middle), np.where(lost, np.inf, radius)
    return middle.reshape(-1, *shape), radius.reshape(-1, *shape)


def _periodic(dynamics: Dynamics) -> bool:
    """True if M, C and G hold positions only as whole multiples in sines and cosines."""
    joints = {dynamics.q[i].name() for i in range(dynamics.dof)}
    try:
        rows = normal_forms(ca.vertcat(ca.vec(dynamics.M), dynamics.C @ dynamics.qd, dynamics.G), {})
    except NotInClass:
        return False
    for form in (form for row in rows for form in row):
        for monomial, (_, angle) in form.terms:
            if any(name in joints for name, _ in monomial):
                return False
            for factor, slope in dict(angle).items():
                held = [name for name, _ in factor if name in joints]
                if held and (len(factor) > 1 or factor[0][1] != 1 or slope.denominator != 1):
                    return False
    return True


def refuse_unfit(call: str, mismatch: Mismatch, gains: Gains | None, region: Region) -> None:
    """Refuse gains and regions of other arms, and any position where the equations do not repeat after a turn."""
    sizes = {mismatch.joints, region.joints} | ({gains.joints} if gains is not None else set())
    if len(sizes) > 1:
        raise ValueError(
            f"`{call}(...)` needs gains and a region for the {mismatch.joints} joints of the arm; got "
            f"{region.joints} in the region{f' and {gains.joints} in the gains' if gains is not None else ''}."
        )
    if region.low is None and not mismatch.periodic:
        raise ValueError(
            f"`{call}(region=...)` must bound the positions by `low` and `high`: that these equations repeat after a "
            "turn is not proved."
        )
