"""A loop whose computer is late at its instants, and misses periods, by two more parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core.layout import Entry, Layout
from workbench.core.numbers import Bounds
from workbench.core.ode import Ode

Jumps = Mapping[str, ca.SX]  # of a `SampledSystem`: 'w', 'jump' and 'crossing_jump'


def add_timing_faults(
    flow: Ode, T: float, k: ca.SX, jumps: Jumps, noise_states: tuple[str, ...]
) -> tuple[Ode, dict[str, ca.SX]]:
    """The flow and the jumps of a sampled system with the faults of `SampledSystem.with_timing_faults`."""
    t = flow.t
    kinds = (("jitter", "s", T / 2), ("missed", "1", 1.0))
    settings = Layout(tuple(Entry(f"computer.{n}", np.zeros(()), unit, Bounds(0.0, b)) for n, unit, b in kinds))
    clock = Layout(tuple(Entry(f"computer.{name}", np.zeros(()), "s") for name in ("late", "later", "instant")))
    p, z, w = settings.symbols(), clock.symbols(), ca.SX.sym("w", 4)
    jitter, missed = ca.vertsplit(p)
    late, later, instant = ca.vertsplit(z)
    # of two normal numbers the sum of squares is exponential with mean 2, so that this is uniform in (0, 1]
    lateness, luck = (ca.exp(-(w[i] * w[i] + w[i + 1] * w[i + 1]) / 2) for i in (0, 2))
    # nominal time runs through each period as if it were `period` long: x' = pace f(true time, x, p)
    pace = 1 + (later - late) / T
    true = t + late + (later - late) / T * (t - instant)
    rate, output = ca.substitute([flow.rate, flow.output], [t], [true])
    kept = [name for name in flow.states.names if not name.startswith("plant.") and name not in noise_states]
    own = [i for name in kept for i in flow.states.indices(name)]
    clocks = ca.vertcat(later, jitter * lateness, k * T)
    jump, crossed = (
        ca.vertcat(_unless(luck < missed, flow.x, jumps[name], own), clocks) for name in ("jump", "crossing_jump")
    )
    faulty = replace(
        flow,
        states=flow.states + clock,
        parameters=flow.parameters + settings,
        x=ca.vertcat(flow.x, z),
        p=ca.vertcat(flow.p, p),
        rate=ca.vertcat(pace * rate, ca.SX.zeros(clock.size, 1)),
        output=output,
    )
    return faulty, {"w": ca.vertcat(jumps["w"], w), "jump": jump, "crossing_jump": crossed}


def _unless(is_missed: ca.SX, x: ca.SX, jump: ca.SX, own: list[int]) -> ca.SX:
    """The state after the jump, where the entries `own` stay as they are in a period that is missed."""
    after = ca.vertcat(jump, x[jump.numel() :, 0])
    for i in own:
        after[i] = ca.if_else(is_missed, x[i], after[i])
    return after
