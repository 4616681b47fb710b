r"""The interval Newton operator about a point c, which proves that a zero of f is in a box |x - c| <= r around it:

    N(x) = x - Y f(x),     Y near the inverse of df/dx at c,
    |N(x) - N(z)| <= q |x - z|     in the box,     with q = max |I - Y df/dx| there.

If q < 1 and |N(c) - c| <= (1 - q) r, then N carries the box into itself and has exactly one fixed point there (Banach).
Y is regular then, as I - Y df/dx is smaller than I: so the fixed point is a zero of f, |N(c) - c| / (1 - q) from c at
most. If N is only known to carry the box into itself, there is at least one (Brouwer), which is a zero if Y is regular.
All norms are the largest absolute value.

References
----------
Moore, Kearfott and Cloud (2009), Introduction to Interval Analysis, chapter 8.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import casadi as ca
import numpy as np

from workbench.core.notation.program import Walk, walk
from workbench.core.validation.refusals import Array
from workbench.proofs.bounds import enclose
from workbench.proofs.exact_arithmetic import characteristic_polynomial
from workbench.proofs.interval import Interval, NoBound, evaluate, jumps

ROUNDING_FACTOR = 1 + 1e-9  # stands for the rounding of a few sums and quotients of positive numbers, generously
LOOSE, BOXES = 0.1, 256  # how loose an enclosure of N may be, as a share of the box relative to c; and its boxes


@dataclass(frozen=True)
class Unknowns:
    """The names of the unknowns x, and the numbers of all other symbols of f, which are not rounded."""

    names: tuple[str, ...]
    numbers: Mapping[str, float]

    def boxes(self, low: Array, high: Array) -> dict[str, Interval]:
        """Boxes (N, n) of the unknowns, and intervals of no width of the other symbols, by name."""
        ends = {name: Interval(low[:, k], high[:, k]) for k, name in enumerate(self.names)}
        points = {name: np.full(len(low), number) for name, number in self.numbers.items()}
        return ends | {name: Interval(point, point) for name, point in points.items()}


@dataclass(frozen=True, eq=False)
class NewtonOperator:
    """N about a point c (n,), where the numbers of the unknowns hold the entries of Y too.

    Attributes
    ----------
    step
        A bound of |N(c) - c|.
    slope
        The entries of I - Y df/dx, column by column.
    """

    x: ca.SX
    image: ca.SX
    point: Array
    unknowns: Unknowns
    Y: Array
    step: float
    slope: Walk

    @staticmethod
    def of(f: ca.SX, x: ca.SX, point: Array, numbers: Mapping[str, float]) -> NewtonOperator:
        """The operator for the zeros of f (n, 1) in x (n, 1), with `numbers` for its other symbols.

        Raises
        ------
        NoBound
            If f may jump, an operation has no interval, or df/dx at the point is not a regular matrix.
        """
        names = tuple(x[k].name() for k in range(x.numel()))
        if broken := jumps(walk(f), names):
            raise NoBound(f"A zero is proved only of a function without jumps; this one holds {broken[0]}.")
        slope = ca.densify(ca.jacobian(f, x))
        Y = _inverse(slope, x, point, numbers)
        symbols, entries = _symbols_of(Y)
        unknowns = Unknowns(names, {**numbers, **entries})
        change = symbols @ f
        step = float(_sizes(walk(change), unknowns, point, point).max())
        return NewtonOperator(x, x - change, point, unknowns, Y, step, walk(ca.SX.eye(len(point)) - symbols @ slope))

    def contraction(self, reach: float) -> float:
        """The bound q of the slope of N for |x - c| <= reach."""
        sizes = _sizes(self.slope, self.unknowns, self.point - reach, self.point + reach)
        return float(ROUNDING_FACTOR * sizes.sum(axis=1).max())

    def radius(self, reach: float) -> float | None:
        """A distance from c within which f has a zero, the only one within `reach`; None if not proved."""
        q = self.contraction(reach)
        if q < 1 and (radius := ROUNDING_FACTOR * self.step / (1 - q)) < reach:
            return radius
        return None

    def has_zero(self, reach: float) -> bool:
        """True if f is proved to have a zero within `reach`: by contraction, or else by bounds of N all over the box.

        These are tighter and take longer.
        """
        return self.radius(reach) is not None or (self._maps_inside(reach) and self._is_regular)

    def _maps_inside(self, reach: float) -> bool:
        """True if N is proved to carry the box |x - c| <= reach into itself."""
        low, high = self.point - reach, self.point + reach
        tolerance = LOOSE * reach / (1 + float(np.abs(self.point).max()))
        for entry, left, right in zip(ca.vertsplit(self.image), low, high, strict=True):
            found = enclose(entry, self.x, low, high, tolerance=tolerance, boxes=BOXES, numbers=self.unknowns.numbers)
            if found.low is None or found.high is None or not left < found.low <= found.high < right:
                return False
        return True

    @property
    def _is_regular(self) -> bool:
        """True if the determinant of Y, in rational arithmetic, is not zero."""
        return bool(characteristic_polynomial([[Fraction(float(v)) for v in row] for row in self.Y])[-1])


def _inverse(slope: ca.SX, x: ca.SX, point: Array, numbers: Mapping[str, float]) -> Array:
    """A matrix (n, n) near the inverse of df/dx at the point."""
    rows, columns = slope.shape
    if rows != columns:
        raise NoBound(f"A zero is proved only of as many functions as unknowns; here {rows} are for {columns}.")
    others = [symbol for symbol in ca.symvar(slope) if symbol.name() in numbers]
    values = [numbers[symbol.name()] for symbol in others]
    A = np.array(ca.Function("slope", [x, ca.vertcat(*others)], [slope])(point, values))
    try:
        Y = np.linalg.inv(A) if np.isfinite(A).all() else np.full(A.shape, np.nan)
    except np.linalg.LinAlgError:
        Y = np.full(A.shape, np.nan)
    if not np.isfinite(Y).all():
        raise NoBound("A zero is proved only where df/dx is regular; here it is singular.")
    return np.asarray(Y, dtype=float)


def _symbols_of(Y: Array) -> tuple[ca.SX, dict[str, float]]:
    """A matrix with a symbol for each entry but zeros, and their numbers: constants would be multiplied and rounded."""
    symbols, numbers = ca.SX(*Y.shape), dict[str, float]()
    for i, j in zip(*np.nonzero(Y), strict=True):
        name = f"entry {i}, {j} of the inverse"
        symbols[int(i), int(j)], numbers[name] = ca.SX.sym(name), float(Y[i, j])
    return symbols, numbers


def _sizes(entries: Walk, unknowns: Unknowns, low: Array, high: Array) -> Array:
    """Bounds of the absolute values of entries over a box, in the shape of their matrix."""
    intervals = evaluate(entries, unknowns.boxes(low[np.newaxis], high[np.newaxis]))
    shape = len(entries.entries), len(entries.entries[0])
    return np.reshape([max(abs(e.low[0]), abs(e.high[0])) for e in intervals], shape, order="F")
