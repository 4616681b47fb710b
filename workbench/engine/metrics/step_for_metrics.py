"""The choice of a step for metrics: pilot runs of an equation with its metrics beside it, and the errors of these."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial

import numpy as np

from workbench.core import Ode, SampledSystem, StepMap
from workbench.core.validation.refusals import Array
from workbench.engine import Trajectories
from workbench.engine.metrics.accumulators import final_values
from workbench.engine.metrics.contract import AbstractMetric
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.engine.metrics.measurement import error_of
from workbench.engine.state_changes import state_change
from workbench.engine.step_choice import Errors, Pilots, StepChoice, search_step
from workbench.engine.step_limits import NEGLIGIBLE

MOST_TIMED_STEPS = 20_000  # steps of a run, up to which the step is shortened for the sake of a time


def step_for(
    measured_equation: MeasuredEquation,
    p: Array,
    x0: Array,
    *,
    until: float,
    every: float | None = None,
    tolerance: float,
    seed: int = 0,
    arithmetic: str | None = None,
) -> StepChoice:
    """The step at which every pilot run p, x0 keeps the tolerance in every number of the metrics: see `search_step`.

    The error of a metric at the horizon is 2 |v(h) - v(h / 2)| relative to |v(h)|, that of a time at least h, for which
    the step is shortened to a 20,000th of the horizon at most. Without metrics it is the change of the states. p and x0
    are of the equation alone. The step divides the horizon, the kept times `every` [s] and the sample times of the
    metrics, or the period of a sampled loop.
    """
    equation, metrics, make = measured_equation.equation, measured_equation.metrics, cache(measured_equation.step)
    unit = equation.period if isinstance(equation, SampledSystem) else until
    if isinstance(equation, Ode):
        unit = measured_equation.grid(until, *([] if every is None else [every])) or every or until
    start = with_metric_states(x0, make(unit, "rk4"))
    errors: Errors = state_change  # where no metric is asked for
    if metrics:
        errors = partial(metric_error, metrics=metrics, is_sampled=isinstance(equation, SampledSystem))
    pilots = Pilots(equation, make, errors, p, start, until, unit, seed, arithmetic)
    return search_step(pilots, tolerance)


def metric_error(
    fine: Trajectories, coarse: Trajectories, metrics: Sequence[AbstractMetric], is_sampled: bool
) -> tuple[float, str]:
    """The largest error of a metric in the runs that last, relative to its value, and its name; NaN if none lasts."""
    lasts, found = ~fine.has_diverged, (np.nan, "a metric")
    if not lasts.any():
        return found
    halves, values = final_values(fine, metrics), final_values(coarse, metrics)
    h, timed = coarse.step.h, fine.t[-1] / coarse.step.h <= MOST_TIMED_STEPS
    for metric in metrics:
        value, half = values[metric.name][lasts], halves[metric.name][lasts]
        if metric.is_time and not (is_sampled or timed):
            continue
        off = error_of(value, half, [h if metric.is_time and not is_sampled else 0.0])
        with np.errstate(invalid="ignore", divide="ignore"):
            relative = np.where(off == 0, 0.0, off / np.maximum(np.abs(value), NEGLIGIBLE))
        relative[np.isnan(value) & np.isnan(half)] = 0.0  # it has no value at any step
        if metric.is_time:
            relative[half == 0] = 0.0  # of nothing no step is a small part
        worst = float(np.nan_to_num(relative, nan=np.inf, posinf=np.inf).max(initial=0.0))
        if not worst <= found[0]:
            found = worst, f"'{metric.name}'"
    return found


def with_metric_states(rows: Array, step: StepMap) -> Array:
    """Initial states of an equation with those of the metrics behind them, which a step has."""
    rest = step.states.default[rows.shape[1] :]
    return np.hstack([rows, np.tile(rest, (len(rows), 1))])
