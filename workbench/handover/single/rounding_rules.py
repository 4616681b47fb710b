"""The error that each operation of a graph hands on: bounds of |single - double| from those of the operands.

Single is an evaluation in floats and double the portable one in doubles, from the same numbers. Both round each sum,
product, reciprocal, quotient and root correctly. So with u = 2^-24 (and 2^-53, which is within its last bits)

    |fl(a' o b') - fl(a o b)| <= |a' o b' - a o b| + u |a' o b'| + u_double |a o b| + eta

where eta = 2^-149 is what an operation loses below the range of normal floats. The first part is bounded exactly for
rational operations and roots, and by a Lipschitz constant on the interval for the others; their own errors are stated
in `RELATIVE_ERRORS`. Where a decision (a sign, a comparison, a floor) lies within its bound there is no bound:
infinity.

References
----------
Higham (2002), Accuracy and Stability of Numerical Algorithms, 2nd edition, sections 2.2 and 3.3 (running error).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array
from workbench.engine.machines.single_elementary_functions import LARGEST_ANGLE, MOST_EXPONENT, MOST_TURNS

Reals = Array | np.float64  # of all rows, or one number for them
Rule = Callable[..., Reals]  # from a result and its enclosed operands to the bound of the result
Flags = NDArray[np.bool_] | np.bool_

INFINITY = np.inf
ROUNDING = 2.0**-24
UNIT = ROUNDING + 2.0**-50  # the rounding of single and of double
LOSS = 2.0**-149
LARGEST = (2.0 - 2.0**-23) * 2.0**127
SLACK = 1.0 + 2.0**-45  # bounds are computed in doubles, with some twenty roundings of 2^-53 each
CLOSE = 16.0  # branches that differ by more than so many bounds are a jump, and none that a switch joins
EXPONENTIAL_LOSS = 2.0**-125  # exp x below -87, which is 0 in single precision

# Relative errors of the functions in single precision, in units of 2^-24. For functions of one number they are checked
# at every float of their domains; the angle's at every ratio of its sides, with the rounding of that ratio added.
RELATIVE_ERRORS: Mapping[str, float] = {
    "sin": 3.0,
    "cos": 3.0,
    "exp": 1.5,
    "log": 1.5,
    "tanh": 2.5,
    "atan2": 4.0,
    "hypot": 2.5,
    "expm1": 2.5,
    "log1p": 3.0,
    "sinh": 3.5,
    "cosh": 2.5,
    "asinh": 3.5,
    "acosh": 4.0,
    "atanh": 4.0,
}


class BoundedValue(NamedTuple):
    """A value in doubles, a bound of what that in single precision differs from it, and True if neither is negative."""

    value: Reals
    bound: Reals
    positive: bool = False


def rounded_bound(value: Reals, spread: Reals) -> Reals:
    """The bound of a result that is rounded, from the spread of the exact ones."""
    return spread + UNIT * (np.abs(value) + spread)


def function_bound(op: str, value: Reals, spread: Reals) -> Reals:
    """The same of an elementary function, whose double has an error of a few units too."""
    return spread + (RELATIVE_ERRORS[op] * ROUNDING + 2.0**-48) * (np.abs(value) + spread) + LOSS


def _sum(value: Reals, a: BoundedValue, b: BoundedValue) -> Reals:
    return rounded_bound(value, a.bound + b.bound)


def _product(value: Reals, a: BoundedValue, b: BoundedValue) -> Reals:
    spread = np.abs(a.value) * b.bound + np.abs(b.value) * a.bound + a.bound * b.bound
    return rounded_bound(value, spread) + LOSS


def _product_and_sum(value: Reals, a: BoundedValue, b: BoundedValue, c: BoundedValue) -> Reals:
    product = a.value * b.value
    bound = _product(product, a, b)
    return np.where(np.abs(product) + bound <= LARGEST, rounded_bound(value, bound + c.bound), INFINITY)


def _quotient(value: Reals, a: BoundedValue, b: BoundedValue) -> Reals:
    gap = np.abs(b.value) - b.bound
    return np.where(gap > 0, rounded_bound(value, (a.bound + np.abs(value) * b.bound) / gap) + LOSS, INFINITY)


def _reciprocal(value: Reals, a: BoundedValue) -> Reals:
    return _quotient(value, BoundedValue(np.float64(1.0), np.float64(0.0)), a)


def _root(value: Reals, a: BoundedValue) -> Reals:
    low = np.maximum(a.value - a.bound, 0.0)
    near = np.sqrt(a.bound) if a.positive else INFINITY
    spread = np.where(a.value > a.bound, a.bound / (value + np.sqrt(low)), near)
    return rounded_bound(value, np.where(a.bound > 0, spread, 0.0))


def _same(_: Reals, a: BoundedValue) -> Reals:
    return a.bound


def _exponential(value: Reals, a: BoundedValue) -> Reals:
    bound = function_bound("exp", value, value * np.expm1(a.bound)) + EXPONENTIAL_LOSS
    return np.where(a.value + a.bound <= MOST_EXPONENT, bound, INFINITY)


def _logarithm(value: Reals, a: BoundedValue) -> Reals:
    gap = a.value - a.bound
    return np.where(gap > 0, function_bound("log", value, a.bound / gap), INFINITY)


def _hyperbolic_tangent(value: Reals, a: BoundedValue) -> Reals:
    slope = 1.0 / np.cosh(np.maximum(np.abs(a.value) - a.bound, 0.0)) ** 2
    return function_bound("tanh", value, slope * a.bound)


def _sine(value: Reals, a: BoundedValue) -> Reals:
    return _wave("sin", value, a, np.cos(a.value))


def _cosine(value: Reals, a: BoundedValue) -> Reals:
    return _wave("cos", value, a, np.sin(a.value))


def _wave(op: str, value: Reals, a: BoundedValue, slope: Reals) -> Reals:
    spread = np.minimum(a.bound, np.abs(slope) * a.bound + 0.5 * a.bound**2)
    return np.where(np.abs(a.value) + a.bound <= LARGEST_ANGLE, function_bound(op, value, spread), INFINITY)


def _angle(value: Reals, y: BoundedValue, x: BoundedValue) -> Reals:
    """atan2 has slope 1 / radius; it jumps across the negative axis."""
    nearest = np.hypot(*(np.maximum(np.abs(side.value) - side.bound, 0.0) for side in (x, y)))
    across = (np.abs(y.value) <= y.bound) & (x.value - x.bound <= 0)
    spread = np.hypot(x.bound, y.bound) / nearest
    return np.where((nearest > 0) & ~across, function_bound("atan2", value, spread), INFINITY)


def _remainder(value: Reals, x: BoundedValue, y: BoundedValue) -> Reals:
    """Exact in both, as long as the whole number of turns is the same."""
    quotient, gap = x.value / y.value, np.abs(y.value) - y.bound
    spread = (x.bound + np.abs(quotient) * y.bound) / gap
    still = (x.bound == 0) & (y.bound == 0)
    spread = np.where(still, 0.0, spread * SLACK + np.abs(quotient) * 2.0**-50)
    turns = np.trunc(quotient)
    same = (np.trunc(quotient - spread) == turns) & (np.trunc(quotient + spread) == turns)
    # the quotient is rounded in the algorithm alone, which mends a whole one too many
    same &= (gap > 0) & (np.abs(quotient) + spread < MOST_TURNS / 2)
    return np.where(same, x.bound + np.abs(turns) * y.bound, INFINITY)


def _floor(value: Reals, a: BoundedValue) -> Reals:
    spread = np.where(a.bound > 0, a.bound + np.abs(a.value) * 2.0**-50, 0.0)
    same = (np.floor(a.value - spread) == value) & (np.floor(a.value + spread) == value)
    return np.where(same, 0.0, INFINITY)


def _smaller(_: Reals, a: BoundedValue, b: BoundedValue) -> Reals:
    apart, reach = b.value - a.value, a.bound + b.bound
    return np.where(apart > reach, a.bound, np.where(-apart > reach, b.bound, np.maximum(a.bound, b.bound)))


def _larger(_: Reals, a: BoundedValue, b: BoundedValue) -> Reals:
    apart, reach = a.value - b.value, a.bound + b.bound
    return np.where(apart > reach, a.bound, np.where(-apart > reach, b.bound, np.maximum(a.bound, b.bound)))


def _certain(certain: Flags) -> Reals:
    return np.where(certain, 0.0, INFINITY)


def known_sign(a: BoundedValue) -> Flags:
    """True where the value is zero, positive or negative in both precisions."""
    known: Flags = (np.abs(a.value) > a.bound) | (a.bound == 0)
    return known


def _sign(_: Reals, a: BoundedValue) -> Reals:
    return _certain(known_sign(a))


def _order(_: Reals, a: BoundedValue, b: BoundedValue) -> Reals:
    reach = (a.bound + b.bound) * SLACK
    return _certain((np.abs(a.value - b.value) > reach) | (reach == 0))


def _both(_: Reals, a: BoundedValue, b: BoundedValue) -> Reals:
    known = [known_sign(part) for part in (a, b)]
    false = [certain & (part.value == 0) for certain, part in zip(known, (a, b), strict=True)]
    return _certain((known[0] & known[1]) | false[0] | false[1])


def _either(_: Reals, a: BoundedValue, b: BoundedValue) -> Reals:
    known = [known_sign(part) for part in (a, b)]
    true = [certain & (part.value != 0) for certain, part in zip(known, (a, b), strict=True)]
    return _certain((known[0] & known[1]) | true[0] | true[1])


def _choice(_: Reals, condition: BoundedValue, a: BoundedValue, b: BoundedValue) -> Reals:
    """The bound of the branch that is chosen; where it is not certain which, of both, if they are close."""
    first = condition.value != 0
    chosen, other = np.where(first, a.bound, b.bound), np.where(first, b.bound, a.bound)
    apart = np.abs(a.value - b.value)
    joined = np.where(apart <= CLOSE * (a.bound + b.bound), np.maximum(chosen, apart + other), INFINITY)
    return np.where(known_sign(condition), chosen, joined)


RULES: Mapping[str, Rule] = {
    **dict.fromkeys(("add", "sub"), _sum),
    **dict.fromkeys(("fma", "fms", "fnma"), _product_and_sum),
    **dict.fromkeys(("neg", "fabs"), _same),
    **dict.fromkeys(("lt", "le", "eq", "ne"), _order),
    **dict.fromkeys(("not", "sign"), _sign),
    "mul": _product,
    "div": _quotient,
    "inv": _reciprocal,
    "sqrt": _root,
    "exp": _exponential,
    "log": _logarithm,
    "tanh": _hyperbolic_tangent,
    "sin": _sine,
    "cos": _cosine,
    "atan2": _angle,
    "fmod": _remainder,
    "floor": _floor,
    "fmin": _smaller,
    "fmax": _larger,
    "and": _both,
    "or": _either,
    "if_else": _choice,
}


def never_negative(op: str, operands: tuple[int, ...], positive: Mapping[int, bool]) -> bool:
    """True if the result of an operation is not negative in any precision, from which operands are not."""
    if op in ("mul", "fma") and operands[0] == operands[1]:
        return all(positive[i] for i in operands[2:])
    if op in ("add", "mul", "fma", "div", "inv", "floor", "fmin", "not", "and", "or", "lt", "le", "eq", "ne"):
        return op in ("not", "and", "or", "lt", "le", "eq", "ne") or all(positive[i] for i in operands)
    if op == "if_else":
        return all(positive[i] for i in operands[1:])
    return op in ("fabs", "sqrt", "exp", "cosh", "hypot") or (op == "fmax" and any(positive[i] for i in operands))
