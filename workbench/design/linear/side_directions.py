"""Directions to the sides of switching surfaces, and the texts of switching functions."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import Array

MOST_CROSSED = 6  # surfaces whose sides are all combined, 64 pieces
MORE_DIRECTIONS = 16  # other directions
LONGEST = 60  # letters of an expression in a message
COMPARISON_TEXTS = {"LT": "{} < {}", "LE": "{} <= {}"}


def side_directions(slopes: Array) -> list[Array]:
    """Directions in scaled x and u, each at most 1 in size: to all sides of the surfaces, as far as there are such."""
    n = slopes.shape[1]
    found = [sign * axis for axis in np.eye(n) for sign in (1, -1)]
    if len(slopes) <= MOST_CROSSED:
        inverse = np.linalg.pinv(slopes / np.maximum(np.abs(slopes).max(axis=1, keepdims=True), 1e-300))
        found = [inverse @ np.array(signs) for signs in product((1, -1), repeat=len(slopes))] + found
    found += [np.cos(k * np.arange(1.0, n + 1)) for k in range(1, MORE_DIRECTIONS)]
    found += [-direction for direction in found[-MORE_DIRECTIONS + 1 :]]
    return [direction / np.abs(direction).max() for direction in found if direction.any()]


def switching_text(name: str, a: Sequence[ca.SX]) -> str:
    """The text of a switching function, with dots in the place of long operands."""
    parts = [text if len(text := str(part)) <= LONGEST else "..." for part in a]
    if parts == ["..."] * len(parts):
        parts[0] = f"{str(a[0]).rpartition(', ')[2][:LONGEST]}..."
    form = COMPARISON_TEXTS.get(name)
    return form.format(*parts) if form else f"{name.lower()}({', '.join(parts)})"
