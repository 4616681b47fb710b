"""Accuracy: what halving every step of a schedule does to the metrics, against the tolerance that was asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np

from workbench.simulate.marches import arithmetic_of
from workbench.simulate.request import rows_of
from workbench.simulate.stepping.pilot import NOTHING, pilot_runs
from workbench.simulate.stepping.schedule import Make, Schedule, run, step_of
from workbench.simulate.stepping.stability import StepLimit, schedule_limits, tightest
from workbench.simulate.trajectories import Trajectories
from workbench.validation.refusals import Array, positive, whole
from workbench.validation.signatures import answer, door
from workbench.validation.type_hints import KindError, fit_of

# The metrics of each run by name, (B, k), from trajectories that have its state at the horizon.
Score = Callable[[Trajectories], Mapping[str, Array]]
METRICS = fit_of(Mapping[str, Array])


@dataclass(frozen=True)
@door
class Accuracy:
    """The relative change of one metric as every step is halved.

    Attributes
    ----------
    median, worst
        Over the runs, of the largest change among the metric's numbers.
    within
        The share of the runs whose change is within the tolerance.
    runs, lost
        How many runs have a value at the halved steps, and how many have not.
    """

    metric: str
    tolerance: float
    median: float
    worst: float
    within: float
    runs: int
    lost: int

    @property
    def met(self) -> bool:
        """Whether every run that has a value is within the tolerance, and there is one."""
        return self.runs > 0 and self.within == 1

    @property
    def miss(self) -> str:
        """By how much the tolerance is missed, as a remark beside one run."""
        if not self.runs:
            return f"{self.metric} not tested against its tolerance {self.tolerance:g}"
        return f"{self.metric} beyond its tolerance {self.tolerance:g}: it changes by {self.worst:.1e} at half the step"

    def __str__(self) -> str:
        """One line that says whether the tolerance is met."""
        if not self.runs:
            return f"{self.metric}: tolerance {self.tolerance:g} NOT tested: none of {self.lost:,} runs has a value."
        lost = f"; {self.lost:,} of {self.runs + self.lost:,} runs have no value" if self.lost else ""
        found = f"median {self.median:.1e}, worst {self.worst:.1e} of {self.runs:,} runs{lost}"
        if self.met:
            return f"{self.metric}: tolerance {self.tolerance:g} met: {found}."
        if self.median <= self.tolerance:
            return f"{self.metric}: tolerance {self.tolerance:g} met by {100 * self.within:.3g} % only: {found}."
        return f"{self.metric}: tolerance {self.tolerance:g} NOT met: {found}."


@dataclass(frozen=True)
@door
class Check:
    """The accuracy of each metric, and the tightest stability limit that its steps have.

    Attributes
    ----------
    looked_at, runs
        Along how many runs the limit was taken, of how many.
    """

    metrics: tuple[Accuracy, ...]
    limit: StepLimit
    looked_at: int
    runs: int

    @property
    def passed(self) -> bool:
        """Whether every tolerance is met and no step is beyond its limit."""
        return self.limit.holds and all(accuracy.met for accuracy in self.metrics)

    def __str__(self) -> str:
        """A line for each metric and one for the limit."""
        h, limit = 1000 * self.limit.h, 1000 * self.limit.limit
        verdict = "within" if self.limit.holds else "BEYOND"
        where = f"the step of {h:.3g} ms at {self.limit.at:.4g} s is {verdict} its limit of {limit:.3g} ms"
        found = where if self.limit.checked else "NOT tested: no state has a Jacobian"
        along = f", along {self.looked_at} of {self.runs:,} runs" if self.looked_at < self.runs else ""
        return "\n".join([*map(str, self.metrics), f"stability: {found}{along}."])


@door
def check_by_halving(
    schedule: Schedule, make: Make, p: Array, x0: Array, score: Score, tolerance: float, looked_at: int = 4
) -> Check:
    """How far the metrics of B runs change from a schedule to the same with every step halved.

    The change is the error of the longer step less that of its half. Where a law switches it tells the
    size of the error and bounds nothing. The stability limit is that of `looked_at` of the runs.

    Parameters
    ----------
    p, x0
        (B, np) and (B, nx).

    Raises
    ------
    ValueError
        If a number is none, `score` gives no arrays of a row a run, or `run` refuses.
    """
    tolerance = positive("check_by_halving(tolerance=...)", tolerance)
    looked_at = whole("check_by_halving(looked_at=...)", looked_at)
    step = step_of("check_by_halving", make, schedule.segments[0].method, schedule.cell)
    p, x0 = rows_of("check_by_halving", step, p, x0)
    rounding = arithmetic_of(step, len(p))
    coarse, fine = (_scored(score, run(each, make, p, x0, arithmetic=rounding)) for each in (schedule, schedule.halved))
    if fine.keys() != coarse.keys() or any(fine[name].shape != coarse[name].shape for name in fine):
        raise ValueError("`check_by_halving(score=...)` must give the same metrics of both schedules; it gave others.")
    few = pilot_runs(p, x0, looked_at)
    limits = schedule_limits(schedule, make, p[few], x0[few], rounding)
    metrics = tuple(accuracy(name, change(fine[name], coarse[name]), fine[name], tolerance) for name in fine)
    return Check(metrics, tightest(limits), len(few), len(p))


def _scored(score: Score, runs: Trajectories) -> Mapping[str, Array]:
    """The metrics that a user's function gives."""

    def fit(given: object) -> Mapping[str, Array]:
        metrics: Mapping[str, Array] = METRICS(given)
        for name, value in metrics.items():
            if value.ndim == 0 or len(value) != len(runs) or value.size == 0:
                raise KindError("", f"'{name}' in shape {value.shape}")
        return metrics

    must = f"be a function of trajectories that gives arrays ({len(runs)}, k) by the names of metrics, a row a run"
    return cast(Mapping[str, Array], answer("check_by_halving(score=...)", must, lambda: score(runs), fit))


def change(fine: Array, coarse: Array, least: float = 0.0) -> Array:
    """|fine - coarse|, but at least what one step can tell; zero where two infinite values agree."""
    with np.errstate(invalid="ignore"):
        found = np.maximum(np.abs(fine - coarse), least)
    return np.where(np.isinf(fine) & np.isinf(coarse), 0.0, found)


def accuracy(name: str, change: Array, value: Array, tolerance: float) -> Accuracy:
    """The accuracy of a metric with the values (B, ...) at the half step that changed so much (B, ...).

    A change is relative to the value, of which less than 1e-9 in its unit is as good as nothing. Where
    there is a value and no change, as the longer step lost the run, the change is infinite.
    """
    change, value = change.reshape(len(change), -1), value.reshape(len(value), -1)
    told = ~np.isnan(value).any(axis=1)
    if not told.any():
        return Accuracy(name, tolerance, np.nan, np.nan, 0.0, 0, len(value))
    with np.errstate(invalid="ignore"):
        relative = change[told] / np.maximum(np.abs(value[told]), NOTHING)
    relative = np.where(change[told] == 0, 0.0, np.nan_to_num(relative, nan=np.inf, posinf=np.inf)).max(axis=1)
    within = float(np.mean(relative <= tolerance))
    return Accuracy(
        name, tolerance, float(np.median(relative)), float(relative.max()), within, len(relative), int((~told).sum())
    )
