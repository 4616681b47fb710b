"""The picture of a plan: its states and inputs over time, with their limits."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.planning.trajectories.trajectory_plan import Plan
from workbench.report.picture import Picture
from workbench.study.document.document import Figure, Panel
from workbench.study.document.figure import Series

POINTS = 400  # of a curve between nodes


@check_arguments
def draw_plan(plan: Plan, *names: str) -> Picture:
    """States and inputs of a plan over time, a panel for each name; all of them by default."""
    layout = plan.states + plan.inputs
    chosen = names or layout.names
    for name in chosen:
        known_name(name, (*layout.names, *layout.labels), "states and inputs of this plan")
    panels = tuple(_panel(plan, name) for name in chosen)
    nodes = "straight lines" if plan.hold == "linear" else "constant"
    about = f"A plan of {plan.until:.4g} s. Inputs are {nodes} between nodes; thin lines are limits."
    return Picture(Figure("plan", about, panels, columns=2 if len(panels) > 1 else 1))


def _panel(plan: Plan, name: str) -> Panel:
    layout = plan.states + plan.inputs
    places = layout.indices(name)
    units = [unit for entry in layout.entries for unit in entry.units]
    t, values = _curves(plan)
    series = tuple(
        Series(layout.labels[place] if len(places) > 1 else "", t, values[:, place], k)
        for k, place in enumerate(places)
    )
    unit = units[places[0]]
    label = f"{name} [{unit}]" if unit else name
    limits = {end for place in places for end in _limits(plan, place)}
    return Panel(label, series, hlines=tuple(sorted(limits)))


def _curves(plan: Plan) -> tuple[Array, Array]:
    """Times (K,) and the values (K, nx + nu) of states and inputs, with two points where an input jumps."""
    times = np.unique(np.concatenate([plan.t, np.linspace(0.0, plan.until, POINTS)]))
    before = np.maximum(times - 1e-9 * plan.until, 0.0)
    every = np.sort(np.concatenate([before, times]))
    return every, np.hstack(plan.at(every))


def _limits(plan: Plan, place: int) -> list[float]:
    """The limits of a state or an input that are the same in all phases."""
    ends = plan.problem.box
    return [float(end[place]) for _, end, _ in ends.ends if np.isfinite(end[place])]
