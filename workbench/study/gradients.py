"""Exact derivatives of a run's metrics: those of the very steps that are taken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Step
from workbench.core.layout import Array
from workbench.metrics import AbstractMetric
from workbench.metrics.measure import final_values
from workbench.simulate import simulate
from workbench.simulate.marches import continued

SHIFTS = 1e-3 * np.array([-2.0, -1.0, 1.0, 2.0])  # of a difference of fourth order through the last formula of a metric
WEIGHTS = np.array([1.0, -8.0, 8.0, -1.0]) / 12e-3

Rows = tuple[Array, Array]  # a quantity and its derivatives, (m, k) each, one row a number that is varied


def gradients(
    step: Step, metrics: Sequence[AbstractMetric], places: Sequence[int], p: Array, x0: Array, until: float
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Values (k,) and derivatives (k, m) of the metrics, from S carried along; NaN where S leaves all bounds."""
    rule, n, m = step.rule, step.states.size, len(places)
    unit = np.zeros((p.size + n, m))
    unit[list(places), range(m)] = 1.0  # the states of the loop come first among those of the step
    S = Layout((Entry("S", unit[p.size :]),))
    symbols = S.symbols()
    directions = ca.vertcat(ca.reshape(symbols, n, m), ca.DM(unit[: p.size]))
    update = ca.jtimes(rule.next, ca.vertcat(rule.x, rule.p), directions)
    more = step.extended(S, symbols, ca.vec(ca.densify(update)))
    start = np.concatenate([x0, more.states.default[x0.size :]])
    runs = simulate(more, p=p, x0=start, until=until, every=until)
    if runs.diverged[0]:
        return _without(step, metrics, p, start[: step.states.size], m, until)
    end = runs.x[0, -1]
    later = continued(runs.job, runs.x[:, -1], round(until / more.h), 1)[0]  # a last look, as `final_values` takes it
    gradient = {}
    for metric in metrics:
        of_integral, of_memory = f"integral of {metric.name}", f"{metric.name}."
        integral = [_rows(more, end, name, m) for name in step.states.names if name == of_integral]
        memory = {
            name.removeprefix(of_memory): _rows(more, later, name, m)
            for name in step.states.names
            if name.startswith(of_memory)
        }
        gradient[metric.name] = _through(metric, integral, memory, m, until)
    return {name: value[0] for name, value in final_values(runs, metrics).items()}, gradient


def _without(
    step: Step, metrics: Sequence[AbstractMetric], p: Array, start: Array, m: int, until: float
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Values alone, and no derivatives where these left all bounds; without a run that lasts a refusal."""
    run = simulate(step, p=p, x0=start, until=until, every=until)
    if run.diverged[0]:
        raise ValueError(
            f"`local_sensitivities(...)` needs a run that lasts; this one diverged at {run.diverged_at[0]:g} s."
        )
    values = {name: value[0] for name, value in final_values(run, metrics).items()}
    return values, {name: np.full((len(value), m), np.nan) for name, value in values.items()}


def _rows(more: Step, end: Array, name: str, m: int) -> Rows:
    """A state of the step at its end, and its rows of S."""
    parts = more.states.unpack(end)
    value = parts[name].ravel(order="F")
    return np.tile(value, (m, 1)), parts["S"][more.states.slice(name)].T


def _through(
    metric: AbstractMetric, integral: Sequence[Rows], memory: Mapping[str, Rows], m: int, until: float
) -> Array:
    """The derivatives (k, m) of what a metric makes of its integral and memory: a formula, by differences."""
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
