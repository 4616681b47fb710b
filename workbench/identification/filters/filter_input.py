"""The arguments of filters: samples, matrices and covariances, each refused in one sentence where it does not fit."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array, as_array, describe, vector
from workbench.design.matrices import EPS, symmetric
from workbench.design.matrices import definite as positive_definite


def samples(call: str, y: Array) -> Array:
    """Samples (N, q), NaN where a sensor has none."""
    array = as_array(y)
    array = array[:, None] if array is not None and array.ndim == 1 else array
    if array is None or array.ndim != 2 or not array.size or np.isinf(array).any():
        raise ValueError(
            f"`{call}(y=...)` must be samples (N, q) of q sensors, NaN where a sensor has none; got {describe(y)}."
        )
    return array


def times(call: str, t: Array | None, N: int) -> Array:
    """The times (N,) of samples, by default their numbers; they must increase."""
    if t is None:
        return np.arange(N, dtype=float)
    array = vector(f"{call}(t=...)", t, N, "samples")
    if not np.isfinite(array).all() or (np.diff(array) <= 0).any():
        k = int(np.argmin(np.isfinite(array[1:]) & (np.diff(array) > 0))) + 1
        raise ValueError(
            f"`{call}(t=...)` must be times that increase; t[{k - 1}] is {array[k - 1]:g} s and t[{k}] is "
            f"{array[k]:g} s: sort the samples, and merge those of one time."
        )
    return array


def matrices(call: str, name: str, value: Array, N: int, shape: tuple[int, int] | None = None) -> Array:
    """Finite matrices (N, rows, columns), of one matrix (rows, columns) that is the same for all samples or of N."""
    array = as_array(value)
    square = "" if shape else "square "
    if array is None or array.ndim not in (2, 3) or not array.size:
        raise ValueError(f"`{call}({name}=...)` must be a {square}matrix, or {N} of them; got {describe(value)}.")
    want = shape or (array.shape[-1], array.shape[-1])
    if array.shape not in (want, (N, *want)):
        raise ValueError(
            f"`{call}({name}=...)` must have shape {want}, or {(N, *want)} for {N} samples; got {array.shape}."
        )
    if not np.isfinite(array).all():
        raise ValueError(
            f"`{call}({name}=...)` must hold finite numbers; {name}{np.argwhere(~np.isfinite(array))[0].tolist()} is "
            "none."
        )
    return np.broadcast_to(np.ascontiguousarray(array), (N, *want))


def covariance(call: str, name: str, value: Array | None, n: int, definite: bool = False) -> Array:
    """A covariance (n, n), positive semidefinite, or definite if it must be."""
    if value is None:
        raise ValueError(
            f"`{call}({name}=...)` must be given, as an array ({n}, {n}): how far the initial state may be from `x0`; "
            "of a state that nobody knows, take the square of the largest value that it may have."
        )
    array = as_array(value)
    if array is None or array.shape != (n, n):
        got = describe(value) if array is None else array.shape
        raise ValueError(f"`{call}({name}=...)` must have shape ({n}, {n}); got {got}.")
    if definite:
        return positive_definite(f"{call}({name}=...)", name, array, n)
    P = symmetric(f"{call}({name}=...)", name, array, n)
    deviations = np.sqrt(np.maximum(np.diag(P), 0.0))
    scale = np.where(deviations > 0, deviations, 1.0)
    least = float(np.linalg.eigvalsh(P / scale[:, None] / scale)[0])
    if least < -8 * n * EPS or (np.diag(P) < 0).any():
        raise ValueError(
            f"`{call}({name}=...)` must be positive semidefinite, as a covariance is; the least eigenvalue of its "
            f"matrix of correlations is {least:.3g}."
        )
    return P


def initial_mean(call: str, x0: Array | None, n: int) -> Array:
    """The mean (n,) of the state before the first sample."""
    if x0 is None:
        raise ValueError(
            f"`{call}(x0=...)` must be given, as {n} numbers: the mean of the state before the first sample; for one "
            "that nobody knows, take 0 and a large `P0`."
        )
    mean = vector(f"{call}(x0=...)", x0, n, "states")
    if not np.isfinite(mean).all():
        k = int(np.argmin(np.isfinite(mean)))
        raise ValueError(
            f"`{call}(x0=...)` must be finite numbers; x0[{k}] is {mean[k]}: for a state that nobody knows, take 0 "
            "and a large `P0`."
        )
    return mean
