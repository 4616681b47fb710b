"""Numbers as they come from outside, and what they may be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from workbench.validation.doors import door
from workbench.validation.words import Array

ROUNDING = 1e-12  # how far rounding may take a matrix from symmetry, in units of its largest entry
LONGEST = 1_000_000  # entries of one axis of a number


def numbers(value: Any) -> Array:
    """The value as a new float array; None and text are refused (TypeError), as are ragged lists (ValueError)."""
    array = np.array(value)
    if array.dtype.kind not in "biuf":
        raise TypeError(array.dtype)
    return array.astype(float)


@dataclass(frozen=True)
@door
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
        if not self.low <= self.high:
            raise ValueError(f"`Bounds(low=..., high=...)` must keep low <= high; got {self.low:g} and {self.high:g}.")
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

    @door
    def allow(self, value: Array) -> Array:
        """Elementwise: whether each number is finite and within the bounds (booleans)."""
        inside = (
            (value > self.low) & (value < self.high) if self.strict else ((value >= self.low) & (value <= self.high))
        )
        return np.asarray(np.isfinite(value) & inside)


def shaped(call: str, value: Array, axes: tuple[str, ...], sizes: dict[str, int]) -> Array:
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
            raise ValueError(f"`{call}` needs at least one joint, and a number for each; got none.")
        if value.shape == tuple(sizes[axis] for axis in axes):
            return np.array(value)
    known = (axis in sizes and not axis.isdigit() for axis in axes)
    each = ", ".join(f"{axis} = {sizes[axis]}" if k else axis for axis, k in zip(axes, known, strict=True))
    want = f"an array of shape ({each})" if axes else "a single number"
    if axes == ("*",):
        want = f"a number or a vector of {sizes.get('*', '')} numbers".replace("  ", " ")
    raise ValueError(f"`{call}` must be {want}; got shape {value.shape}.")


def refuse_unsymmetric(name: str, definite: str, matrices: Array) -> None:
    """Refuse, by its run and entry, a matrix of (B, n, n) that is not symmetric, or not as definite as it must be."""
    odd = np.argwhere(np.abs(matrices - np.swapaxes(matrices, -1, -2)) > ROUNDING * np.abs(matrices).max(initial=0.0))
    if len(odd):
        run, i, j = odd[0]
        raise ValueError(
            f"'{name}' must be symmetric; got {matrices[run, i, j]:g} at [{i},{j}] and {matrices[run, j, i]:g} at "
            f"[{j},{i}]: set both."
        )
    if not definite:
        return
    smallest = np.linalg.eigvalsh(matrices).min(axis=-1)
    size = np.abs(matrices).max(axis=(-2, -1))
    low = np.flatnonzero(smallest <= 0 if definite == "positive" else smallest < -ROUNDING * size)
    if len(low):
        where = f" in run {low[0]}" if len(matrices) > 1 else ""
        raise ValueError(
            f"'{name}' must be positive {'definite' if definite == 'positive' else 'semidefinite'}; "
            f"got a smallest eigenvalue of {smallest[low[0]]:.3g}{where}."
        )
