"""The error that the further elementary functions hand on, as `rounding_rules` has those of the others.

The errors of their own were found at every 31st float of their domains, and at pairs of random floats for `hypot`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from workbench.engine.machines.single_elementary_functions import MOST_EXPONENT
from workbench.handover.single.rounding_rules import INFINITY, BoundedValue, Reals, Rule, function_bound, known_sign


def _less_one(value: Reals, a: BoundedValue) -> Reals:
    """The slope of e^x - 1 is its value and one."""
    bound = function_bound("expm1", value, (value + 1.0) * np.expm1(a.bound))
    return np.where(a.value + a.bound <= MOST_EXPONENT, bound, INFINITY)


def _of_one_more(value: Reals, a: BoundedValue) -> Reals:
    gap = 1.0 + a.value - a.bound
    return np.where(gap > 0, function_bound("log1p", value, a.bound / gap), INFINITY)


def _hyperbolic(op: str, slope: Callable[[Reals], Reals]) -> Rule:
    """sinh or cosh: the slope is largest at the farthest end."""

    def rule(value: Reals, a: BoundedValue) -> Reals:
        farthest = np.abs(a.value) + a.bound
        return np.where(farthest <= MOST_EXPONENT, function_bound(op, value, slope(farthest) * a.bound), INFINITY)

    return rule


def _inverse_sine(value: Reals, a: BoundedValue) -> Reals:
    nearest = np.maximum(np.abs(a.value) - a.bound, 0.0)
    return function_bound("asinh", value, a.bound / np.hypot(1.0, nearest))


def _inverse_cosine(value: Reals, a: BoundedValue) -> Reals:
    low = a.value - a.bound
    spread = np.where(a.bound > 0, a.bound / np.sqrt((low - 1.0) * (low + 1.0)), 0.0)
    return np.where((low > 1.0) | (a.bound == 0), function_bound("acosh", value, spread), INFINITY)


def _inverse_tangent(value: Reals, a: BoundedValue) -> Reals:
    far = np.abs(a.value) + a.bound
    return np.where(far < 1.0, function_bound("atanh", value, a.bound / ((1.0 - far) * (1.0 + far))), INFINITY)


def _length(value: Reals, a: BoundedValue, b: BoundedValue) -> Reals:
    return function_bound("hypot", value, np.hypot(a.bound, b.bound))


def _signed(_: Reals, a: BoundedValue, b: BoundedValue) -> Reals:
    return np.where(known_sign(b), a.bound, INFINITY)


FURTHER_RULES: Mapping[str, Rule] = {
    "expm1": _less_one,
    "log1p": _of_one_more,
    "sinh": _hyperbolic("sinh", np.cosh),
    "cosh": _hyperbolic("cosh", np.sinh),
    "asinh": _inverse_sine,
    "acosh": _inverse_cosine,
    "atanh": _inverse_tangent,
    "hypot": _length,
    "copysign": _signed,
}
FURTHER_REASONS = {
    "expm1": "exponential of {}",
    "log1p": "logarithm of 1 and {}",
    "sinh": "hyperbolic sine of {}",
    "cosh": "hyperbolic cosine of {}",
    "acosh": "inverse hyperbolic cosine of {}",
    "atanh": "inverse hyperbolic tangent of {}",
    "copysign": "sign of {1}",
}
