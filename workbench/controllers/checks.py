"""What the laws ask of the numbers they are given, beyond bounds and shapes."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.core import Entry
from workbench.core.numbers import ROUNDING, Bounds
from workbench.validation.refusals import Array, as_array, refusal


def gains_that_start_at(law: str, K: Array, unit: str) -> Entry:
    """The memory entry of switching gains K (n,) in that unit, refused where one of them starts below zero."""
    if np.any(K < 0):
        raise ValueError(
            f"`{law}(K=...)` must not be negative: K_i sat(s_i / phi) with K_i < 0 drives s_i away from "
            f"zero. Got {np.array2string(K, separator=', ')}."
        )
    return Entry("K", K, unit, Bounds(low=0), "K")


def symmetric(call: str, X: Array, why: str, definite: bool) -> None:
    """Refuse X (n, n) unless it is symmetric and positive definite (or semidefinite), and say why."""
    size = float(np.abs(X).max(initial=0.0))
    word = "definite" if definite else "semidefinite"
    if np.abs(X - X.T).max(initial=0.0) > ROUNDING * size:
        raise ValueError(f"`{call}` must be symmetric: {why}. Got {np.array2string(X, separator=', ')}.")
    smallest = float(np.linalg.eigvalsh(X).min())
    if smallest <= 0 if definite else smallest < -ROUNDING * size:
        raise ValueError(f"`{call}` must be positive {word}: {why}. Its smallest eigenvalue is {smallest:.3g}.")


def halves(call: str, K: Any, dof: int, rows: int) -> tuple[Array, Array]:
    """The gains of e and of ed from K (..., rows, 2n), or a refusal."""
    gain = as_array(K)
    if gain is None:
        raise refusal(call, "a matrix of numbers", K)
    if gain.ndim < 2 or gain.shape[-2:] != (rows, 2 * dof):
        count = f"{rows} row{'s' if rows > 1 else ''}, one a {'joint' if rows == dof else 'motor'}"
        raise ValueError(f"`{call}` must have {count}, and {2 * dof} columns, for [e; ed]; got shape {gain.shape}.")
    return gain[..., :dof], gain[..., dof:]
