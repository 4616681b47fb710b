"""Directions of the unknown numbers in which the outputs do not change: what an experiment cannot tell."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments

RANK = 1e-7  # of singular values, relative to the largest: far above rounding, and below what noise leaves of use
AS_ZERO = 1e-9  # of a number, in its unit: it has no size of its own
PART = 1e-3  # the least entry of a number in a direction of unit length


@dataclass(frozen=True, eq=False)
@check_arguments
class Identifiability:
    """Which of some unknown numbers can be told from the outputs of an experiment, near given values.

    The derivatives of the outputs by the numbers, each in units of its own size, have singular values. A singular value
    that is zero has a direction in which the numbers can change together without any change of the outputs.

    Parameters
    ----------
    names
        The nz unknown numbers.
    values
        (nz,), their values.
    sizes
        (nz,), the units in which they change: their values, or 1 where these are zero.
    singular_values
        (nz,), from the largest to the least.
    directions
        (nz, nz), the directions that belong to them, row by row.

    References
    ----------
    Walter and Pronzato (1997), Identification of Parametric Models, section 2.6 (local identifiability).
    Miao, Xia, Perelson and Wu (2011), SIAM Review 53(1), section 5 (sensitivity-based analysis).
    """

    names: tuple[str, ...]
    values: Array
    sizes: Array
    singular_values: Array
    directions: Array

    def __post_init__(self) -> None:
        nz = len(self.names)
        shapes = {"values": (nz,), "sizes": (nz,), "singular_values": (nz,), "directions": (nz, nz)}
        for name, shape in shapes.items():
            if (got := np.shape(getattr(self, name))) != shape:
                raise ValueError(f"`Identifiability({name}=...)` must have the shape {shape}; got {got}.")

    @staticmethod
    @check_arguments
    def of(names: tuple[str, ...], values: Array, derivatives: Array, starts: Array | None = None) -> Identifiability:
        """From the derivatives (M, nz) of all weighted outputs.

        The size of a number is its value, or its value at the `starts` (nz,) of a search if that is larger.
        """
        sizes = np.maximum(np.abs(values), np.abs(values if starts is None else starts))
        sizes = np.where(sizes < AS_ZERO, 1.0, sizes)
        if derivatives.ndim != 2 or not derivatives.shape[1] == len(sizes) == len(names):
            raise ValueError(
                f"`Identifiability.of(derivatives=...)` must have the shape (M, {len(names)}), a column for each name; "
                f"got {derivatives.shape} for {np.size(values)} values."
            )
        _, singular, directions = np.linalg.svd(_at_least_square(derivatives * sizes), full_matrices=False)
        return Identifiability(names, values, sizes, singular, directions)

    @cached_property
    def dimension(self) -> int:
        """The number of independent directions in which the outputs do not change."""
        largest = float(self.singular_values.max(initial=0.0))
        return int(np.sum(self.singular_values <= RANK * largest)) if largest > 0 else len(self.names)

    @property
    def is_complete(self) -> bool:
        """True if all numbers can be told."""
        return self.dimension == 0

    @property
    def null_directions(self) -> Array:
        """(dimension, nz), an orthonormal basis of the directions that change nothing, in units of `sizes`."""
        return self.directions[len(self.names) - self.dimension :]

    @property
    def ambiguous_names(self) -> tuple[str, ...]:
        """The numbers that take part in a direction that changes nothing."""
        parts = np.linalg.norm(self.null_directions, axis=0)
        return tuple(name for name, part in zip(self.names, parts, strict=True) if part > PART)

    @property
    def sentences(self) -> tuple[str, ...]:
        """A sentence for each direction: by how many per cent each number changes together with the others."""
        return tuple(map(self._sentence, _sparse_basis(self.null_directions)))

    def _sentence(self, direction: Array) -> str:
        places = np.flatnonzero(np.abs(direction) > PART * np.max(np.abs(direction))).tolist()
        if len(places) == 1:
            return f"No output changes if {self.names[places[0]]} changes alone."
        changes, values = direction * self.sizes, np.abs(self.values)
        first = places[0]  # which changes by 1 %, or by 0.01 if it is zero
        changes = 0.01 * changes / changes[first] * (values[first] if values[first] >= AS_ZERO else 1.0)
        moves = [
            f"{self.names[i]} by {100 * changes[i] / values[i]:+.3g} %"
            if values[i] >= AS_ZERO
            else f"{self.names[i]} by {changes[i]:+.3g}"
            for i in places
        ]
        return f"No output changes if these change at once: {', '.join(moves)}."


def _at_least_square(matrix: Array) -> Array:
    """The matrix with rows of zeros where it has fewer rows than columns, so that every column has a singular value."""
    missing = max(0, matrix.shape[1] - matrix.shape[0])
    return np.vstack([matrix, np.zeros((missing, matrix.shape[1]))])


def _sparse_basis(directions: Array) -> Array:
    """The reduced row echelon form of some directions: the same for every basis of them, up to rounding."""
    rows, place = directions.copy(), 0
    for column in range(rows.shape[1]):
        if place == len(rows):
            break
        best = place + int(np.argmax(np.abs(rows[place:, column])))
        if abs(rows[best, column]) <= PART:
            continue
        rows[[place, best]] = rows[[best, place]]
        rows[place] /= rows[place, column]
        others = np.arange(len(rows)) != place
        rows[others] -= np.outer(rows[others, column], rows[place])
        place += 1
    return rows
