"""Certified extremes over boxes, of a number, an eigenvalue or a norm: sampled, and proved by branch and bound."""

from __future__ import annotations

import decimal
from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core.notation.program import walk
from workbench.core.validation.refusals import Array, as_array, describe, positive, refusal, seconds, whole
from workbench.core.validation.signatures import check_arguments
from workbench.proofs import branch_and_bound
from workbench.proofs.branch_and_bound import LeastSample, least_seen, prove
from workbench.proofs.enclosures import UNIT, AbstractForm, form_of
from workbench.proofs.interval import NoBound, guarantee, jumps

TOLERANCE = 1e-8  # the gap between seen and proved, as a share of what is seen
# Doubles that all boxes of one side may need if no budget is given, and those of the least of boxes: together
# some ten seconds on one core.
WORK, LEAST = 200_000_000, 1000
LARGEST = 2.0**1000  # in size, of the ends of a box: their sums and differences are doubles too


@dataclass(frozen=True, eq=False)
class Extreme:
    """The least or greatest value of something over a box: that of so many `samples`, to rounding, at `x` (k,).

    `value_bound` is a proved bound of the value there, from above for a least; `bound` one of all values in the box, by
    so many `boxes`, or None. `why` is the reason why the proof misses its tolerance, else empty.
    """

    value: float
    x: Array
    value_bound: float
    bound: float | None
    boxes: int
    samples: int
    why: str

    @property
    def digits(self) -> int:
        """The number of decimal digits of the value that are proved right, by the gap between seen and proved."""
        if self.bound is None or not self.value:
            return 0
        gap = max(abs(self.value - self.bound), 1e-16 * abs(self.value))
        return max(int(-np.log10(2 * gap / abs(self.value))), 0)


@dataclass(frozen=True, eq=False)
class Enclosure:
    """Both extremes of an expression over a box: low <= expression <= high is proved; None where it is not."""

    least: Extreme
    greatest: Extreme

    @property
    def low(self) -> float | None:
        """The bound from below."""
        return self.least.bound

    @property
    def high(self) -> float | None:
        """The bound from above."""
        return self.greatest.bound

    @property
    def complete(self) -> bool:
        """True if both sides reach their tolerance."""
        return not (self.least.why or self.greatest.why)


@check_arguments
def enclose(
    expression: ca.SX,
    symbols: ca.SX,
    low: float | Array,
    high: float | Array,
    *,
    tolerance: float = TOLERANCE,
    boxes: int | None = None,
    numbers: Mapping[str, float] | None = None,
) -> Enclosure:
    """The range of one expression over low <= symbols <= high, (k, 1) each, with `numbers` for its other symbols.

    `tolerance` is the gap between seen and proved, as a share of the largest absolute value that was seen; `boxes` the
    budget for each side, by itself some ten seconds. `NoBound` names an operation without an interval, or a pole.
    """
    if expression.numel() != 1:
        raise ValueError(f"`enclose(expression=...)` takes one expression; got shape {expression.shape}.")
    task = _task("enclose", expression, symbols, low, high, numbers)
    lower, upper = (task.least_sample(sign) for sign in (1, -1))
    scale = max(abs(lower.value), abs(upper.value)) or 1.0
    return Enclosure(*(task.prove_extreme(s, seen, scale, tolerance, boxes) for s, seen in ((1, lower), (-1, upper))))


@check_arguments
def extreme_eigenvalue(
    matrix: ca.SX,
    symbols: ca.SX,
    low: float | Array,
    high: float | Array,
    sign: int,
    *,
    tolerance: float = TOLERANCE,
    boxes: int | None = None,
    numbers: Mapping[str, float] | None = None,
) -> Extreme:
    """The least (sign 1) or greatest (sign -1) eigenvalue of the symmetric part of a matrix (n, n) over a box.

    The arguments are those of `enclose`; the tolerance is a share of the extreme itself.
    """
    if sign not in (1, -1):
        raise ValueError(f"`extreme_eigenvalue(sign=...)` is 1 for the least or -1 for the greatest; got {sign}.")
    if matrix.shape[0] != matrix.shape[1]:
        raise ValueError(
            f"`extreme_eigenvalue(matrix=...)` must be square to have eigenvalues; got shape {matrix.shape}."
        )
    task = _task("extreme_eigenvalue", (matrix + matrix.T) / 2, symbols, low, high, numbers)
    seen = task.least_sample(sign)
    return task.prove_extreme(sign, seen, abs(seen.value) or 1.0, tolerance, boxes)


@check_arguments
def largest_norm(vector: ca.SX, symbols: ca.SX, low: float | Array, high: float | Array) -> Extreme:
    """The greatest 2-norm of a vector over a box: the root of the greatest sum of its squares."""
    if 1 not in vector.shape:
        raise ValueError(f"`largest_norm(vector=...)` must be a vector; got shape {vector.shape}.")
    square = extreme_eigenvalue(ca.sumsqr(ca.densify(vector)), symbols, low, high, -1, tolerance=2 * TOLERANCE)
    beyond = None if square.bound is None else float(np.nextafter(np.sqrt(max(square.bound, 0.0)), np.inf))
    reached = float(np.nextafter(np.sqrt(max(square.value_bound, 0.0)), -np.inf))
    return replace(square, value=float(np.sqrt(max(square.value, 0.0))), value_bound=reached, bound=beyond)


@check_arguments
def disturbance_bounds(D: ca.SX, t: ca.SX, until: float) -> tuple[Extreme, Extreme]:
    """The greatest |D(t)| and |D'(t)| for 0 <= t <= until, D (n, 1) in N m; `NoBound` if D may jump or has poles."""
    until = seconds("disturbance_bounds(until=...)", until)
    if not (t.is_scalar() and t.is_symbolic()):
        raise refusal("disturbance_bounds(t=...)", "the symbol of time in D", t)
    if broken := jumps(walk(D), [t.name()]):
        raise NoBound(f"A disturbance that holds {broken[0]} may jump, and its slope then says nothing.")
    return largest_norm(D, t, 0.0, until), largest_norm(ca.jacobian(D, t), t, 0.0, until)


@check_arguments
def bound_text(bound: float, side: int) -> str:
    """A proved bound as text with nine digits, rounded outward: down (side 1) or up (side -1)."""
    if side not in (1, -1):
        raise refusal("shown(side=...)", "1 for a bound from below or -1 for one from above", side)
    rounding = decimal.ROUND_FLOOR if side == 1 else decimal.ROUND_CEILING
    return f"{float(decimal.Context(prec=9, rounding=rounding).create_decimal(bound)):.9g}"


def by_intervals(boxes: int) -> str:
    """The end of an evidence: the method of the proof, and the arithmetic on which it rests."""
    return f", by interval arithmetic on {boxes} boxes ({guarantee()})"


@dataclass(frozen=True, eq=False)
class _Task:
    """A matrix and its negative as forms over the symbols that vary, with the box and the name of the call."""

    call: str
    forms: dict[int, AbstractForm]
    free: list[int]
    low: Array
    high: Array

    def least_sample(self, sign: int) -> LeastSample:
        form, low, high = self.forms[sign], self.low[self.free], self.high[self.free]

        def smallest(x: Array) -> Array:
            S = form.value(x)
            if not (finite := np.isfinite(S).all(axis=(1, 2))).all():
                where = self._at(x[np.flatnonzero(~finite)[0]]).tolist()
                raise NoBound(f"A bound needs finite numbers all over the box; it has none at {where}.")
            return np.asarray(np.linalg.eigvalsh(S)[:, 0])

        return least_seen(smallest, low, high)

    def prove_extreme(
        self, sign: int, sample: LeastSample, scale: float, tolerance: float, boxes: int | None
    ) -> Extreme:
        positive(f"{self.call}(tolerance=...)", tolerance, ", as intervals leave a little room")
        box = branch_and_bound.whole(self.low[self.free], self.high[self.free])
        budget = WORK // (self.forms[sign].cost + LEAST) if boxes is None else whole(f"{self.call}(boxes=...)", boxes)
        found = prove(self.forms[sign], box, (sample.value, sample.x), scale, tolerance, budget)
        beyond = None if found.bound is None else sign * found.bound
        value, reached = sign * found.value, sign * self._reached(sign, found.x)
        return Extreme(value, self._at(found.x), reached, beyond, found.boxes, sample.samples, found.why)

    def _reached(self, sign: int, x: Array) -> float:
        """A bound from above of the least eigenvalue at x: u' S u / u'u for a vector u, enclosed and rounded up."""
        form, c = self.forms[sign], x[np.newaxis]
        u = np.linalg.eigh(form.value(c))[1][:, :, :1]
        with np.errstate(all="ignore"):
            A, _, R, _ = form.expand(c, np.zeros_like(c), u)
        quotient = float((A + R).item() / (u**2).sum())
        return quotient + 8 * (u.size + 2) * UNIT * abs(quotient) if np.isfinite(quotient) else np.inf

    def _at(self, x: Array) -> Array:
        point = (self.low + self.high) / 2
        point[self.free] = x
        return point


def _task(
    call: str,
    matrix: ca.SX,
    symbols: ca.SX,
    low: float | Array,
    high: float | Array,
    numbers: Mapping[str, float] | None,
) -> _Task:
    if not symbols.is_valid_input():
        raise refusal(f"{call}(symbols=...)", "a column of symbols, each of them alone", symbols)
    first, last = box_of(call, low, high, symbols.numel())
    names, fixed = [symbols[i].name() for i in range(symbols.numel())], numbers or {}
    held = [name for name in (symbol.name() for symbol in ca.symvar(matrix)) if name not in fixed]
    if foreign := [name for name in held if name not in names]:
        raise ValueError(f"`{call}(symbols=...)` must hold all symbols of the expression; '{foreign[0]}' is missing.")
    free = sorted(map(names.index, held))
    forms = {sign: form_of(sign * matrix, [symbols[i] for i in free], fixed) for sign in (1, -1)}
    return _Task(call, forms, free, first, last)


def box_of(call: str, low: float | Array, high: float | Array, k: int) -> tuple[Array, Array]:
    """Both sides of a box, (k,) each, from numbers or vectors with finite low < high."""
    sides, got = [as_array(side) for side in (low, high)], f"{describe(low)} and {describe(high)}"
    if any(side is None or side.shape not in ((), (1,), (k,)) for side in sides):
        raise ValueError(f"`{call}(low=..., high=...)` must be numbers or vectors of {k}; got {got}.")
    first, last = (np.broadcast_to(side, k).copy() for side in sides if side is not None)
    if not (np.abs([first, last]) <= LARGEST).all() or not (first < last).all():
        raise ValueError(f"`{call}(low=..., high=...)` needs finite low < high; got {got}.")
    return first, last
