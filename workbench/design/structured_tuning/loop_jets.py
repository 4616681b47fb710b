"""The matrices of a loop, closed and cut, with their derivatives by some of its parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.validation.refusals import Array
from workbench.design.linear_loop import LinearLoop
from workbench.design.linear_loop.loop_equations import labels_of
from workbench.design.linear_loop.loop_model import LoopModel
from workbench.design.linear_loop.loop_point import opened_rows
from workbench.design.linear_loop.rest_state import find_rest, resting_states
from workbench.design.structured_tuning.system_jets import SystemJet

STEP = 1e-5  # of a range: of a central difference
ROUNDS, AT_REST = 20, 1e-10  # Newton steps towards the rest, and the relative length of one that counts for nothing


@dataclass(frozen=True, eq=False)
class LoopJet:
    """A loop at a point: closed, and cut at all drives, with the names of its signals and the places of the cut."""

    closed_loop: SystemJet
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    cut_loop: SystemJet | None
    channels: tuple[int, ...]
    drives: int

    def part(self, inputs: Sequence[str], outputs: Sequence[str]) -> SystemJet:
        """The closed loop from some of its inputs to some of its outputs, by name."""
        return self.closed_loop.part(
            [i for i, name in enumerate(self.outputs) if _named(name, outputs)],
            [j for j, name in enumerate(self.inputs) if _named(name, inputs)],
        )

    def loop_gain(self, channels: Sequence[int] | None = None) -> SystemJet:
        """L at some channels of the cut, all by default, while the loop is closed at the other drives."""
        assert self.cut_loop is not None
        own = self.channels if channels is None else [self.channels[k] for k in channels]
        rest = [i for i in range(self.drives) if i not in own]
        every = self.cut_loop.part(range(self.drives), range(self.drives)).closed_at(rest)
        return every.part(own, range(len(own))).negative()


def _named(label: str, names: Sequence[str]) -> bool:
    return any(name in (label, label.partition("[")[0]) for name in names)


@dataclass(frozen=True, eq=False)
class LoopJets:
    """The jets of a linear loop by d numbers, each of which moves the parameters at its `places` by its `factors`.

    In continuous time the derivatives are exact, those of the rest included. Those of a loop in a computer are central
    differences of its map over a period, over a small part of the ranges `low` to `high` (d,).
    """

    linear: LinearLoop
    places: tuple[tuple[int, ...], ...]
    factors: tuple[tuple[float, ...], ...]
    low: Array
    high: Array

    def parameters(self, numbers: Array) -> Array:
        """The parameters (np,) of the closed loop with the numbers (d,) in their places."""
        p = self.linear.p0.copy()
        for number, places, factors in zip(numbers, self.places, self.factors, strict=True):
            p[list(places)] = number * np.array(factors)
        return p

    def __call__(self, numbers: Array) -> LoopJet:
        """The loop at numbers (d,)."""
        closed, opened = (
            self._exact(numbers) if isinstance(self.linear.point.equations.closed_loop, Ode) else self._rows(numbers)
        )
        models = self.linear.models
        model, cut = models.closed_model, models.open_model
        own = None if cut is None else opened
        return LoopJet(closed, model.inputs, model.outputs, own, models.channels, len(models.delays))

    def _exact(self, numbers: Array) -> tuple[SystemJet, SystemJet | None]:
        p = self.parameters(numbers)
        closed, cut = self._functions
        x, moved = self._rest(p)
        slope = np.vstack([moved, self._directions])
        output = closed.output(x, p)
        closed_jet = closed.jet(x, p, slope)
        if cut is None:
            return closed_jet, None
        equations = self.linear.point.equations
        assert equations.open_loop is not None
        row = opened_rows(equations, p[np.newaxis], output[np.newaxis])[0]
        turned = opened_rows(equations, self._directions.T, (closed.output_slopes(x, p) @ slope).T).T
        turned[self._constant_rows] = 0.0
        return closed_jet, cut.jet(x, row, np.vstack([moved, turned]))

    @cached_property
    def _directions(self) -> Array:
        """The derivatives (np, d) of the parameters by the numbers."""
        directions = np.zeros((self.linear.p0.size, len(self.places)))
        for k, (places, factors) in enumerate(zip(self.places, self.factors, strict=True)):
            directions[list(places), k] = factors
        return directions

    @cached_property
    def _constant_rows(self) -> list[int]:
        """The places of the parameters of the cut loop that the closed one does not have, but for its drives."""
        equations = self.linear.point.equations
        assert equations.open_loop is not None
        opened, closed = equations.open_loop.parameters, equations.closed_loop.parameters
        own = [entry.name for entry in opened.entries if entry.name not in closed and entry.name != "drive"]
        return [i for name in own for i in opened.indices(name)]

    @cached_property
    def _functions(self) -> tuple[_EquationJets, _EquationJets | None]:
        point, models = self.linear.point, self.linear.models
        closed, cut = point.equations.closed_loop, point.equations.open_loop
        assert isinstance(closed, Ode)
        first = _EquationJets(closed, point.instant.t, models.closed_model.outputs)
        if not isinstance(cut, Ode) or models.open_model is None:
            return first, None
        return first, _EquationJets(cut, point.instant.t, models.open_model.outputs)

    def _rest(self, p: Array) -> tuple[Array, Array]:
        """The states (nx,) at which the loop rests, and their derivatives (nx, d) by the numbers."""
        x, free, closed = self.linear.x0.copy(), self._free, self._functions[0]
        moved = np.zeros((len(x), len(self.places)))
        if not len(free) or not self.linear.point.at_rest:
            return x, moved
        for _ in range(ROUNDS):
            rate, slopes = closed.motion(x, p)
            step = np.linalg.lstsq(slopes[:, : len(x)][np.ix_(free, free)], -rate[free], rcond=1e-12)[0]
            if not np.isfinite(step).all() or np.abs(step).max() <= AT_REST * (1 + np.abs(x[free]).max()):
                break
            x[free] += step
        _, slopes = closed.motion(x, p)
        by_numbers = slopes[:, len(x) :] @ self._directions
        moved[free] = np.linalg.lstsq(slopes[:, : len(x)][np.ix_(free, free)], -by_numbers[free], rcond=1e-12)[0]
        return x, moved

    @cached_property
    def _free(self) -> list[int]:
        point = self.linear.point
        must = resting_states(point.equations.closed_loop, point.equations.ports)
        return [int(i) for i in np.flatnonzero(must) if i not in point.kept_states]

    def _rows(self, numbers: Array) -> tuple[SystemJet, SystemJet | None]:
        """The map over a period at the numbers, and its central differences, all by one call of the kernel."""
        d, point, models = len(numbers), self.linear.point, self.linear.models
        steps = STEP * (self.high - self.low)
        ahead, behind = np.minimum(numbers + steps, self.high), np.maximum(numbers - steps, self.low)
        each = np.tile(numbers, (2 * d + 1, 1))
        each[np.arange(d) + 1, np.arange(d)], each[np.arange(d) + 1 + d, np.arange(d)] = ahead, behind
        p = np.array([self.parameters(row) for row in each])
        x = np.tile(self.linear.x0, (len(p), 1))
        made, cut = point.row_models
        if point.at_rest:
            must = resting_states(point.equations.closed_loop, point.equations.ports)
            x, _ = find_rest(made.motion, x, p, must, list(point.kept_states), True)
        closed, output, _ = made.model(x, p)
        keep = [closed.states.index(name) for name in models.closed_model.states]
        first = _differences(closed, keep, models.closed_model.outputs, ahead - behind)
        if cut is None or models.open_model is None:
            return first, None
        opened, _, _ = cut.model(x, opened_rows(point.equations, p, output))
        keep = [opened.states.index(name) for name in models.open_model.states]
        return first, _differences(opened, keep, models.open_model.outputs, ahead - behind)


def _differences(model: LoopModel, keep: list[int], outputs: tuple[str, ...], widths: Array) -> SystemJet:
    rows = [model.outputs.index(name) for name in outputs]
    A, B = model.A[:, keep][:, :, keep], model.B[:, keep]
    whole = np.concatenate(
        [np.concatenate([A, B], axis=2), np.concatenate([model.Cy[:, rows][:, :, keep], model.D[:, rows]], axis=2)],
        axis=1,
    )
    d = len(widths)
    slopes = (whole[1 : d + 1] - whole[d + 1 :]) / widths[:, np.newaxis, np.newaxis]
    return SystemJet(whole[0], slopes, len(keep), model.period)


@dataclass(frozen=True, eq=False)
class _EquationJets:
    """The Jacobians of equations at a time, and their derivatives by states and parameters."""

    ode: Ode
    t: float
    outputs: tuple[str, ...]

    def jet(self, x: Array, p: Array, slope: Array) -> SystemJet:
        """The matrices at a state and parameters that move by `slope` (nx + np, d) with the numbers."""
        M, J = self._matrices(self.t, x, p)
        matrix = np.array(M)
        moved = J.sparse() @ slope
        slopes = np.asarray(moved).T.reshape(slope.shape[1], matrix.shape[1], matrix.shape[0]).swapaxes(1, 2)
        n = self.ode.states.size
        labels = labels_of(self.ode.outputs)
        rows = [*range(n), *(n + labels.index(name) for name in self.outputs)]
        return SystemJet(matrix[rows], slopes[:, rows], n)

    def motion(self, x: Array, p: Array) -> tuple[Array, Array]:
        """The rate (nx,) and its derivatives (nx, nx + np)."""
        rate, slopes = self._motion(self.t, x, p)
        return np.array(rate).ravel(), np.array(slopes)

    def output(self, x: Array, p: Array) -> Array:
        """The outputs (ny,)."""
        return np.array(self.ode.h(self.t, x, p)).ravel()

    def output_slopes(self, x: Array, p: Array) -> Array:
        """The derivatives (ny, nx + np) of the outputs."""
        return np.array(self._output_slopes(self.t, x, p))

    @cached_property
    def _symbols(self) -> tuple[ca.SX, ca.SX]:
        return ca.vertcat(self.ode.x, self.ode.input_symbols), ca.vertcat(self.ode.x, self.ode.p)

    @cached_property
    def _matrices(self) -> ca.Function:
        z, w = self._symbols
        both = ca.densify(ca.vertcat(self.ode.rate, self.ode.output))
        M = ca.densify(ca.jacobian(both, z))
        return ca.Function("matrices", [self.ode.t, self.ode.x, self.ode.p], [M, ca.jacobian(ca.vec(M), w)])

    @cached_property
    def _motion(self) -> ca.Function:
        rate = ca.densify(self.ode.rate)
        slopes = ca.densify(ca.jacobian(rate, self._symbols[1]))
        return ca.Function("motion", [self.ode.t, self.ode.x, self.ode.p], [rate, slopes])

    @cached_property
    def _output_slopes(self) -> ca.Function:
        slopes = ca.densify(ca.jacobian(ca.densify(self.ode.output), self._symbols[1]))
        return ca.Function("outputs", [self.ode.t, self.ode.x, self.ode.p], [slopes])
