"""The length of a step: its limit along a run, the step for a tolerance, and the accuracy of metrics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from workbench.core import Step
from workbench.simulate.batch import run_step
from workbench.simulate.stability import StepLimit, limit_along, longest_steps, modes_at
from workbench.simulate.trajectories import Trajectories
from workbench.validation.refusals import Array, whole
from workbench.validation.signatures import door

POINTS = 400  # of a run, at which its Jacobian is looked at
NOTHING = 1e-9  # a state or a value that stays below it, in its unit, is as good as zero
STATES = 4  # of a run at which its modes are looked at
HALVINGS = 12

# h -> the step of length h [s], or that of a sampling period with substeps of length h.
Make = Callable[[float], Step]


@door
def step_limit(trajectories: Trajectories, run: int = 0, points: int = POINTS) -> StepLimit:
    """The stability limit of the step along one run, from frozen-time eigenvalues at up to `points` of its kept states.

    A mode lambda with Re lambda < 0 is kept decaying while |R(h lambda)| <= 1, where R is the method's amplification;
    modes that grow by themselves set no limit. A state whose Jacobian is not finite is not counted; if none is left the
    limit, its time and its mode are NaN, and it does not hold.
    """
    points = whole("step_limit(points=...)", points)
    run = whole("step_limit(run=...)", run, 0, len(trajectories) - 1)
    return limit_along(trajectories.step, trajectories.t, trajectories.x[run], trajectories.p[run], points)


def step_for_tolerance(
    make: Make,
    p: Array,
    x0: Array,
    until: float,
    tolerance: float,
    longest: float,
    *,
    halvings: int = HALVINGS,
    seed: int = 0,
    arithmetic: str | None = None,
    keep_lost: bool = False,
) -> float:
    """The first of `longest`, its half, its quarter and so on in s, at which RK4 keeps a tolerance.

    The change of a state to half the step is taken at the multiples of `longest`, relative to the largest value that
    the state has in the run; then the largest of all states, and the mean over the pilot runs p (R, np), x0 (R, nx).
    The memory of sampled metrics is not asked. A run that diverges tells but the limit of stability, which no step
    exceeds. With `keep_lost`, where every run diverges, the change is that of the times at which they do, in horizons.

    Raises
    ------
    ValueError
        If no pilot run stays finite, unless `keep_lost`, or none of the steps keeps the tolerance.
    """
    march = partial(run_step, p=p, x0=x0, until=until, every=longest, seed=seed, arithmetic=arithmetic)
    rough, found = march(make(longest)), np.nan
    for halving in range(halvings):
        fine, h = march(make(longest / 2 ** (halving + 1))), longest / 2**halving
        if keep_lost or not fine.diverged.all():
            found = _lost_change(fine, rough, until) if fine.diverged.all() else _relative_change(fine, rough)
            if found <= tolerance and h <= _limit(fine):
                return float(h)
        rough = fine
    if np.isnan(found):
        raise ValueError(
            f"No step `h` can be chosen: none of the {len(p)} pilot runs stays finite up to {until:g} s at steps down "
            f"to {longest / 2**halvings:.2g} s. The loop runs away, or one of its modes is too fast for these: name a "
            "shorter `h`."
        )
    raise ValueError(
        f"No step `h` keeps the tolerance of {tolerance:g}: that of {longest / 2 ** (halvings - 1):g} s still changes "
        f"a state by {found:.1e}. Where a law switches, smaller steps help little: ask for less, or name the step."
    )


def _relative_change(fine: Trajectories, rough: Trajectories) -> float:
    """The mean over the runs that last of the largest change of a state, relative to its largest value."""
    lasts, flow = ~fine.diverged, fine.step.flow.states.size
    x, other = (runs.x[lasts, :, :flow] for runs in (fine, rough))
    size = np.maximum(np.abs(x).max(axis=1, keepdims=True), NOTHING)
    with np.errstate(all="ignore"):
        off = np.abs(x - other) / size
    return float(np.nan_to_num(off, nan=np.inf).max(axis=(1, 2), initial=0.0).mean())


def _lost_change(fine: Trajectories, rough: Trajectories, until: float) -> float:
    """The mean change of the times at which runs diverge, in horizons; infinite if one lasts at the longer step."""
    off = np.abs(fine.diverged_at - rough.diverged_at) / until
    return float(np.nan_to_num(off, nan=np.inf).mean())


def _limit(runs: Trajectories) -> float:
    """The longest stable step at the start of every run, and at some states of those that last, in s."""
    step, some = runs.step, np.unique(np.linspace(0, len(runs.t) - 1, STATES).round().astype(int))
    lasts = np.flatnonzero(~runs.diverged)
    run = np.concatenate([np.arange(len(runs.p)), np.repeat(lasts, len(some))])
    at = np.concatenate([np.zeros(len(runs.p), dtype=int), np.tile(some, len(lasts))])
    modes = modes_at(step.flow, runs.t[at], runs.x[run, at, : step.flow.states.size], runs.p[run])
    return float(np.nanmin(longest_steps(modes[np.isfinite(modes).all(axis=1)], step.amplification), initial=np.inf))


@dataclass(frozen=True)
@door
class Accuracy:
    """The relative error of one metric."""

    metric: str
    tolerance: float
    median: float  # over the runs, of the largest error among the metric's numbers
    worst: float
    within: float  # the share of the runs whose error is within the tolerance
    runs: int  # with a value
    lost: int  # without one

    @property
    def met(self) -> bool:
        """True if every run that has a value is within the tolerance, and there is one."""
        return self.runs > 0 and self.within == 1

    @property
    def miss(self) -> str:
        """The remark beside a run whose metric is beyond its tolerance, or was not tested against it."""
        if not self.runs:
            return f"{self.metric} not tested against its tolerance {self.tolerance:g}"
        return f"{self.metric} beyond its tolerance {self.tolerance:g}: its error is {self.worst:.1e}"

    def __str__(self) -> str:
        met = "met" if self.met else "NOT met" if self.runs else "NOT tested"
        return (
            f"{self.metric}: tolerance {self.tolerance:g} {met} by {100 * self.within:.3g} % of {self.runs:,} runs: "
            f"median {self.median:.1e}, worst {self.worst:.1e}; {self.lost:,} runs have no value."
        )


@dataclass(frozen=True)
@door
class Check:
    """The accuracy of each metric, and the tightest stability limit along `looked_at` of all `runs`."""

    metrics: tuple[Accuracy, ...]
    limit: StepLimit
    looked_at: int
    runs: int

    @property
    def passed(self) -> bool:
        """True if every tolerance is met and no step is beyond its limit."""
        return self.limit.holds and all(accuracy.met for accuracy in self.metrics)

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
    error, value = error.reshape(len(error), -1), value.reshape(len(value), -1)
    valued = ~np.isnan(value).any(axis=1)
    if not valued.any():
        return Accuracy(name, tolerance, np.nan, np.nan, 0.0, 0, len(value))
    with np.errstate(invalid="ignore"):
        relative = error[valued] / np.maximum(np.abs(value[valued]), NOTHING)
    relative = np.where(error[valued] == 0, 0.0, np.nan_to_num(relative, nan=np.inf, posinf=np.inf)).max(axis=1)
    within = float(np.mean(relative <= tolerance))
    return Accuracy(
        name, tolerance, float(np.median(relative)), float(relative.max()), within, len(relative), int((~valued).sum())
    )
