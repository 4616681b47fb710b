"""Numbers as they come from outside, and what they may be."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
Integers = np.ndarray[Any, np.dtype[np.signedinteger[Any]]]

ROUNDING = 1e-12  # how far rounding may take a matrix from symmetry, in units of its largest entry


def nearest(name: str, known: Iterable[str]) -> str:
    """A question that names the known name nearest to a misspelt one; empty if none is near."""
    close = difflib.get_close_matches(name, list(known), n=1, cutoff=0.6)
    return f" Did you mean '{close[0]}'?" if close else ""


def numbers(value: Any) -> Array:
    """The value as a new float array; None and text are refused (TypeError), as are ragged lists (ValueError)."""
    array = np.array(value)
    if array.dtype.kind not in "biuf":
        raise TypeError(array.dtype)
    return array.astype(float)


def vector(call: str, value: Any, size: int, of: str) -> Array:
    """The value as an array (size,); a row or a column will do, and nothing is repeated to fill it.

    Raises
    ------
    ValueError
        If it is no array of numbers, or of another shape; `of` says what the numbers are of.
    """
    try:
        array = numbers(value)
    except (TypeError, ValueError):
        raise ValueError(f"`{call}` must be a vector of numbers; got {value!r}.") from None
    if array.shape not in ((size,), (size, 1), (1, size)):
        raise ValueError(f"`{call}` must have shape ({size},), one number for each of the {of}; got {array.shape}.")
    return array.ravel()


def positive(call: str, value: Any, of: str = "") -> float:
    """A number that is positive, finite and of full accuracy, or a refusal; `of` says what it counts: " of seconds"."""
    try:
        number = float(numbers(None if isinstance(value, bool) or np.ndim(value) else value))
    except (TypeError, ValueError):
        raise ValueError(f"`{call}` must be a positive, finite number{of}; got {value!r}.") from None
    if not np.finfo(float).tiny <= number < np.inf:
        why = ", which a float does not hold to full accuracy" if 0 < number < 1 else ""
        raise ValueError(f"`{call}` must be a positive, finite number{of}; got {number:g}{why}.")
    return number


def seconds(call: str, value: Any) -> float:
    """A span of time that is positive, finite and of full accuracy, or a refusal."""
    return positive(call, value, " of seconds")


def multiple(call: str, span: float, unit: float, of: str) -> int:
    """How many units make up a span, both in s, or a refusal; `of` names the unit."""
    count = round(span / unit)
    # 1e-6 of a unit: what the rounding of the quotient can do at a billion units
    if count < 1 or abs(span / unit - count) > 1e-6 * max(1.0, count * 1e-6):
        raise ValueError(f"`{call}` must be a multiple of {of} {unit:g} s; got {span:g} s.")
    return count


@dataclass(frozen=True)
class Bounds:
    """What a number may be: finite, within [low, high], off both ends if `strict`; a matrix perhaps `symmetric`.

    A symmetric matrix may have to be `definite` too: "semi" has no negative eigenvalue, "positive" not even zero.
    """

    low: float = -np.inf
    high: float = np.inf
    strict: bool = False
    symmetric: bool = False
    definite: Literal["", "semi", "positive"] = ""

    def __post_init__(self) -> None:
        if self.definite not in ("", "semi", "positive") or (self.definite and not self.symmetric):
            raise ValueError(
                "`Bounds(definite=...)` is one of '', 'semi', 'positive', the last two for `symmetric` matrices, whose "
                f"eigenvalues have a sign; got {self.definite!r} with symmetric={self.symmetric}."
            )

    def __str__(self) -> str:
        """The rule as one reads it aloud."""
        if self.low == -np.inf and self.high == np.inf:
            return "finite"
        less = "<" if self.strict else "<="
        left = f"{self.low:g} {less} " if self.low > -np.inf else ""
        right = f" {less} {self.high:g}" if self.high < np.inf else ""
        return f"finite, with {left}value{right}"

    def allow(self, value: Array) -> Array:
        """Elementwise: whether each number is finite and within the bounds (booleans)."""
        inside = (
            (value > self.low) & (value < self.high) if self.strict else ((value >= self.low) & (value <= self.high))
        )
        return np.asarray(np.isfinite(value) & inside)
