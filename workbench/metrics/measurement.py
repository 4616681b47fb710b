"""The result of `measure`: metrics with their errors, the limit on the step, and the check of a tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.metrics.contract import AbstractMetric
from workbench.simulate import StepLimit, Trajectories
from workbench.simulate.step_size import Check
from workbench.validation.refusals import Array, Integers
from workbench.validation.signatures import door
from workbench.validation.views import listed, table_to_html

HEAD = ("metric", "of", "unit", "least", "mean", "largest", "error")


@dataclass(frozen=True, eq=False)
@door
class Score:
    """A metric of B runs, (B, k), and its error: the change from the step to half of it.

    For a smooth loop the change is about 15 times the error of the value. Where switching makes the
    method first order and its error irregular, the change tells the size of the error and bounds
    nothing: it has been seen five times too small. A time is known to one step at best. A run that
    diverged has NaN in both.
    """

    metric: AbstractMetric
    value: Array
    error: Array

    def __post_init__(self) -> None:
        if self.value.ndim != 2 or self.value.shape != self.error.shape:
            raise ValueError(
                "`Score(value=..., error=...)` must be two arrays of one shape (B, k); got shapes "
                f"{self.value.shape} and {self.error.shape}."
            )

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """A row for each number: metric, label, unit, the least, mean and largest value of all runs, and the error."""
        rows = []
        labels = self.metric.labels or ("",) * self.value.shape[1]
        units = self.metric.units or (self.metric.unit,) * len(labels)
        for place, (label, unit) in enumerate(zip(labels, units, strict=True)):
            values, errors = (column[np.isfinite(column)] for column in (self.value[:, place], self.error[:, place]))
            ends = (values.min(), values.mean(), values.max()) if values.size else (np.nan,) * 3
            numbers = (*ends, errors.max(initial=0.0) if errors.size else np.nan)
            rows.append((self.metric.name, label, unit, *(f"{number:.6g}" for number in numbers)))
        return rows

    def _repr_html_(self) -> str:
        """A table of the values of all runs, and of the largest error."""
        return table_to_html("", HEAD, self.rows)


@dataclass(frozen=True, eq=False)
@door
class Measurement:
    """Trajectories and metrics of a loop at half the step, their change from the whole step, and the limit on the step.

    Attributes
    ----------
    limits, looked_at
        Of the whole steps, along the runs with the numbers `looked_at`: all of up to 16 runs, 16 of more,
        picked as pilots are.
    coarse_diverged_at
        (B,), of runs that diverged at the whole step.
    check
        The verdict that each metric changed by no more than the tolerance, and the tightest of the limits; None if no
        tolerance was asked for.
    """

    trajectories: Trajectories
    scores: Mapping[str, Score]
    limits: tuple[StepLimit, ...]
    looked_at: Integers
    coarse_diverged_at: Array
    check: Check | None = None

    def __repr__(self) -> str:
        """One line: the runs and the metrics."""
        return f"<Measurement of {len(self.trajectories)} runs: {listed(list(self.scores))}>"

    def _repr_html_(self) -> str:
        """A table of the values of all runs, and of the largest error of each metric."""
        rows = [row for score in self.scores.values() for row in score.rows]
        return table_to_html(repr(self.trajectories), HEAD, rows)

    @property
    def h(self) -> float:
        """The step at which the values were taken, in s; of a sampled loop the substep."""
        return self.trajectories.step.h / self.trajectories.step.substeps
