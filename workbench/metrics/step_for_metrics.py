"""The choice of a step for metrics: pilot runs of an equation with its metrics beside it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from workbench.core import Ode, Sampled, Step
from workbench.metrics.accumulators import common_grid, maker, resolved
from workbench.metrics.contract import AbstractMetric
from workbench.simulate.step_choice import choose_step, longest_step
from workbench.validation.refusals import Array


def chosen_step(
    equation: Ode | Sampled,
    metrics: Sequence[AbstractMetric],
    p: Array,
    x0: Array,
    until: float,
    every: float | None,
    tolerance: float,
    seed: int = 0,
    arithmetic: str | None = None,
) -> float:
    """The longest step h in s at which the pilot runs p, x0 change by no more than the tolerance to h / 2.

    Of a sampled loop it is the period, its half, its quarter and so on; p and x0 are of the equation alone.
    """
    make = cache(maker(equation, resolved(equation, metrics, until)))
    unit = until
    if isinstance(equation, Ode):
        unit = common_grid(metrics, until, *([] if every is None else [every])) or every or until
    start = extended(x0, make(longest_step(equation, p, until, unit)))
    assert start is not None
    return choose_step(equation, make, p, start, until, unit, tolerance, seed, arithmetic)


def extended(rows: Array | None, step: Step) -> Array | None:
    """Initial states of the loop with those of the metrics behind them."""
    if rows is None:
        return None
    rest = step.states.default[rows.shape[1] :]
    return np.hstack([rows, np.tile(rest, (len(rows), 1))])
