"""The length of a step: its limit along a run, and the accuracy of metrics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array, whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine.stability import StepLimit, limit_along
from workbench.engine.trajectories import Trajectories

POINTS = 400  # of a run, at which its Jacobian is looked at
NEGLIGIBLE = 1e-9  # a state or a value that stays below it, in its unit, is as good as zero


@check_arguments
def step_limit(trajectories: Trajectories, run: int = 0, points: int = POINTS) -> StepLimit:
    """The stability limit of the step along one run, from frozen-time eigenvalues at up to `points` of its kept states.

    A mode lambda with Re lambda < 0 is kept decaying while |R(h lambda)| <= 1, where R is the method's amplification;
    modes that grow by themselves set no limit. A state whose Jacobian is not finite is not counted; if none is left the
    limit, its time and its mode are NaN, and it does not hold.

    Examples
    --------
    >>> from workbench.core import rk4
    >>> from workbench.engine import simulate, step_limit
    >>> plant = wb.open_loop(wb.DCMotor())
    >>> runs = simulate(rk4(plant, 1e-3), plant.parameters.default[None], plant.states.default[None], until=0.1)
    >>> step_limit(runs).h
    0.001
    """
    points = whole("step_limit(points=...)", points)
    run = whole("step_limit(run=...)", run, 0, len(trajectories) - 1)
    return limit_along(trajectories.step, trajectories.t, trajectories.x[run], trajectories.p[run], points)


@dataclass(frozen=True)
@check_arguments
class Accuracy:
    """The relative error of one metric."""

    metric: str
    tolerance: float
    median: float  # over the runs, of the largest error among the metric's numbers
    worst: float
    within: float  # the share of the runs whose error is within the tolerance
    runs: int  # with a value
    lost_runs: int  # without one

    @property
    def is_met(self) -> bool:
        """True if every run that has a value is within the tolerance, and there is one."""
        return self.runs > 0 and self.within == 1

    @property
    def miss(self) -> str:
        """The remark beside a run whose metric is beyond its tolerance, or was not tested against it."""
        if not self.runs:
            return f"{self.metric} not tested against its tolerance {self.tolerance:g}"
        return f"{self.metric} beyond its tolerance {self.tolerance:g}: its error is {self.worst:.1e}"

    def __str__(self) -> str:
        met = "met" if self.is_met else "NOT met" if self.runs else "NOT tested"
        return (
            f"{self.metric}: tolerance {self.tolerance:g} {met} by {100 * self.within:.3g} % of {self.runs:,} runs: "
            f"median {self.median:.1e}, worst {self.worst:.1e}; {self.lost_runs:,} runs have no value."
        )


@dataclass(frozen=True)
@check_arguments
class Check:
    """The accuracy of each metric, and the tightest stability limit along `looked_at` of all `runs`."""

    metrics: tuple[Accuracy, ...]
    limit: StepLimit
    looked_at: int
    runs: int

    @property
    def is_passed(self) -> bool:
        """True if every tolerance is met and no step is beyond its limit."""
        return self.limit.holds and all(accuracy.is_met for accuracy in self.metrics)

    def __str__(self) -> str:
        h, limit = 1000 * self.limit.h, 1000 * self.limit.limit
        verdict = "within" if self.limit.holds else "BEYOND"
        where = f"the step of {h:.3g} ms at {self.limit.at:.4g} s is {verdict} its limit of {limit:.3g} ms"
        along = f"along {self.looked_at} of {self.runs:,} runs"
        return "\n".join([*map(str, self.metrics), f"stability: {where}, {along}."])


def change(fine: Array, coarse: Array, least: float = 0.0) -> Array:
    """|fine - coarse|, but at least the resolution of one step; zero where two infinite values agree."""
    with np.errstate(invalid="ignore"):
        found = np.maximum(np.abs(fine - coarse), least)
    return np.where(np.isinf(fine) & np.isinf(coarse), 0.0, found)


def accuracy(name: str, error: Array, value: Array, tolerance: float) -> Accuracy:
    """The accuracy of a metric with the values (B, ...) and their errors (B, ...).

    An error is relative to the value, but at least to 1e-9 in its unit.
    """
    if not len(value):
        return Accuracy(name, tolerance, np.nan, np.nan, 0.0, 0, 0)
    error, value = error.reshape(len(error), -1), value.reshape(len(value), -1)
    valued = ~np.isnan(value).any(axis=1)
    if not valued.any():
        return Accuracy(name, tolerance, np.nan, np.nan, 0.0, 0, len(value))
    with np.errstate(invalid="ignore"):
        relative = error[valued] / np.maximum(np.abs(value[valued]), NEGLIGIBLE)
    relative = np.where(error[valued] == 0, 0.0, np.nan_to_num(relative, nan=np.inf, posinf=np.inf)).max(axis=1)
    within = float(np.mean(relative <= tolerance))
    return Accuracy(
        name, tolerance, float(np.median(relative)), float(relative.max()), within, len(relative), int((~valued).sum())
    )
