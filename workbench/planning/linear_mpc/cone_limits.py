r"""Second-order cones among the limits: as they are named, and as rows of a stage.

A cone |l - c| <= slope a + offset has the rows l and a of a stage. The nearest point of it, with r = |l - c|, is

    a* = (a + slope (r - offset)) / (1 + slope^2),     l* = c + (l - c) (slope a* + offset) / r

from outside, the apex where slope a* + offset < 0, and the point itself from inside (Boyd and Vandenberghe 2004,
exercise 8.3). One penalty for all rows of a cone makes this the step of ADMM. Without a row a it is a ball.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite, known_name, refusal, vector
from workbench.core.validation.signatures import check_arguments

WITHIN = 1 - 2.0**-50  # of the radius of a command: it is inside after rounding
SMALLEST = 1e-15  # size of rows across an axis that is divided by


@dataclass(frozen=True)
@check_arguments
@show
class ConeLimit:
    """The limit |lateral - centre| <= slope axial + offset, with the root of the sum of squares of `lateral`.

    Parameters
    ----------
    lateral
        Names of inputs, or of states, across the axis.
    axial
        Name of the signal along the axis. Without it the limit is a ball of radius `offset`.
    slope
        Tangent of the angle between axis and edge, above zero; 0 for a ball.
    offset
        Radius at axial = 0, in the unit of `lateral`.
    centre
        Values of `lateral` on the axis; zeros by default.

    Raises
    ------
    ValueError
        If a name stands twice, `slope` is not above zero with an axis or not 0 without one, a ball has no radius, or
        `centre` has another size.

    Examples
    --------
    >>> wb.ConeLimit(("T_x", "T_y"), "T_z", slope=0.36).names  # thrust within 20 degrees of the vertical
    ('T_x', 'T_y', 'T_z')
    """

    lateral: tuple[str, ...]
    axial: str = ""
    slope: float = 0.0
    offset: float = 0.0
    centre: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not self.lateral or len(set(self.names)) < len(self.names):
            raise refusal("ConeLimit(lateral=..., axial=...)", "names of signals, each once", self.names)
        slope = finite("ConeLimit(slope=...)", self.slope, low=0.0)
        if bool(self.axial) != (slope > 0):
            must = "above zero, the tangent of an angle" if self.axial else "0 for a ball, which has no axis"
            raise refusal("ConeLimit(slope=...)", must, self.slope)
        offset = finite("ConeLimit(offset=...)", self.offset)
        if not self.axial and not offset > 0:
            raise refusal("ConeLimit(offset=...)", "above zero, the radius of a ball", self.offset)
        if self.centre:
            vector("ConeLimit(centre=...)", self.centre, len(self.lateral), "lateral signals")

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all its signals, the axial one last."""
        return (*self.lateral, self.axial) if self.axial else self.lateral

    @property
    def label(self) -> str:
        """The cone in words."""
        return f"cone of {', '.join(self.lateral)}" + (f" about {self.axial}" if self.axial else "")


def cone_about(cone: ConeLimit, rest: Mapping[str, float]) -> ConeLimit:
    """The cone for deviations from a rest, by names."""
    centre = cone.centre or (0.0,) * len(cone.lateral)
    moved = tuple(value - rest.get(name, 0.0) for name, value in zip(cone.lateral, centre, strict=True))
    return replace(cone, centre=moved, offset=cone.offset + cone.slope * rest.get(cone.axial, 0.0))


@dataclass(frozen=True, eq=False)
@show
class StageCone:
    """A cone among the rows of a stage: |y[lateral] - centre| <= slope y[axial] + offset.

    Parameters
    ----------
    name
        The cone in words.
    lateral, axial
        Places of its rows in a stage; None for the axis of a ball.
    slope, offset, centre
        Numbers, and (m,).
    inputs
        The inputs of these rows if all are inputs, the axial one last; else empty.
    """

    name: str
    lateral: tuple[int, ...]
    axial: int | None
    slope: float
    offset: float
    centre: Array
    inputs: tuple[int, ...] = ()

    @property
    def rows(self) -> tuple[int, ...]:
        """The places of all its rows."""
        return self.lateral if self.axial is None else (*self.lateral, self.axial)

    def about(self, y: Array) -> StageCone:
        """The cone for deviations from rows y (nc,)."""
        along = 0.0 if self.axial is None else float(y[self.axial])
        return replace(self, centre=self.centre - y[list(self.lateral)], offset=float(self.offset + self.slope * along))

    def split(self, y: Array) -> tuple[Array, Array, Array]:
        """Rows l - c (..., m) across the axis, their size (...,), and the radius (...,) there, of rows y (..., nc)."""
        across = y[..., list(self.lateral)] - self.centre
        along = np.zeros(y.shape[:-1]) if self.axial is None else y[..., self.axial]
        return across, np.asarray(np.linalg.norm(across, axis=-1)), self.slope * along + self.offset

    def excess(self, y: Array) -> Array:
        """The distance (...,) of rows y (..., nc) from the cone along l: above zero outside."""
        _, size, radius = self.split(y)
        return size - radius

    def ratio(self, y: Array) -> Array:
        """A bound (...,) of the factor by which deviations y (..., nc) pass the cone: 1 at its edge about a rest."""
        margin = self.offset - float(np.linalg.norm(self.centre))
        along = 0.0 if self.axial is None else y[..., self.axial]
        return np.asarray((np.linalg.norm(y[..., list(self.lateral)], axis=-1) - self.slope * along) / margin)

    def put_nearest(self, y: Array, into: Array) -> None:
        """Write the nearest point of the cone to rows y (..., nc) into `into`."""
        self._put(self.lateral, self.axial, y, into, (-np.inf, np.inf), 1.0)

    def put_input(self, u: Array, low: Array, high: Array) -> None:
        """Move inputs u (..., nu) that keep their limits (nu,) to the nearest that keep the cone, too.

        Lateral inputs are drawn to the axis, which lies within their limits, after the axial one is clipped.
        """
        count = len(self.lateral)
        lateral, axial = self.inputs[:count], self.inputs[-1] if self.axial is not None else None
        ends = (-np.inf, np.inf) if axial is None else (float(low[axial]), float(high[axial]))
        self._put(lateral, axial, u, u, ends, WITHIN)
        across = list(lateral)
        u[..., across] = np.clip(u[..., across], low[across], high[across])

    def _put(
        self,
        lateral: tuple[int, ...],
        axial: int | None,
        y: Array,
        into: Array,
        ends: tuple[float, float],
        share: float,
    ) -> None:
        across = y[..., list(lateral)] - self.centre
        size = np.linalg.norm(across, axis=-1)
        along = np.zeros(y.shape[:-1]) if axial is None else y[..., axial]
        outside = size > self.slope * along + self.offset
        after = (along + self.slope * (size - self.offset)) / (1 + self.slope**2)
        if axial is not None:
            after = np.clip(after, max(ends[0], -self.offset / self.slope), ends[1])
            into[..., axial] = np.where(outside, after, along)
        wide = np.maximum(self.slope * after + self.offset, 0.0) * share
        scale = wide / np.maximum(size, SMALLEST)
        inner = self.centre + across * scale[..., None]
        into[..., list(lateral)] = np.where(outside[..., None], inner, y[..., list(lateral)])


def nearest(cones: Sequence[StageCone], rows_of_stage: int, y: Array, low: Array, high: Array) -> Array:
    """The nearest rows to y (..., M) within the limits (M,) and the cones of each stage."""
    v = np.clip(y, low, high)
    stages, kept = (part.reshape(*y.shape[:-1], -1, rows_of_stage) for part in (y, v))
    for cone in cones:
        cone.put_nearest(stages, kept)
    return np.asarray(kept.reshape(y.shape))


def is_beyond(cones: Sequence[StageCone], rows_of_stage: int, y: Array, low: Array, high: Array) -> Array:
    """True (...,) where rows y (..., M) pass a limit (M,) or a cone of a stage."""
    beyond = ((y < low) | (y > high)).any(axis=-1)
    stages = y.reshape(*y.shape[:-1], -1, rows_of_stage)
    for cone in cones:
        beyond = beyond | (cone.excess(stages) > 0).any(axis=-1)
    return np.asarray(beyond)


def keep_inputs(cones: Sequence[StageCone], u: Array, low: Array, high: Array) -> Array:
    """Inputs (..., nu) within their limits (nu,) and the cones of inputs, near to u, which keeps its limits."""
    for cone in cones:
        if cone.inputs:
            u = u.copy()
            cone.put_input(u, low, high)
    return u


def stage_cones(
    cones: Sequence[ConeLimit], states: tuple[str, ...], inputs: tuple[str, ...], first: int
) -> tuple[tuple[StageCone, ...], Array, Array]:
    """The cones with their rows from place `first` on, and these rows' maps of the states and inputs of a stage.

    The maps are (k, nx), of the next states, and (k, nu). One input may stand in one cone only.
    """
    stages, of_states, of_inputs = [], [], []
    used: set[str] = set()
    for cone in cones:
        for name in cone.names:
            known_name(name, (*states, *inputs), "states and inputs of the plant")
        own = [name for name in cone.names if name in inputs]
        if own and len(own) < len(cone.names):
            raise refusal("ConeLimit(lateral=..., axial=...)", "all inputs, or all states", cone.names)
        if twice := used.intersection(own):
            raise ValueError(
                f"`predictive_design(cones=...)` must have an input in one cone only, so that the command can be moved "
                f"into it; '{min(twice)}' stands in two."
            )
        used.update(own)
        for name in cone.names:
            of_states.append([1.0 if name == other and name not in inputs else 0.0 for other in states])
            of_inputs.append([1.0 if name == other else 0.0 for other in inputs])
        count, end = len(cone.lateral), first + len(cone.names)
        centre = np.array(cone.centre or (0.0,) * count, dtype=float)
        places = tuple(inputs.index(name) for name in own)
        axial = end - 1 if cone.axial else None
        stages.append(
            StageCone(cone.label, tuple(range(first, first + count)), axial, cone.slope, cone.offset, centre, places)
        )
        first = end
    return tuple(stages), np.array(of_states).reshape(-1, len(states)), np.array(of_inputs).reshape(-1, len(inputs))
