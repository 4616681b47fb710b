"""The numbers of a block: their bounds and their shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from workbench.core.validation.refusals import Array, describe, refusal
from workbench.core.validation.signatures import check_arguments

ROUNDING = 1e-12  # how far rounding may take a matrix from symmetry, in units of its largest entry
LONGEST = 1_000_000  # entries of one axis of a number
MOST_SHOWN = 12  # numbers of an array in a message


@dataclass(frozen=True)
@check_arguments
class Bounds:
    """The range of a number: finite, within [low, high], without both ends if `strict`; a matrix perhaps `symmetric`.

    A symmetric matrix may have to be `definite` too: "semi" has no negative eigenvalue, "positive" not even zero.
    """

    low: float = -np.inf
    high: float = np.inf
    strict: bool = False
    symmetric: bool = False
    definite: Literal["", "semi", "positive"] = ""

    def __post_init__(self) -> None:
        if not self.low <= self.high:
            raise ValueError(f"`Bounds(low=..., high=...)` must keep low <= high; got {self.low:g} and {self.high:g}.")
        if self.definite and not self.symmetric:
            raise ValueError(
                f"`Bounds(definite={self.definite!r})` is for `symmetric` matrices, whose eigenvalues have a sign; "
                "got symmetric=False."
            )

    def __str__(self) -> str:
        """The rule in words: `finite, with 0 < value`."""
        if self.low == -np.inf and self.high == np.inf:
            return "finite"
        less = "<" if self.strict else "<="
        left = f"{self.low:g} {less} " if self.low > -np.inf else ""
        right = f" {less} {self.high:g}" if self.high < np.inf else ""
        return f"finite, with {left}value{right}"

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the largest finite number that is allowed."""
        low = np.nextafter(self.low, np.inf) if self.strict or np.isinf(self.low) else self.low
        high = np.nextafter(self.high, -np.inf) if self.strict or np.isinf(self.high) else self.high
        return float(low), float(high)

    @check_arguments
    def allow(self, value: Array) -> Array:
        """True for each number that is finite and within the bounds."""
        strict = (value > self.low) & (value < self.high)
        inside = strict if self.strict else (value >= self.low) & (value <= self.high)
        return np.asarray(np.isfinite(value) & inside)

    @check_arguments
    def refuse_unsymmetric(self, name: str, matrices: Array) -> None:
        """Refuse a matrix of (B, n, n) that is not symmetric, or not as definite as it must be."""
        if matrices.ndim < 2 or matrices.shape[-1] != matrices.shape[-2]:
            raise refusal("Bounds.refuse_unsymmetric(matrices=...)", "matrices (B, n, n)", matrices)
        size = np.abs(matrices)
        odd = np.argwhere(np.abs(matrices - np.swapaxes(matrices, -1, -2)) > ROUNDING * size.max(initial=0.0))
        if len(odd):
            run, i, j = odd[0]
            raise ValueError(
                f"'{name}' must be symmetric; got {matrices[run, i, j]:g} at [{i},{j}] and {matrices[run, j, i]:g} at "
                f"[{j},{i}]: set both."
            )
        if not self.definite:
            return
        smallest = np.linalg.eigvalsh(matrices).min(axis=-1)
        positive = self.definite == "positive"
        low = np.flatnonzero(smallest <= 0 if positive else smallest < -ROUNDING * size.max(axis=(-2, -1)))
        if len(low):
            where = f" in run {low[0]}" if len(matrices) > 1 else ""
            raise ValueError(
                f"'{name}' must be positive {'definite' if positive else 'semidefinite'}; "
                f"got a smallest eigenvalue of {smallest[low[0]]:.3g}{where}."
            )


@dataclass(frozen=True)
class Quantity:
    """The declaration of a number: unit, bounds, axes, letter, if `lift` makes it a symbol, and if it is derived."""

    unit: str
    bounds: Bounds
    shape: tuple[str, ...]
    symbol: str
    is_symbolic: bool
    is_derived: bool = False


def fit_shape(call: str, value: Array, axes: tuple[str, ...], sizes: dict[str, int]) -> Array:
    """The value in its declared shape; one number stands for a vector of equal ones, a vector for a single column."""
    if max(sizes.values(), default=0) > LONGEST:
        raise ValueError(f"`{call}` has at most {LONGEST} numbers; got {sizes}.")
    if axes == ("*",) and value.ndim == 0:
        return np.array(value)
    if len(axes) == 1 and value.ndim == 0 and axes[0] in sizes:
        value = np.full(sizes[axes[0]], float(value))
    if len(axes) == 2 and value.ndim == 1 and sizes.get(axes[1]) == 1:
        value = value[:, np.newaxis]
    if value.ndim == len(axes):
        for axis, size in zip(axes, value.shape, strict=True):
            sizes.setdefault(axis, int(axis) if axis.isdigit() else size)
        if "n" in axes and sizes["n"] == 0:
            raise ValueError(f"`{call}` needs at least one number; got none.")
        if value.shape == tuple(sizes[axis] for axis in axes):
            return np.array(value)
    if axes == ("*",):
        want = " ".join(f"a number or a vector of {sizes.get('*', '')} numbers".split())
    else:
        each = (f"{axis} = {sizes[axis]}" if axis in sizes and not axis.isdigit() else axis for axis in axes)
        want = f"an array of shape ({', '.join(each)})" if axes else "a single number"
    raise ValueError(f"`{call}` must be {want}; got shape {value.shape}.")


def shown_numbers(value: Array) -> str:
    """The numbers of a value for a message, or its shape and range where they are too many for a sentence."""
    if value.ndim == 0:
        return f"{float(value):g}"
    if value.size <= MOST_SHOWN:
        return " ".join(np.array2string(value, separator=", ").split())
    wrong = int((~np.isfinite(value)).sum())
    what = f"{wrong} of them not finite" if wrong else f"from {value.min():g} to {value.max():g}"
    return f"{describe(value)} with numbers {what}"
