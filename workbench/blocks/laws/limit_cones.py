"""The limits of a stage in the graph: rows between their bounds, and second-order cones among them."""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from typing import Protocol

import casadi as ca
import numpy as np

from workbench.core import block, parameter
from workbench.core.block import Matrix, Vector
from workbench.core.units import ANY
from workbench.core.validation.refusals import Array

WITHIN = 1 - 2.0**-50  # of the radius of a command: it is inside after rounding
Ends = tuple[Vector, Vector] | None  # of an axial input
SMALLEST = 1e-30  # square of a size that is divided by


@block
class LimitCone:
    """A cone |y[lateral] - centre| <= slope y[axial] + offset among the rows y of a stage.

    Parameters
    ----------
    lateral, axial
        Places of its rows in a stage; `axial` is -1 for a ball, which has no axis.
    inputs
        The places of these rows among the inputs, the axial one last; empty for a cone of states.
    slope, offset, centre
        Numbers, and (m,), of `planning.StageCone`.
    """

    lateral: tuple[int, ...]
    axial: int
    inputs: tuple[int, ...]
    slope: float = parameter(unit=ANY, low=0)
    offset: float = parameter(unit=ANY)
    centre: Vector = parameter(unit=ANY, shape=("m",))

    def is_passed(self, y: ca.SX) -> ca.SX:
        """1 where the rows y (nc, 1) lie outside."""
        across, along = self._parts(y, self.lateral, self.axial)
        radius = self.slope * along + self.offset
        return ca.logic_or(radius < 0, ca.sumsqr(across) > radius * radius)

    def excess(self, y: ca.SX) -> ca.SX:
        """The distance of rows y (nc, 1) from the cone across its axis, above zero outside."""
        across, along = self._parts(y, self.lateral, self.axial)
        return ca.sqrt(ca.fmax(ca.sumsqr(across), SMALLEST)) - self.slope * along - self.offset

    def nearest(self, y: ca.SX, into: ca.SX) -> ca.SX:
        """The rows `into` (nc, 1), with those of the cone at its nearest point to y (nc, 1)."""
        return self._moved(y, into, self.lateral, self.axial, None, 1.0)

    def keep(self, u: ca.SX, low: Vector, high: Vector) -> ca.SX:
        """The inputs within the cone and their limits (nu, 1) that are near to inputs u (nu, 1) within the limits."""
        if not self.inputs:
            return u
        lateral, axial = (self.inputs, -1) if self.axial < 0 else (self.inputs[:-1], self.inputs[-1])
        ends = None if axial < 0 else (low[axial], high[axial])
        moved = self._moved(u, u, lateral, axial, ends, WITHIN)
        for place in lateral:
            moved[place] = ca.fmin(ca.fmax(moved[place], low[place]), high[place])
        return moved

    def _parts(self, y: ca.SX, lateral: tuple[int, ...], axial: int) -> tuple[ca.SX, ca.SX]:
        return ca.vertcat(*(y[place] for place in lateral)) - self.centre, ca.SX(0.0) if axial < 0 else y[axial]

    def _moved(self, y: ca.SX, into: ca.SX, lateral: tuple[int, ...], axial: int, ends: Ends, share: float) -> ca.SX:
        across, along = self._parts(y, lateral, axial)
        size = ca.sqrt(ca.fmax(ca.sumsqr(across), SMALLEST))
        outside = size > self.slope * along + self.offset
        after = (along + self.slope * (size - self.offset)) / (1 + self.slope * self.slope)
        moved = ca.SX(into)
        if axial >= 0:
            after = ca.fmax(after, -self.offset / self.slope)
            after = after if ends is None else ca.fmin(ca.fmax(after, ends[0]), ends[1])
            moved[axial] = ca.if_else(outside, after, along)
        scale = ca.fmax(self.slope * after + self.offset, 0.0) * share / size
        for i, place in enumerate(lateral):
            moved[place] = ca.if_else(outside, self.centre[i] + across[i] * scale, y[place])
        return moved


class RowLimits(Protocol):
    """The limits of the rows of a stage, as a predictive law declares them."""

    @property
    def low(self) -> Vector: ...
    @property
    def high(self) -> Vector: ...
    @property
    def K(self) -> Matrix: ...
    @property
    def cones(self) -> tuple[LimitCone, ...]: ...


def within_limits(law: RowLimits, y: ca.SX) -> ca.SX:
    """The nearest rows to y (nc, 1) within the limits and the cones of a stage."""
    v = ca.fmin(ca.fmax(y, law.low), law.high)
    for cone in law.cones:
        v = cone.nearest(y, v)
    return v


def passes_limits(law: RowLimits, y: ca.SX) -> ca.SX:
    """1 if a row of y (nc, 1) passes a limit, or lies outside of a cone."""
    rows = ca.vertsplit(ca.logic_or(y < law.low, y > law.high))
    return ca.SX(reduce(ca.logic_or, (*rows, *(cone.is_passed(y) for cone in law.cones))))


def inputs_within_limits(law: RowLimits, v: ca.SX) -> ca.SX:
    """Inputs within the limits and the cones of inputs, near to inputs v (nu, 1)."""
    nu = law.K.shape[0]
    low, high = law.low[:nu], law.high[:nu]
    u = ca.fmin(ca.fmax(v, low), high)
    for cone in law.cones:
        u = cone.keep(u, low, high)
    return u


class DesignedCone(Protocol):
    """A cone of a design, `planning.StageCone`."""

    name: str
    lateral: tuple[int, ...]
    axial: int | None
    inputs: tuple[int, ...]
    slope: float
    offset: float
    centre: Array


def cones_of(cones: Iterable[DesignedCone], safe: Array | None) -> tuple[LimitCone, ...]:
    """The cones of a design as parts of its law; a safe command (nu,) about the rest that leaves one is refused."""
    made = []
    for cone in cones:
        axial = -1 if cone.axial is None else cone.axial
        made.append(LimitCone(cone.lateral, axial, cone.inputs, cone.slope, cone.offset, cone.centre))
        if safe is None or not cone.inputs:
            continue
        values = safe[list(cone.inputs)]
        along = 0.0 if cone.axial is None else float(values[-1])
        across = float(np.linalg.norm(values[: len(cone.lateral)] - cone.centre))
        over = across - cone.slope * along - cone.offset
        if over > 0:
            raise ValueError(
                f"`ModelPredictive.of(safe_command=...)` must keep the {cone.name}; it lies {over:.4g} outside."
            )
    return tuple(made)
