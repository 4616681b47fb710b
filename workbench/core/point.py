"""Point: the numbers about which a linear system is linear, with their names and units, and what rests there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from workbench.core.layout import Entry, Layout
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments

# A rate counts as zero below this share of the terms that could have made it: rounding of some thousand operations
# is 1e-13 of them, and a state printed to nine digits leaves 1e-9.
AT_REST = 1e-8


@dataclass(frozen=True, eq=False)
@show
@check_arguments
class OperatingPoint:
    """The states x0 (nx,), inputs u0 (nu,) and outputs y0 (ny,) from which a linear system counts its own.

    The layouts have their names and units. `moving_state` says which state does not rest there, and is empty at a rest
    point.
    """

    states: Layout
    inputs: Layout
    outputs: Layout
    x0: Array
    u0: Array
    y0: Array
    moving_state: str = ""

    def part(self, outputs: Sequence[int], inputs: Sequence[int]) -> OperatingPoint:
        """The same point with some outputs and inputs alone, by their places."""
        return replace(
            self,
            inputs=_part(self.inputs, inputs),
            outputs=_part(self.outputs, outputs),
            u0=self.u0[list(inputs)],
            y0=self.y0[list(outputs)],
        )

    def of_controller(self, states: Layout) -> OperatingPoint:
        """The point of a controller from the outputs y to the inputs u of a system, with states that are zero there."""
        return OperatingPoint(
            states, self.outputs, self.inputs, np.zeros(states.size), self.y0, self.u0, self.moving_state
        )

    def of_compensator(self) -> OperatingPoint:
        """The point of a compensator from the error of y, which is zero there, to u."""
        point = self.of_controller(Layout())
        return replace(point, u0=np.zeros(point.inputs.size))


def _part(port: Layout, places: Sequence[int]) -> Layout:
    if list(places) == list(range(port.size)):
        return port
    numbers = [
        Entry(label, np.zeros(()), unit) for e in port.entries for label, unit in zip(_labels(e), e.units, strict=True)
    ]
    return Layout(tuple(numbers[place] for place in places))


def _labels(entry: Entry) -> list[str]:
    return list(entry.labels()) if entry.size > 1 else [entry.name]


@final
class PointedGain(np.ndarray):
    """A gain K (nu, nx) about a `point`, which a multiple of it has too, and a matrix of another shape has not."""

    _point: OperatingPoint | None

    @staticmethod
    def of(K: Array, point: OperatingPoint | None) -> Array:
        """The gain about a point; the matrix as it is if there is none."""
        if point is None:
            return K
        gain = np.array(K).view(PointedGain)
        gain._point = point
        return gain

    def __array_finalize__(self, source: object) -> None:
        self._point = getattr(source, "_point", None)

    @property
    def point(self) -> OperatingPoint | None:
        """The point, or None if this is no matrix from its states to its inputs."""
        point = self._point
        return point if point is not None and self.shape == (len(point.u0), len(point.x0)) else None

    def __repr__(self) -> str:
        return repr(np.asarray(self))


def gain_of(design: object) -> tuple[object, OperatingPoint | None]:
    """The gain K of a design or K itself, as a plain matrix, and the point that it is about, if it has one."""
    K = getattr(design, "K", design)
    point = getattr(design, "point", None) or getattr(K, "point", None)
    return np.asarray(K) if isinstance(K, PointedGain) else K, point if isinstance(point, OperatingPoint) else None


def rate_terms(A: Array, x: Array) -> Array:
    """A scale for each rate, (nx,): |A| (1 + |x|) + 1, the size of its terms at a state of order one or larger."""
    return np.asarray(np.abs(A) @ (1 + np.abs(x)) + 1)
