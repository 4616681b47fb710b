"""Goals in the time of the loop itself, nonlinear as it is: a metric of a run, with gradients by differences."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.validation.refusals import Array, positive, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.design.structured_tuning.figure_pieces import FigurePiece
from workbench.engine.metrics import AbstractMetric, measure
from workbench.study.loop_tuning.knob_places import KnobPlaces

STEP = 1e-4  # of the share of a range: of a central difference


@dataclass(frozen=True, eq=False)
@check_arguments
class RunGoal:
    """A metric of a run of the loop, made small or kept below a limit; its gradient is a central difference.

    Attributes
    ----------
    metric
        A metric with positive numbers, as `wb.rmse()`, `wb.overshoot()` or `wb.settling_time()`. If it has several, the
        largest counts.
    until, h
        The horizon and the step of the run, in s.
    limit
        The largest value, in the unit of the metric; None for a soft goal.
    scale
        The value of a soft goal that counts as one, in the unit of the metric.
    seed
        The seed of the noise of the run.

    Raises
    ------
    ValueError
        If a time, a limit or a scale is not positive.

    Examples
    --------
    >>> wb.loop_tuning.RunGoal(wb.rmse(), until=5.0, h=1e-3).words
    'RMSE as small as possible'
    """

    metric: AbstractMetric
    until: float
    h: float
    limit: float | None = None
    scale: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        seconds("RunGoal(until=...)", self.until)
        seconds("RunGoal(h=...)", self.h)
        positive("RunGoal(scale=...)", self.scale)
        if self.limit is not None:
            positive("RunGoal(limit=...)", self.limit)

    @property
    def words(self) -> str:
        """The goal in words."""
        if self.limit is None:
            return f"{self.metric.name} as small as possible"
        return f"{self.metric.name} <= {self.limit:g}"

    @check_arguments
    def values(self, equations: Ode | SampledSystem, p: Array) -> Array:
        """The largest number of the metric (N,) at rows of parameters (N, np); NaN where a run diverged."""
        x = np.tile(equations.states.default, (len(p), 1))
        found = measure(equations, [self.metric], p, x, until=self.until, h=self.h, every=self.h, seed=self.seed)
        scores = np.array([one.value for one in found.scores_of(self.metric.name)])
        return np.asarray(scores.reshape(-1, len(p)).max(axis=0))

    @check_arguments
    def piece(self, equations: Ode | SampledSystem, rows: RunRows, shares: Array) -> FigurePiece:
        """The logarithm of the metric over its limit or scale at shares (d,) of the ranges, with its gradient."""
        d = len(shares)
        ahead, behind = np.minimum(shares + STEP, 1.0), np.maximum(shares - STEP, 0.0)
        each = np.tile(shares, (2 * d + 1, 1))
        each[np.arange(d) + 1, np.arange(d)], each[np.arange(d) + 1 + d, np.arange(d)] = ahead, behind
        values = self.values(equations, rows.parameters(each))
        reference = self.scale if self.limit is None else self.limit
        with np.errstate(divide="ignore", invalid="ignore"):
            logs = np.log(np.maximum(values, 1e-300) / reference)
        gradient = (logs[1 : d + 1] - logs[d + 1 :]) / (ahead - behind)
        return FigurePiece(float(logs[0]) if math.isfinite(logs[0]) else math.inf, np.asarray(gradient))


@dataclass(frozen=True, eq=False)
class RunRows:
    """The parameters of the loop's own equations at shares of the knobs' ranges."""

    knobs: KnobPlaces
    places: tuple[tuple[int, ...], ...]  # among the parameters of the equations
    base: Array

    @staticmethod
    def of(knobs: KnobPlaces, equations: Ode | SampledSystem, values: dict[str, Array]) -> RunRows:
        """The rows of equations, whose other parameters have these values by name."""
        layout = equations.parameters
        places = tuple(
            tuple(i for path in knob.paths if path in layout or path in layout.labels for i in layout.indices(path))
            for knob in knobs.knobs
        )
        return RunRows(knobs, places, layout.pack(values)[0])

    def parameters(self, shares: Array) -> Array:
        """The parameters (N, np) at shares (N, d)."""
        p = np.tile(self.base, (len(shares), 1))
        for row, own in zip(p, shares, strict=True):
            for knob, places, number in zip(self.knobs.knobs, self.places, self.knobs.numbers(own), strict=True):
                row[list(places)] = number * self.base[list(places)] if knob.share else number
        return p
