"""The doors to the accumulators of metrics: the step of an equation with them, and the values at its end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.core import Ode, SampledSystem, StepMap
from workbench.core.validation.refusals import Array, whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine import Trajectories
from workbench.engine.metrics.contract import AbstractMetric
from workbench.engine.metrics.measured_equation import MeasuredEquation, accumulator_totals, accumulators_in, values


@check_arguments
def step_with_metrics(equation: Ode | SampledSystem, metrics: Sequence[AbstractMetric], h: float) -> StepMap:
    """The step of `equation` that also accumulates every metric; h in s is the step, or a sampled loop's substep.

    Integrals are computed in the substeps. Metrics of samples take one sample per period, after the jump.

    Raises
    ------
    LookupError
        If a metric watches an output that `equation` does not have.
    ValueError
        If h is not positive or does not divide the period of a sampled loop, two metrics have one name, or a metric is
        not defined for `equation`.

    Examples
    --------
    >>> from workbench.engine.metrics import step_with_metrics
    >>> step_with_metrics(wb.open_loop(wb.DCMotor()), [wb.rmse("omega")], 1e-3).states.size
    3
    """
    return MeasuredEquation.of(equation, metrics).step(h)


@check_arguments
def final_values(runs: Trajectories, metrics: Sequence[AbstractMetric], row: int = -1) -> dict[str, Array]:
    """Each metric of each run, (B, k), up to the kept time number `row`; NaN for a run that has diverged.

    Examples
    --------
    >>> motor, area = wb.open_loop(wb.DCMotor()), wb.effort("omega")
    >>> runs = wb.simulate(wb.metrics.step_with_metrics(motor, [area], 1e-2), until=1.0, every=1.0)
    >>> wb.metrics.final_values(runs, [area])["effort of omega"].shape
    (1, 1)
    """
    row = whole("final_values(row=...)", row, -len(runs.t), len(runs.t) - 1)
    horizon, held = float(runs.t[row]), accumulators_in(runs.step, metrics)
    lost = (runs.diverged_at <= horizon)[:, np.newaxis]
    found = values(metrics, held, accumulator_totals(runs, held, metrics, row), horizon)
    return {name: np.where(lost, np.nan, value) for name, value in found.items()}
