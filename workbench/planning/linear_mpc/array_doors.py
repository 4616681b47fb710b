"""The doors of arrays that come in each period: of the right size, and finite."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array, numbers, refusal, vector

LARGEST = 1e100  # whose squares are still numbers


def finite_vector(call: str, value: object, size: int, of: str) -> Array:
    """Finite numbers (size,), none above 1e100."""
    array = vector(call, value, size, of)
    if not (np.abs(array) <= LARGEST).all():
        raise refusal(call, f"{size} finite {of}, none above 1e100", value)
    return array


def finite_batch(call: str, value: object, size: int, of: str) -> Array:
    """Finite numbers (..., size), none above 1e100."""
    array = numbers(call, value)
    if array.ndim == 0 or array.shape[-1] != size or not (np.abs(array) <= LARGEST).all():
        raise refusal(call, f"finite {of} of shape (..., {size}), none above 1e100", value)
    return array
