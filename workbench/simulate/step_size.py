"""The step for a stated tolerance, chosen by halving, and the accuracy of metrics: their change as it is halved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from workbench.core import Step
from workbench.simulate.batch import simulate
from workbench.simulate.stability import StepLimit, longest_steps, modes_at
from workbench.simulate.trajectories import Trajectories
from workbench.validation.refusals import Array, Integers
from workbench.validation.signatures import door

NOTHING = 1e-9  # a state or a value that stays below it, in its unit, is as good as zero
PILOTS = 16
STATES = 4  # of a run at which its modes are looked at
HALVINGS = 12

# h -> the step of length h [s], or that of a sampling period with substeps of length h.
Make = Callable[[float], Step]


def pilot_runs(p: Array, x0: Array, count: int = PILOTS) -> Integers:
    """The `count` runs of a batch that serve as its pilots: evenly spaced in the order of their numbers."""
    rows = np.hstack([p, x0])
    rows = rows[:, (rows != rows[:1]).any(axis=0)]
    order = np.lexsort(rows.T[::-1]) if rows.size else np.arange(len(p))
    return np.asarray(order[np.unique(np.linspace(0, len(p) - 1, min(count, len(p))).round().astype(int))])


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
) -> float:
    """The first of `longest`, its half, its quarter and so on in s, at which RK4 keeps a tolerance.

    The change of a state to half the step is taken at the multiples of `longest`, relative to the largest value that
    the state has in the run; then the largest of all states, and the mean over the runs. Integrals of metrics are
    states; the memory of sampled metrics is not asked. A run that diverges tells but the limit of stability, which no
    step exceeds: a step beyond it may lose a run as its half does.

    Parameters
    ----------
    p, x0
        (R, np) and (R, nx), the pilot runs.
    seed
        Of the noise, which is the same at all steps.

    Raises
    ------
    ValueError
        If no pilot run stays finite, or none of the steps keeps the tolerance.
    """
    march = partial(simulate, p=p, x0=x0, until=until, every=longest, seed=seed, arithmetic=arithmetic)
    rough, found = march(make(longest)), np.nan
    for halving in range(halvings):
        fine, h = march(make(longest / 2 ** (halving + 1))), longest / 2**halving
        if not fine.diverged.all():
            found = _relative_change(fine, rough)
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
        f"a state by {found:.1e}. Where a law switches, smaller steps help little: ask for less, or name an `h`."
    )


def _relative_change(fine: Trajectories, rough: Trajectories) -> float:
    """The mean over the runs that last of the largest change of a state, relative to its largest value."""
    lasts, flow = ~fine.diverged, fine.step.flow.states.size
    x, other = (runs.x[lasts, :, :flow] for runs in (fine, rough))
    size = np.maximum(np.abs(x).max(axis=1, keepdims=True), NOTHING)
    with np.errstate(all="ignore"):
        off = np.abs(x - other) / size
    return float(np.nan_to_num(off, nan=np.inf).max(axis=(1, 2), initial=0.0).mean())


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
    """The relative change of one metric as every step is halved.

    Attributes
    ----------
    median, worst
        Over the runs, of the largest change among the metric's numbers.
    within
        The share of the runs whose change is within the tolerance.
    runs, lost
        The numbers of runs with a value at the halved steps, and without one.
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
        """True if every run that has a value is within the tolerance, and there is one."""
        return self.runs > 0 and self.within == 1

    @property
    def miss(self) -> str:
        """The remark beside a run whose metric is beyond its tolerance, or was not tested against it."""
        if not self.runs:
            return f"{self.metric} not tested against its tolerance {self.tolerance:g}"
        return f"{self.metric} beyond its tolerance {self.tolerance:g}: it changes by {self.worst:.1e} at half the step"

    def __str__(self) -> str:
        """One line with the verdict."""
        met = "met" if self.met else "NOT met" if self.runs else "NOT tested"
        return (
            f"{self.metric}: tolerance {self.tolerance:g} {met} by {100 * self.within:.3g} % of {self.runs:,} runs: "
            f"median {self.median:.1e}, worst {self.worst:.1e}; {self.lost:,} runs have no value."
        )


@dataclass(frozen=True)
@door
class Check:
    """The accuracy of each metric, and the tightest stability limit of the `looked_at` runs along which it was taken.

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
        """True if every tolerance is met and no step is beyond its limit."""
        return self.limit.holds and all(accuracy.met for accuracy in self.metrics)

    def __str__(self) -> str:
        """A line for each metric and one for the limit."""
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


def accuracy(name: str, change: Array, value: Array, tolerance: float) -> Accuracy:
    """The accuracy of a metric with the values (B, ...) at the half step that changed so much (B, ...).

    A change is relative to the value, of which less than 1e-9 in its unit is as good as nothing. Where
    there is a value and no change, as the longer step lost the run, the change is infinite.
    """
    change, value = change.reshape(len(change), -1), value.reshape(len(value), -1)
    valued = ~np.isnan(value).any(axis=1)
    if not valued.any():
        return Accuracy(name, tolerance, np.nan, np.nan, 0.0, 0, len(value))
    with np.errstate(invalid="ignore"):
        relative = change[valued] / np.maximum(np.abs(value[valued]), NOTHING)
    relative = np.where(change[valued] == 0, 0.0, np.nan_to_num(relative, nan=np.inf, posinf=np.inf)).max(axis=1)
    within = float(np.mean(relative <= tolerance))
    return Accuracy(
        name, tolerance, float(np.median(relative)), float(relative.max()), within, len(relative), int((~valued).sum())
    )
