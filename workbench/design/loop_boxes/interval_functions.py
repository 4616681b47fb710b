"""Matrices of expressions enclosed over many boxes at once, by their middles and radii, and products with them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.core.notation.program import Walk, walk
from workbench.core.validation.refusals import Array
from workbench.proofs.enclosures import UNIT
from workbench.proofs.interval import Interval, evaluate

TINY = 1e-290  # more than what underflow may lose of a sum of products


class MatrixBall(NamedTuple):
    """Middles and radii of the entries of matrices; an infinite radius where there is no bound."""

    middle: Array
    radius: Array

    @property
    def size(self) -> Array:
        """The largest absolute value of each entry."""
        return np.asarray((np.abs(self.middle) + self.radius) * (1 + 4 * UNIT))


@dataclass(frozen=True, eq=False)
class IntervalFunction:
    """A matrix (n, m) of expressions whose symbols, known by name, stay within boxes."""

    shape: tuple[int, int]
    steps: Walk | None
    constant: Array

    @staticmethod
    def of(matrix: ca.SX) -> IntervalFunction:
        """The function of a matrix; without symbols its constants, which are doubles as they stand."""
        dense = ca.densify(ca.SX(matrix))
        shape = (int(dense.shape[0]), int(dense.shape[1]))
        if not dense.numel() or not ca.symvar(dense):
            return IntervalFunction(shape, None, np.array(ca.DM(dense)).reshape(shape))
        return IntervalFunction(shape, walk(dense, cse=True), np.zeros(shape))

    @property
    def cost(self) -> int:
        """The number of operations on intervals."""
        return 1 if self.steps is None else len(self.steps.nodes)

    def __call__(self, boxes: Mapping[str, Interval], count: int) -> MatrixBall:
        """Enclosures (b, n, m) over so many boxes."""
        if self.steps is None:
            middle = np.tile(self.constant, (count, 1, 1))
            return MatrixBall(middle, np.zeros_like(middle))
        held = {name: boxes[name] for name in self.steps.names}
        parts = [_wide(part, count) for part in evaluate(self.steps, held)]
        n, m = self.shape
        middle, radius = (
            np.stack([getattr(part, name) for part in parts], axis=1).reshape(count, m, n).swapaxes(1, 2)
            for name in ("middle", "radius")
        )
        lost = np.logical_not(np.isfinite(middle) & np.isfinite(radius))
        return MatrixBall(np.where(lost, 0.0, middle), np.where(lost, np.inf, radius))


def _wide(part: Interval, count: int) -> Interval:
    """The interval of an entry that is a constant, once for each box."""
    return part if len(part.low) == count else Interval(*(np.broadcast_to(e, count) for e in (part.low, part.high)))


def add_balls(a: MatrixBall, b: MatrixBall) -> MatrixBall:
    """The sum of balls, with its rounding."""
    middle = a.middle + b.middle
    return MatrixBall(middle, _more(a.radius + b.radius + 2 * UNIT * np.abs(middle), 4))


def product(left: Array, right: MatrixBall) -> MatrixBall:
    """The product of doubles (b, k, n) with balls (b, n, m)."""
    n = left.shape[-1]
    with np.errstate(invalid="ignore"):
        middle, size = left @ right.middle, np.abs(left)
        radius = size @ right.radius + _share(n) * (size @ np.abs(right.middle))
    return MatrixBall(middle, _finite_or_infinite(_more(radius, n)))


def product_right(left: MatrixBall, right: Array) -> MatrixBall:
    """The product of balls (b, k, n) with doubles (b, n, m)."""
    turned = product(right.swapaxes(1, 2), MatrixBall(left.middle.swapaxes(1, 2), left.radius.swapaxes(1, 2)))
    return MatrixBall(turned.middle.swapaxes(1, 2), turned.radius.swapaxes(1, 2))


def reach(bounds: Array, radii: Array) -> Array:
    """The sums (b, k) of bounds (b, k, n) times radii (b, n), rounded up."""
    with np.errstate(invalid="ignore"):
        total = (bounds @ radii[:, :, np.newaxis])[:, :, 0]
    return _finite_or_infinite(_more(total, bounds.shape[-1]))


def _share(n: int) -> float:
    return 4 * (n + 2) * UNIT


def _more(radius: Array, n: int) -> Array:
    return np.asarray(radius * (1 + _share(n)) + TINY)


def _finite_or_infinite(radius: Array) -> Array:
    """The radii, infinite where an infinite one met a zero."""
    return np.where(np.isnan(radius), np.inf, radius)
