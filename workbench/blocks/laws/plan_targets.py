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
    last_inputs
        The number of last inputs that stand behind the states of the plant.
    """

    model: AbstractPlant
    rest: tuple[Vector, Vector]
    port: Layout
    preview: AbstractReference | None
    period: float
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
        """The signals of the previewed reference at a time, as a column."""
        assert self.preview is not None
        if isinstance(self.preview, PlannedReference):
            return planned_signals(self.preview, t)
        signals = call_block(self.preview, "at", self.preview.gives, t)
        return ca.densify(self.port.flatten({name: signals[name] for name in self.port.names}))

    def at(self, t: ca.SX, own: ca.SX, ref: Mapping[str, ca.SX]) -> tuple[ca.SX, ca.SX]:
        """The wanted states (nz, 1) and inputs (nu, 1) at a time, with the column of the window for it, if any."""
        states, inputs = self.model.states, self.model.inputs
        wanted = {name: ref[name] for name in self.port.names}
        if self.preview is not None:
            wanted = self.port.view(own if own.numel() else self.preview_at(t))
        r, s = states.view(ca.SX(self.rest[0])), inputs.view(ca.SX(self.rest[1]))
        r.update({name: part for name, part in wanted.items() if name in states})
        s.update({name: part for name, part in wanted.items() if name in inputs})
        u = ca.densify(inputs.flatten(s))
        return ca.vertcat(ca.densify(states.flatten(r)), *[u] * self.last_inputs), u
