"""Derivatives of a run's metrics: exact for the steps that are taken, and by differences of neighbouring runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, Step
from workbench.metrics import AbstractMetric
from workbench.metrics.accumulators import final_values
from workbench.simulate import simulate
from workbench.simulate.arithmetic import continued
from workbench.validation.refusals import Array

SHIFTS = 1e-3 * np.array([-2.0, -1.0, 1.0, 2.0])  # of a difference of fourth order through the last formula of a metric
WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12e-3

Rows = tuple[Array, Array]  # a quantity and its derivatives, (m, k) each, one row a number that is varied


def gradients(
    step: Step, metrics: Sequence[AbstractMetric], places: Sequence[int], p: Array, x0: Array, until: float
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Values (k,) and derivatives (k, m) of the metrics, a run a direction; NaN where a direction leaves all bounds."""
    values = _values(step, metrics, p, x0, until)
    more, start = _along(step, places, p, x0)
    same = np.zeros(len(places), dtype=int)  # all runs are number 0, so that noise is the same in them
    runs = simulate(more, p=p, x0=start, until=until, every=until, runs=same)
    later = continued(runs.job, runs.x[:, -1], round(until / more.h), 1)  # a last look, as `final_values` takes it
    gradient = {}
    for metric in metrics:
        of_integral, of_memory = f"integral of {metric.name}", f"{metric.name}."
        integral = [_rows(more, runs.x[:, -1], name) for name in step.states.names if name == of_integral]
        memory = {
            name.removeprefix(of_memory): _rows(more, later, name)
            for name in step.states.names
            if name.startswith(of_memory)
        }
        found = _chained(metric, integral, memory, len(places), until)
        gradient[metric.name] = np.where(runs.diverged, np.nan, found)
    return values, gradient


def _values(step: Step, metrics: Sequence[AbstractMetric], p: Array, x0: Array, until: float) -> dict[str, Array]:
    """The metrics of the run itself, which must last."""
    start = np.concatenate([x0, step.states.default[x0.size :]])
    run = simulate(step, p=p, x0=start, until=until, every=until)
    if run.diverged[0]:
        raise ValueError(
            f"`local_sensitivities(...)` needs a run that lasts; this one diverged at {run.diverged_at[0]:g} s."
        )
    return {name: value[0] for name, value in final_values(run, metrics).items()}


def _along(step: Step, places: Sequence[int], p: Array, x0: Array) -> tuple[Step, Array]:
    """The step with a column of S and its direction in p beside its states, and the starts (m, ...) of the runs."""
    rule, n, m = step.rule, step.states.size, len(places)
    moved = [place for place in places if place < p.size]
    more = Layout((Entry("S", np.zeros(n)), *([Entry("direction", np.zeros(len(moved)))] if moved else [])))
    symbols = more.symbols()
    S, direction = symbols[:n], symbols[n:]
    in_p = ca.SX.zeros(p.size)
    in_p[moved] = direction
    update = ca.jtimes(rule.next, ca.vertcat(rule.x, rule.p), ca.vertcat(S, in_p))
    extended = replace(step, rule=rule.written_out).extended(more, symbols, ca.vertcat(ca.densify(update), direction))
    start = np.tile(np.concatenate([x0, extended.states.default[x0.size :]]), (m, 1))
    for row, place in zip(start, places, strict=True):
        row[n + (n + moved.index(place) if place < p.size else place - p.size)] = 1.0
    return extended, start


def _rows(more: Step, ends: Array, name: str) -> Rows:
    """A state of the step at the ends of all runs, and its part of S, (m, k) each."""
    S = ends[:, more.states.slice("S")]
    return ends[:, more.states.slice(name)], S[:, more.states.slice(name)]


def _chained(
    metric: AbstractMetric, integral: Sequence[Rows], memory: Mapping[str, Rows], m: int, until: float
) -> Array:
    """The derivatives (k, m) of the formula that a metric is of its integral and memory, by differences."""
    held = [*integral, *memory.values()]
    # how far to go along each direction: until one of the quantities has changed by about itself
    change = [np.abs(dz) / np.where(z == 0, 1.0, np.abs(z)) for z, dz in held]
    fastest = np.max([part.max(axis=1, initial=0.0) for part in change], axis=0)
    reach = (1 / np.where(fastest > 0, fastest, 1.0))[:, np.newaxis]

    def value(shift: float) -> Array:
        total = [z + shift * reach * dz for z, dz in integral] or [np.zeros((m, 0))]
        z = {name: z + shift * reach * dz for name, (z, dz) in memory.items()}
        return metric.value(total[0], z, until)

    with np.errstate(invalid="ignore"):  # what is infinite has no derivative
        return np.asarray((sum(w * value(s) for w, s in zip(WEIGHTS, SHIFTS, strict=True)) / reach).T)


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
    """The shifts of a number down and up: none to the side where that is not allowed."""
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
