"""The states and inputs that a nonlinear plan wants at its stages: a rest, a reference, or a previewed one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.blocks.laws.plan_window import planned_signals
from workbench.blocks.loop.contracts import AbstractPlant
from workbench.blocks.loop.environment import AbstractReference
from workbench.blocks.loop.wiring import call_block
from workbench.blocks.signals.planned_reference import PlannedReference
from workbench.core import Entry, Layout
from workbench.core.block import Vector
from workbench.core.units import ANY

WINDOW = "window"


@dataclass(frozen=True)
class PlanTargets:
    """The states and inputs that the stages of a plan want.

    Parameters
    ----------
    model
        The plant.
    rest
        The states (nx,) and inputs (nu,) of the rest.
    port
        The signals of the reference.
    preview
        The reference that is previewed; None for one that holds along the plan.
    period
        The length of a stage in s.
    delay
        The number of periods until an input acts.
    last_inputs
        The number of last inputs that stand behind the states of the plant: `delay`, or 1 with limits of changes.
    """

    model: AbstractPlant
    rest: tuple[Vector, Vector]
    port: Layout
    preview: AbstractReference | None
    period: float
    delay: int
    last_inputs: int

    def memory(self, horizon: int) -> tuple[Entry, ...]:
        """The signals of a `PlannedReference` at the stages from t = 0 on, as each of its pieces costs anew."""
        if not isinstance(self.preview, PlannedReference):
            return ()
        t = ca.SX.sym("t")
        at = ca.Function("at", [t], [self.preview_at(t)])
        first = np.hstack([np.array(at(k * self.period)) for k in range(horizon + 1)])
        return (Entry(WINDOW, first.ravel(order="F"), ANY),)

    def next_window(self, t: ca.SX, window: ca.SX, horizon: int) -> ca.SX:
        """The window of the next period."""
        newest = self.preview_at(t + (horizon + 1) * self.period)
        return ca.vertcat(window[newest.numel() :], newest)

    def preview_at(self, t: ca.SX) -> ca.SX:
        """The signals of the previewed reference at a time, and its inputs in the periods of the delay, as a column."""
        later = [self._inputs(self._signals(t + j * self.period)) for j in range(1, self.delay + 1)]
        return ca.vertcat(self._signals(t), *later)

    def at(self, t: ca.SX, own: ca.SX, ref: Mapping[str, ca.SX]) -> tuple[ca.SX, ca.SX]:
        """The wanted states (nz, 1) and inputs (nu, 1) at a time, with the column of the window for it, if any.

        An input that is sent then acts after the delay. Those on their way act before it, oldest first.
        """
        if self.preview is None:
            column = ca.vertcat(*(ca.vec(ref[name]) for name in self.port.names), ca.SX(0, 1))
        else:
            column = own if own.numel() else self.preview_at(t)
        size, states = self.port.size, self.model.states
        wanted, r = self.port.view(column[:size]), states.view(ca.SX(self.rest[0]))
        r.update({name: part for name, part in wanted.items() if name in states})
        inputs = [self._with_rest(self._inputs(column[:size]))]
        if column.numel() > size:
            inputs += [self._with_rest(part) for part in ca.vertsplit(column[size:], self._input_port.size)]
        inputs += inputs[:1] * max(0, self.delay + 1 - len(inputs))
        queue = inputs[: self.delay] if self.delay else inputs * self.last_inputs
        return ca.vertcat(ca.densify(states.flatten(r)), *queue), inputs[self.delay]

    @property
    def _input_port(self) -> Layout:
        """The inputs that the reference gives."""
        return Layout(tuple(entry for entry in self.port.entries if entry.name in self.model.inputs))

    def _inputs(self, column: ca.SX) -> ca.SX:
        """The inputs among the signals of the reference, as a column."""
        signals, port = self.port.view(column), self._input_port
        return ca.densify(port.flatten({name: signals[name] for name in port.names}))

    def _with_rest(self, column: ca.SX) -> ca.SX:
        """All inputs (nu, 1): those of the reference, and those of the rest."""
        inputs = self.model.inputs.view(ca.SX(self.rest[1])) | self._input_port.view(column)
        return ca.densify(self.model.inputs.flatten(inputs))

    def _signals(self, t: ca.SX) -> ca.SX:
        assert self.preview is not None
        if isinstance(self.preview, PlannedReference):
            return planned_signals(self.preview, t)
        signals = call_block(self.preview, "at", self.preview.gives, t)
        return ca.densify(self.port.flatten({name: signals[name] for name in self.port.names}))
