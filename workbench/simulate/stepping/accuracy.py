"""Accuracy: what halving every step of a schedule does to the metrics, against the tolerance that was asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.core.numbers import Array
from workbench.simulate.stepping.pilot import pilot_rows
from workbench.simulate.stepping.schedule import Make, Schedule, run
from workbench.simulate.stepping.stability import StepLimit, schedule_limit
from workbench.simulate.trajectories import Trajectories

# The metrics of each run by name, (B, k), from trajectories that have its state at the horizon.
Score = Callable[[Trajectories], Mapping[str, Array]]


@dataclass(frozen=True)
class Accuracy:
    """The relative change of one metric as every step is halved.

    Attributes
    ----------
    median, worst
        Over the runs, of the largest change among the metric's numbers.
    within
        The share of the runs whose change is within the tolerance.
    runs, lost
        How many runs have a value at the steps and at their halves, which tell the change, and how many have not.
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

    def __str__(self) -> str:
        """One line that says whether the tolerance is met."""
        if not self.runs:
            return f"{self.metric}: tolerance {self.tolerance:g} NOT tested: none of {self.lost} runs has a value."
        lost = f"; {self.lost} of {self.runs + self.lost} runs have no value" if self.lost else ""
        found = f"median {self.median:.1e}, worst {self.worst:.1e} of {self.runs} runs{lost}"
        if self.met:
            return f"{self.metric}: tolerance {self.tolerance:g} met: {found}."
        if self.median <= self.tolerance:
            return f"{self.metric}: tolerance {self.tolerance:g} met by {100 * self.within:.3g} % only: {found}."
        return f"{self.metric}: tolerance {self.tolerance:g} NOT met: {found}."


@dataclass(frozen=True)
class Check:
    """The accuracy of each metric under a schedule, and the tightest stability limit that its steps have."""

    metrics: tuple[Accuracy, ...]
    limit: StepLimit

    @property
    def passed(self) -> bool:
        """Whether every tolerance is met and no step is beyond its limit."""
        return self.limit.holds and all(accuracy.met for accuracy in self.metrics)

    def __str__(self) -> str:
        """A line for each metric and one for the limit."""
        h, limit = 1000 * self.limit.h, 1000 * self.limit.limit
        verdict = "within" if self.limit.holds else "BEYOND"
        where = f"the step of {h:.3g} ms at {self.limit.at:.4g} s is {verdict} its limit of {limit:.3g} ms"
        stable = f"stability: {where}." if self.limit.checked else "stability: NOT tested: no state has a Jacobian."
        return "\n".join([*map(str, self.metrics), stable])


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
    """
    coarse, fine = (score(run(each, make, p, x0)) for each in (schedule, schedule.halved))
    few = run(schedule, make, *pilot_rows(p, x0, looked_at), every=1)
    limits = [schedule_limit(schedule, make, few, i) for i in range(len(few))]
    tightest = max(limits, key=lambda limit: np.nan_to_num(limit.h / limit.limit, nan=-1.0))
    return Check(tuple(_accuracy(name, coarse[name], fine[name], tolerance) for name in fine), tightest)


def _accuracy(name: str, coarse: Array, fine: Array, tolerance: float) -> Accuracy:
    coarse, fine = coarse.reshape(len(coarse), -1), fine.reshape(len(fine), -1)
    told = np.isfinite(coarse).all(axis=1) & np.isfinite(fine).all(axis=1)
    if not told.any():
        return Accuracy(name, tolerance, np.nan, np.nan, 0.0, 0, len(fine))
    change, size = np.abs(coarse - fine)[told], np.abs(fine[told])
    relative = np.divide(change, size, out=np.where(change > 0, np.inf, 0.0), where=size > 0).max(axis=1)
    within = float(np.mean(relative <= tolerance))
    return Accuracy(
        name, tolerance, float(np.median(relative)), float(relative.max()), within, len(relative), int((~told).sum())
    )
