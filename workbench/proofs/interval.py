"""Interval arithmetic on arrays of boxes: bounds of a CasADi expression whose symbols stay within a box.

Every result is rounded outward by one step, so that the true set lies within. Where a function has no value (the root
of a negative number, a divisor that may be zero) the interval is the whole line. Sums, products, quotients and roots of
doubles are rounded rightly by IEEE 754. Sines, exponentials and their kin are balls of Arb where it is installed (extra
`rigorous`); elsewhere NumPy's values are widened by `DOUBT` units in the last place, as NumPy states of its own.

References
----------
Moore, Kearfott and Cloud (2009), Introduction to Interval Analysis, chapters 2, 3, 5.
Johansson (2017), Arb: efficient arbitrary-precision midpoint-radius interval arithmetic, IEEE Trans. Computers 66.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass
from importlib.util import find_spec

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from workbench.core.notation.program import NAMES, Walk
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments

ARB = find_spec("flint") is not None  # the extra `rigorous`
if ARB:
    import flint

DOUBT = 4
# The least and greatest values of each function: no enclosure need be wider.
RANGES = dict.fromkeys(("sin", "cos", "tanh"), (-1.0, 1.0)) | dict.fromkeys(("log", "sinh"), (-np.inf, np.inf))
RANGES |= {"exp": (0.0, np.inf), "cosh": (1.0, np.inf), "atan": (-2.0, 2.0), "asin": (-2.0, 2.0), "acos": (0.0, 4.0)}
NUMPY = {name: getattr(np, {"atan": "arctan", "asin": "arcsin", "acos": "arccos"}.get(name, name)) for name in RANGES}


def guarantee() -> str:
    """The ground on which the enclosures of elementary functions rest, in a few words."""
    return "ball arithmetic" if ARB else f"elementary functions taken as right within {DOUBT} last places"


def at_points(name: str, x: Array) -> tuple[Array, Array]:
    """Bounds (N,), (N,) from below and above of the function at doubles x (N,); not a number where it has no value."""
    x = np.asarray(x, dtype=float)
    if ARB:  # the midpoint of 53 bits and the radius of 30 are doubles
        balls = [getattr(flint.arb, name)(flint.arb(value)) for value in x.ravel().tolist()]
        middle, radius = (np.array([float(getattr(b, part)()) for b in balls]) for part in ("mid", "rad"))
        ends = np.nextafter(middle - radius, -np.inf), np.nextafter(middle + radius, np.inf)
        low, high = (end.reshape(x.shape) for end in ends)
    else:
        y = NUMPY[name](x)
        low, high = y - DOUBT * np.spacing(np.abs(y)), y + DOUBT * np.spacing(np.abs(y))
    least, greatest = RANGES[name]
    return np.maximum(low, least), np.minimum(high, greatest)


class NoBound(ValueError):  # noqa: N818
    """The refusal of an expression without a bound over a box; the message names the place or the operation."""


@dataclass(frozen=True, eq=False)
class Interval:
    """Lower and upper ends, (N,) each: one interval a box."""

    low: Array
    high: Array

    @property
    def middle(self) -> Array:
        """A double near the middle."""
        return self.low / 2 + self.high / 2

    @property
    def radius(self) -> Array:
        """The distance of the farther end from the middle, rounded up."""
        return np.asarray(np.nextafter(np.maximum(self.high - self.middle, self.middle - self.low), np.inf))


@check_arguments
def evaluate(steps: Walk, boxes: dict[str, Interval]) -> list[Interval]:
    """The interval of each entry of a walked matrix, column by column, over boxes of its symbols by name."""
    places = [row[j] for j in range(len(steps.entries[0])) for row in steps.entries]
    last = {operand: place for place, node in enumerate(steps.nodes) for operand in node.operands}
    wanted, known = set(places), {}
    size = len(next(iter(boxes.values())).low) if boxes else 1
    for symbol in (node.name for node in steps.nodes if node.code == ca.OP_INPUT and node.name not in boxes):
        raise LookupError(f"`evaluate(boxes=...)` must hold a box for each symbol; got none for {symbol!r}.")
    with np.errstate(all="ignore"):
        for place, node in enumerate(steps.nodes):
            if node.code == ca.OP_CONST:
                known[place] = Interval(np.full(size, node.value), np.full(size, node.value))
            elif node.code == ca.OP_INPUT:
                known[place] = boxes[node.name]
            elif node.code in RULES:
                known[place] = _whole_if_nan(RULES[node.code](*(known[i] for i in node.operands)))
            else:
                name = NAMES.get(node.code, node.code)
                raise NoBound(f"An interval of {name} is not known here; write the expression without it.")
            for i in node.operands:  # what is not needed again need not be held
                if last[i] == place and i not in wanted:
                    known.pop(i, None)
    return [known[place] for place in places]


@check_arguments
def jumps(steps: Walk, names: Collection[str]) -> list[str]:
    """The operations at which a walked matrix may jump, or has no slope, as the symbols of these names change."""
    moves: list[bool] = []
    for node in steps.nodes:
        moves.append(node.name in names or any(moves[i] for i in node.operands))
    return [NAMES[node.code] for node, moving in zip(steps.nodes, moves, strict=True) if moving and node.code in JUMPS]


def _outward(low: Array, high: Array) -> Interval:
    return Interval(np.nextafter(low, -np.inf), np.nextafter(high, np.inf))


def _whole_if_nan(x: Interval) -> Interval:
    lost = np.isnan(x.low) | np.isnan(x.high)
    return Interval(np.where(lost, -np.inf, x.low), np.where(lost, np.inf, x.high)) if lost.any() else x


def _sum(a: Interval, b: Interval) -> Interval:
    """The sum of intervals, exactly zero where the doubles add up to zero."""
    low, high = a.low + b.low, a.high + b.high
    return Interval(
        np.where(low == 0, low, np.nextafter(low, -np.inf)), np.where(high == 0, high, np.nextafter(high, np.inf))
    )


def _negative(a: Interval) -> Interval:
    return Interval(-a.high, -a.low)


def _product(a: Interval, b: Interval) -> Interval:
    ends = np.stack([a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high])
    result = _outward(ends.min(axis=0), ends.max(axis=0))
    return Interval(np.where((a.low >= 0) & (b.low >= 0), np.maximum(result.low, 0.0), result.low), result.high)


def _inverse(a: Interval) -> Interval:
    pole = (a.low <= 0) & (a.high >= 0)
    result = _outward(1 / a.high, 1 / a.low)
    return Interval(np.where(pole, -np.inf, result.low), np.where(pole, np.inf, result.high))


def _absolute(a: Interval) -> Interval:
    inside = (a.low <= 0) & (a.high >= 0)
    ends = np.abs([a.low, a.high])
    return Interval(np.where(inside, 0.0, ends.min(axis=0)), ends.max(axis=0))


def _power(a: Interval, b: Interval) -> Interval:
    n = float(b.low[0]) if b.low.size and (b.low == b.low[0]).all() and (b.high == b.low[0]).all() else math.nan
    if not (n == int(n) if math.isfinite(n) else False) or abs(n) > 64:
        return _rising("exp")(_product(b, _rising("log")(a)))
    base = _absolute(a) if n % 2 == 0 else a
    result = Interval(np.ones_like(a.low), np.ones_like(a.high))
    for _ in range(int(abs(n))):
        result = _product(result, base)
    return _inverse(result) if n < 0 else result


def _rising(name: str) -> Callable[[Interval], Interval]:
    return lambda a: Interval(at_points(name, a.low)[0], at_points(name, a.high)[1])


def _root(a: Interval) -> Interval:
    result = _outward(np.sqrt(a.low), np.sqrt(a.high))
    return Interval(np.maximum(result.low, 0.0), result.high)


def _wave(name: str, crest: float) -> Callable[[Interval], Interval]:
    """A sine or cosine with its crests at crest + 2 pi k and its troughs half a turn from them."""

    def rule(a: Interval) -> Interval:
        (low, high), (other_low, other_high) = at_points(name, a.low), at_points(name, a.high)
        return Interval(
            np.where(_meets(a, crest + math.pi), -1.0, np.minimum(low, other_low)),
            np.where(_meets(a, crest), 1.0, np.maximum(high, other_high)),
        )

    return rule


def _meets(a: Interval, phase: float) -> Array:
    """True where phase + 2 pi k may lie in the interval, also in doubt."""
    doubt = 1e-15 * (np.abs(a.low) + np.abs(a.high) + 8)
    first = np.ceil((a.low - phase - doubt) / (2 * math.pi))
    return np.asarray(np.logical_not(first > np.floor((a.high - phase + doubt) / (2 * math.pi))))


def _angle(y: Interval, x: Interval) -> Interval:
    """The angle of (x, y): by the arc tangent where x > 0, else anything from -pi to pi."""
    inner, right, turn = _rising("atan")(_whole_if_nan(_product(y, _inverse(x)))), x.low > 0, np.nextafter(math.pi, 4)
    return Interval(np.where(right, inner.low, -turn), np.where(right, inner.high, turn))


def _truth(sure: NDArray[np.bool_], possible: NDArray[np.bool_]) -> Interval:
    return Interval(sure.astype(float), possible.astype(float))


def _chosen(condition: Interval, x: Interval) -> Interval:
    sure, possible = (condition.low > 0) | (condition.high < 0), (condition.low != 0) | (condition.high != 0)
    low = np.where(sure, x.low, np.where(possible, np.minimum(x.low, 0.0), 0.0))
    return Interval(low, np.where(sure, x.high, np.where(possible, np.maximum(x.high, 0.0), 0.0)))


def _remainder(a: Interval, b: Interval) -> Interval:
    """The rest of a division, with the sign of a: smaller than either."""
    most = np.minimum(np.abs([a.low, a.high]).max(axis=0), np.abs([b.low, b.high]).max(axis=0))
    return Interval(np.where(a.low >= 0, 0.0, -most), np.where(a.high <= 0, 0.0, most))


def _both(function: Callable[..., Array]) -> Callable[..., Interval]:
    """A function of intervals from an exact function that does not fall in any argument: its values at both ends."""
    return lambda *parts: Interval(function(*[x.low for x in parts]), function(*[x.high for x in parts]))


def _not(a: Interval) -> Interval:
    return _truth((a.low == 0) & (a.high == 0), (a.low <= 0) & (a.high >= 0))


INCREASING_FUNCTIONS = ("exp", "log", "tanh", "sinh", "atan", "asin")
RULES: dict[int, Callable[..., Interval]] = {
    **{int(getattr(ca, f"OP_{name.upper()}")): _rising(name) for name in INCREASING_FUNCTIONS},
    ca.OP_ASSIGN: lambda x: x,
    ca.OP_ADD: _sum,
    ca.OP_SUB: lambda x, y: _sum(x, _negative(y)),
    ca.OP_MUL: _product,
    ca.OP_DIV: lambda x, y: _product(x, _inverse(y)),
    ca.OP_NEG: _negative,
    ca.OP_TWICE: lambda x: Interval(2 * x.low, 2 * x.high),
    ca.OP_SQ: lambda x: _product(_absolute(x), _absolute(x)),
    ca.OP_INV: _inverse,
    ca.OP_POW: _power,
    ca.OP_CONSTPOW: _power,
    ca.OP_SQRT: _root,
    ca.OP_SIN: _wave("sin", math.pi / 2),
    ca.OP_COS: _wave("cos", 0.0),
    ca.OP_TAN: lambda x: _product(_wave("sin", math.pi / 2)(x), _inverse(_wave("cos", 0.0)(x))),
    ca.OP_ACOS: lambda x: _rising("acos")(Interval(x.high, x.low)),
    ca.OP_COSH: lambda x: _rising("cosh")(_absolute(x)),
    ca.OP_ATAN2: _angle,
    ca.OP_FABS: _absolute,
    ca.OP_SIGN: _both(np.sign),
    ca.OP_FLOOR: _both(np.floor),
    ca.OP_CEIL: _both(np.ceil),
    ca.OP_FMIN: _both(np.minimum),
    ca.OP_FMAX: _both(np.maximum),
    ca.OP_FMOD: _remainder,
    ca.OP_LT: lambda x, y: _truth(x.high < y.low, x.low < y.high),
    ca.OP_LE: lambda x, y: _truth(x.high <= y.low, x.low <= y.high),
    ca.OP_EQ: lambda x, y: _truth(
        (x.low == x.high) & (y.low == y.high) & (x.low == y.low), (x.low <= y.high) & (y.low <= x.high)
    ),
    ca.OP_NE: lambda x, y: _not(RULES[ca.OP_EQ](x, y)),
    ca.OP_AND: lambda x, y: _not(RULES[ca.OP_OR](_not(x), _not(y))),
    ca.OP_OR: lambda x, y: _both(np.maximum)(_not(_not(x)), _not(_not(y))),
    ca.OP_NOT: _not,
    ca.OP_IF_ELSE_ZERO: _chosen,
}

# At these an expression may jump, or CasADi writes its slope with a divisor that may be zero (the larger of two).
JUMPS: Collection[int] = (
    ca.OP_SIGN, ca.OP_FLOOR, ca.OP_CEIL, ca.OP_FMOD, ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_AND, ca.OP_OR,
    ca.OP_NOT, ca.OP_IF_ELSE_ZERO, ca.OP_ATAN2, ca.OP_FMIN, ca.OP_FMAX, ca.OP_COPYSIGN, ca.OP_REMAINDER,
)  # fmt: skip
