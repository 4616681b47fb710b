r"""A matrix inequality that is affine in the Jacobian J of the mismatch, proved for all states of a region:

    Z(J) = Z0 + F J G + (F J G)'  >  0.

J lies in the hull of finitely many combinations of its coefficients, so these are enough; over positions they
are enclosed box by box, and a box that fails is halved. Between the corners of a box the least eigenvalue of
what is linear is not below that at one of them, as it is concave; what is not linear is paid for by row sums.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from workbench.core.layout import Array
from workbench.design.certificates import Refused
from workbench.design.observer_gains.mismatch import Mismatch
from workbench.design.observer_gains.region import Region
from workbench.proofs.branch_and_bound import definite
from workbench.proofs.enclosures import UNIT
from workbench.validation.views import show

Mask = np.ndarray[Any, np.dtype[np.bool_]]
# Boxes of positions that a proof may take, and doubles that are held at a time.
BUDGET, HELD = 40_000, 3_000_000


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
        """What an unknown part of J, |.| <= R, can take from the diagonal of Z, with all rounding, (..., m)."""
        grown = R + 64 * UNIT * J
        part = np.abs(self.F) @ grown @ np.abs(self.G)
        rows = (part + part.swapaxes(-1, -2)).sum(axis=-1) + 64 * UNIT * self.size.sum(axis=-1)
        return np.asarray(rows * (1 + 64 * UNIT))


def prove(inequality: Inequality, mismatch: Mismatch, region: Region, what: str, budget: int = BUDGET) -> int:
    """Prove Z(J) > 0 over a region, and return how many boxes of positions that took.

    Raises
    ------
    Refused
        If it does not hold for the hull at the middle of a box, or not within the budget; `what` names it.
    """
    Y, (low, high) = mismatch.vertices(region), region.box
    c, r = ((low + high) / 2)[None], ((high - low) / 2)[None] * (1 + 8 * UNIT) + 8 * UNIT * np.abs(low + high)
    todo, count = _Todo(c, r, np.ones((1, len(Y)), dtype=bool)), 0
    while len(todo.c):
        count += len(todo.c)
        if count > budget:
            raise Refused(f"{what} was not proved within {budget} boxes of positions; allow it more room.")
        size = max(1, HELD // int(todo.open.sum(axis=1).max() * len(inequality.Z0) ** 2))
        rest = [_halves(inequality, mismatch, Y, todo.part(i, i + size), what) for i in range(0, len(todo.c), size)]
        todo = _Todo(*(np.concatenate([getattr(part, name) for part in rest]) for name in _Todo._fields))
    return count


class _Todo(NamedTuple):
    """Boxes with middles c and half widths r, (B, n) each, and for which vertices each is still open, (B, V)."""

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
    return _halved(c[failed], r[failed], blame[failed], still[failed])


def _refuse_failure(inequality: Inequality, J: Array, c: Array, what: str) -> None:
    """Refuse what fails at the middle of a box, where no halving helps."""
    least = np.linalg.eigvalsh(inequality.at(J))[:, 0]
    if len(least) and not least.min() > 0:
        where = np.round(c[int(np.argmin(least))], 4).tolist()
        raise Refused(
            f"{what} is not proved: near the positions {where} rad the hull of the Jacobians has a vertex with the "
            f"margin {least.min():.3g}, which must be positive."
        )


def _halved(c: Array, r: Array, blame: Array, still: Mask) -> _Todo:
    """Across the joint that J changes most with; the halves overlap by their rounding."""
    rows, axis = np.arange(len(c)), blame.argmax(axis=1) if len(c) else np.zeros(0, int)
    shift, half = np.zeros_like(c), r.copy()
    shift[rows, axis] = r[rows, axis] / 2
    half[rows, axis] = shift[rows, axis] + 8 * UNIT * (np.abs(c[rows, axis]) + r[rows, axis])
    return _Todo(np.concatenate([c - shift, c + shift]), np.tile(half, (2, 1)), np.tile(still, (2, 1)))
