"""A matrix inequality that is affine in the Jacobian J of the mismatch, proved for all states of a region:

    Z(J) = Z0 + F J G + (F J G)'  >  0.

J lies in the hull of finitely many combinations of its coefficients, so these are enough; over positions they
are enclosed box by box, and a box that fails is halved. Between the corners of a box the least eigenvalue of
what is linear is not below that at one of them, as it is concave; what is not linear is paid for by row sums.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.arms.observer_gains.gains import Region
from workbench.arms.observer_gains.mismatch import Mismatch, refuse_unfit
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError
from workbench.proofs.branch_and_bound import definite, sequence
from workbench.proofs.enclosures import UNIT
from workbench.proofs.exact_arithmetic import Matrix, characteristic_polynomial

Mask = NDArray[np.bool_]
# Boxes of positions that a proof may take, and doubles that are held at a time.
BUDGET, MOST_DOUBLES = 40_000, 3_000_000
# Shares above the largest norm that is known, of which the first that can be proved is taken; samples of states.
SHARES, SAMPLES = (0.01, 0.03, 0.1, 0.3), 20_000


def exactly_definite(S: Array | NDArray[np.object_]) -> bool:
    """True if a symmetric matrix is positive definite: all its leading minors are positive, in rational arithmetic."""
    rows: Matrix = exact(S).tolist()
    leading = ([row[:k] for row in rows[:k]] for k in range(1, len(rows) + 1))
    return all(characteristic_polynomial(block)[-1] * (-1) ** len(block) > 0 for block in leading)


def bears_mismatch(P: Array, A: Array, B: Array, rho: float) -> bool:
    """True if P > 0 and A' P + P A + rho^2 I + P B B' P < 0, exactly; then z' P z falls for |w| <= rho |z|."""
    p, a, b = (exact(part) for part in (P, A, B))
    pa, pb, square = p @ a, p @ b, Fraction(rho) ** 2 * np.eye(len(p), dtype=int)
    return exactly_definite(p) and exactly_definite(-(pa + pa.T + square + pb @ pb.T))


def exact(S: Array | NDArray[np.object_]) -> NDArray[np.object_]:
    """The matrix as fractions, whose sums and products do not round."""
    fractions: NDArray[np.object_] = np.vectorize(Fraction, otypes=[object])(S)
    return fractions


@dataclass(frozen=True, eq=False)
@show
class Inequality:
    """Z0 (m, m) symmetric, F (m, n) and G (2n, m) of Z(J) = Z0 + F J G + (F J G)'.

    `size` (m, m) bounds the numbers that were added up in Z0, so that their rounding can be paid for.
    """

    Z0: Array
    F: Array
    G: Array
    size: Array

    def at(self, J: Array) -> Array:
        """Z at Jacobians J (..., n, 2n)."""
        part = self.F @ J @ self.G
        return np.asarray(self.Z0 + part + part.swapaxes(-1, -2))

    def doubt(self, J: Array, R: Array) -> Array:
        """The most by which an unknown part of J, |.| <= R, lowers the diagonal of Z, with all rounding, (..., m)."""
        grown = R + 64 * UNIT * J
        part = np.abs(self.F) @ grown @ np.abs(self.G)
        rows = (part + part.swapaxes(-1, -2)).sum(axis=-1) + 64 * UNIT * self.size.sum(axis=-1)
        return np.asarray(rows * (1 + 64 * UNIT))


def prove(inequality: Inequality, mismatch: Mismatch, region: Region, what: str, budget: int = BUDGET) -> int:
    """Prove Z(J) > 0 over a region, and return how many boxes of positions that took.

    `DesignError` if it fails for the hull at the middle of a box, or not within the budget; `what` names it.
    """
    Y, (low, high) = mismatch.vertices(region), region.box
    c, r = ((low + high) / 2)[None], ((high - low) / 2)[None] * (1 + 8 * UNIT) + 8 * UNIT * np.abs(low + high)
    todo, count = _Todo(c, r, np.ones((1, len(Y)), dtype=bool)), 0
    while len(todo.c):
        count += len(todo.c)
        if count > budget:
            raise DesignError(f"{what} was not proved within {budget} boxes of positions; allow it more room.")
        size = max(1, MOST_DOUBLES // int(todo.open.sum(axis=1).max() * len(inequality.Z0) ** 2))
        rest = [_halves(inequality, mismatch, Y, todo.part(i, i + size), what) for i in range(0, len(todo.c), size)]
        todo = _Todo(*(np.concatenate([getattr(part, name) for part in rest]) for name in _Todo._fields))
    return count


class _Todo(NamedTuple):
    """Boxes with middles c and half widths r, (B, n) each, and the vertices for which each is still open, (B, V)."""

    c: Array
    r: Array
    open: Mask

    def part(self, first: int, last: int) -> _Todo:
        return _Todo(self.c[first:last], self.r[first:last], self.open[first:last])


def _halves(inequality: Inequality, mismatch: Mismatch, Y: Array, todo: _Todo, what: str) -> _Todo:
    """Both halves of each box that fails, for the vertices at which it does."""
    c, r = todo.c, todo.r
    A, L, R = mismatch.expand(c, r)
    b, v = np.nonzero(todo.open)
    y, size = Y[v], np.abs(Y[v])
    with np.errstate(all="ignore"):
        reach = r[:, :, None, None, None] * L
        J = np.einsum("ak,akij->aij", y, A[b])
        steps = np.einsum("ak,alkij->laij", y, reach[b])
        unknown, most = (
            np.einsum("ak,akij->aij", size, part[b]) for part in (R, np.abs(A) + np.abs(reach).sum(axis=1))
        )
        doubt = inequality.doubt(most, unknown)
        holds: Mask = np.array(np.isfinite(doubt).all(axis=1), dtype=bool)
        for signs in itertools.product((-1.0, 1.0), repeat=c.shape[1]):
            left = np.flatnonzero(holds)
            corner = J[left] + np.tensordot(np.array(signs), steps[:, left], 1)
            Z = inequality.at(corner) - doubt[left, :, None] * np.eye(doubt.shape[1])
            holds[left] = definite(Z)
        _refuse_failure(inequality, J[~holds], c[b[~holds]], what)
        smooth: Mask = np.array(np.isfinite(R).all(axis=(1, 2, 3)), dtype=bool)
        blame = np.where(smooth[:, None], np.abs(reach).sum(axis=(2, 3, 4)), r)
    still: Mask = np.zeros(todo.open.shape, dtype=bool)
    still[b, v] = np.logical_not(holds)
    failed = np.flatnonzero(still.any(axis=1))
    return _halve_boxes(c[failed], r[failed], blame[failed], still[failed])


def _refuse_failure(inequality: Inequality, J: Array, c: Array, what: str) -> None:
    least = np.linalg.eigvalsh(inequality.at(J))[:, 0]
    if len(least) and not least.min() > 0:
        where = np.round(c[int(np.argmin(least))], 4).tolist()
        raise DesignError(
            f"{what} is not proved: near the positions {where} rad the hull of the Jacobians has a vertex with the "
            f"margin {least.min():.3g}, which must be positive."
        )


def _halve_boxes(c: Array, r: Array, blame: Array, still: Mask) -> _Todo:
    """The halves of boxes, across the joint that changes J most; they overlap by their rounding."""
    rows, axis = np.arange(len(c)), blame.argmax(axis=1) if len(c) else np.zeros(0, int)
    shift, half = np.zeros_like(c), r.copy()
    shift[rows, axis] = r[rows, axis] / 2
    half[rows, axis] = shift[rows, axis] + 8 * UNIT * (np.abs(c[rows, axis]) + r[rows, axis])
    return _Todo(np.concatenate([c - shift, c + shift]), np.tile(half, (2, 1)), np.tile(still, (2, 1)))


@dataclass(frozen=True)
@show
class LipschitzBound:
    """`lower` is reached at a state of the region; no state exceeds `upper`."""

    lower: float
    upper: float


@dataclass(frozen=True)
@show
class Lipschitz:
    """rho_q in 1/s^2 and rho_v in 1/s."""

    position: LipschitzBound
    velocity: LipschitzBound


@check_arguments
def lipschitz(mismatch: Mismatch, region: Region) -> Lipschitz:
    """The Lipschitz constants of the mismatch (14) over a region, proved by intervals:

        |Delta| <= rho_q |q~| + rho_v |qd~|,    rho_q = max |df/dq|, rho_v = max |df/dqd|,     in 2-norms.

    Raises
    ------
    ValueError
        If the region is that of another arm, or any position is allowed to equations that do not repeat.
    DesignError
        If no bound within 30 % of what is seen was proved.

    Examples
    --------
    >>> from workbench.arms.dynamics import Dynamics
    >>> from workbench.arms.observer_gains import Mismatch, Region, lipschitz
    >>> arm = Dynamics.of(wb.robot("planar-1r"))
    >>> lipschitz(Mismatch.of(arm), Region([3.0], [7.0]))
    Lipschitz(position=LipschitzBound(lower=14.715, upper=14.8621), velocity=LipschitzBound(lower=0, upper=1e-09))
    """
    refuse_unfit("lipschitz", mismatch, None, region)
    n = mismatch.joints
    J = mismatch.at(*extremes(region))
    return Lipschitz(*(_lipschitz_bound(mismatch, region, J, slice(i, i + n)) for i in (0, n)))


def extremes(region: Region) -> tuple[Array, Array, Array]:
    """Positions spread over a region, and with them speeds and torques that are each zero or extreme, (N, n) each."""
    n, (low, high) = region.joints, region.box
    u = sequence(SAMPLES, 3 * n)
    speeds, torques = np.floor(3 * u[:, n : 2 * n]) - 1, 2 * np.floor(2 * u[:, 2 * n :]) - 1
    return low + u[:, :n] * (high - low), speeds * region.speed, torques * region.torque


def _lipschitz_bound(mismatch: Mismatch, region: Region, J: Array, columns: slice) -> LipschitzBound:
    """The norm of a half of J: t bounds it if [[t I, J], [J', t I]] > 0."""
    n, seen = mismatch.joints, float(np.linalg.norm(J[..., columns], 2, axis=(1, 2)).max())
    F, G = np.vstack([np.eye(n), np.zeros((n, n))]), np.zeros((2 * n, 2 * n))
    G[columns, n:] = np.eye(n)
    for share in SHARES:
        t = max((1 + share) * seen, 1e-9)
        try:
            prove(Inequality(t * np.eye(2 * n), F, G, t * np.eye(2 * n)), mismatch, region, "A Lipschitz constant")
        except DesignError:
            continue
        return LipschitzBound(seen, t)
    raise DesignError(
        f"No Lipschitz constant up to {1 + SHARES[-1]:g} times {seen:.4g}, which is seen, was proved: take a smaller "
        "region, or one without poles."
    )
