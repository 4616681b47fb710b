"""Differences of a run's metrics from runs beside it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.core import Ode, Step
from workbench.metrics import AbstractMetric
from workbench.metrics.accumulators import final_values
from workbench.simulate import simulate
from workbench.validation.refusals import Array


def slopes(
    step: Step,
    metrics: Sequence[AbstractMetric],
    loop: Ode,
    places: Sequence[int],
    here: Array,
    until: float,
    width: float,
) -> dict[str, Array]:
    """Slopes (k, m) of the metrics over changes by `width`, relative to each number; of a zero, by `width` itself.

    They are central differences extrapolated from the whole width and half of it; at a bound, one-sided ones.
    """
    ends = np.array([_ends(loop, here, place, width) for place in places])
    shifts = ends[:, [0, 1, 0, 1]] * [1.0, 1.0, 0.5, 0.5]
    rows = [here + shift * _unit(here, place) for place, four in zip(places, shifts, strict=True) for shift in four]
    table, split = np.array(rows), loop.parameters.size
    start = np.hstack([table[:, split:], np.tile(step.states.default[loop.states.size :], (len(table), 1))])
    same = np.zeros(len(table), dtype=int)  # all runs are number 0, so that noise is the same in them
    runs = simulate(step, p=table[:, :split], x0=start, until=until, every=until, runs=same)
    spans = ends[:, 1] - ends[:, 0]
    order = np.where(ends.all(axis=1), 4.0, 2.0)  # how much less wrong half the width is, by the sides it goes to
    found = {}
    for name, value in final_values(runs, metrics).items():
        at = value.reshape(len(places), 4, -1).transpose(1, 2, 0)  # (4, k, m), in the order of the shifts
        with np.errstate(invalid="ignore"):  # what is infinite has no slope
            whole, half = (at[1] - at[0]) / spans, (at[3] - at[2]) / (spans / 2)
            found[name] = (order * half - whole) / (order - 1)
    return found


def _ends(loop: Ode, here: Array, place: int, width: float) -> tuple[float, float]:
    """How far a number is moved down and up: not at all to the side where that is not allowed."""
    by = width * (abs(here[place]) or 1.0)
    low, high = (_allows(loop, here + shift * _unit(here, place)) for shift in (-by, by))
    if not low and not high:
        label = (loop.parameters.labels + loop.states.labels)[place]
        raise ValueError(f"`local_sensitivities(names=...)`: '{label}' cannot be moved by itself within its bounds.")
    return (-by if low else 0.0), (by if high else 0.0)


def _unit(here: Array, place: int) -> Array:
    return np.asarray(np.arange(len(here)) == place, dtype=float)


def _allows(loop: Ode, row: Array) -> bool:
    try:
        loop.parameters.check(row[np.newaxis, : loop.parameters.size])
        loop.states.check(row[np.newaxis, loop.parameters.size :])
    except ValueError:
        return False
    return True
