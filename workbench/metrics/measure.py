"""The measurement of a loop at its step and at half of it: metrics with their errors, and the limit on the step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from workbench.core import Ode, Sampled, Step, rk4
from workbench.metrics.accumulators import final_values, maker, resolved
from workbench.metrics.contract import AbstractMetric
from workbench.metrics.step_for_metrics import choose_step, extended
from workbench.metrics.unseen_pulses import unseen_pulses
from workbench.simulate import StepLimit, Trajectories, simulate, step_limit, step_size
from workbench.simulate.batch import progress_of, rows_of, table_of
from workbench.simulate.job import Progress
from workbench.simulate.pilots import PILOTS, pilot_runs
from workbench.simulate.stability import beyond, tightest
from workbench.simulate.step_choice import Choice
from workbench.simulate.step_size import POINTS, Check
from workbench.validation.notebook_display import listed, table_to_html
from workbench.validation.refusals import Array, Integers, positive, seconds
from workbench.validation.signatures import door

HEAD = ("metric", "of", "unit", "least", "mean", "largest", "error")


@dataclass(frozen=True, eq=False)
@door
class Score:
    """A metric of B runs, (B, k), and its error: the change from the step to half of it.

    For a smooth loop the change is about 15 times the error of the value; where switching makes the method first order
    it tells the size of the error and bounds nothing. A time is known to one step at best. A run that diverged has NaN
    in both.
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
        return table_to_html("", HEAD, self.rows)


@dataclass(frozen=True, eq=False)
@door
class Measurement:
    """Trajectories and metrics of a loop at half the step, their change from the whole step, and limits on the step."""

    trajectories: Trajectories
    scores: Mapping[str, Score]
    limits: tuple[StepLimit, ...]  # of the whole steps, along the runs `looked_at`
    looked_at: Integers  # all of up to 16 runs, 16 pilots of more
    coarse_diverged_at: Array  # (B,), at the whole step
    check: Check | None = None  # that each metric changed by no more than the tolerance that was asked for

    def __repr__(self) -> str:
        """One line: the runs, the metrics, and the warnings."""
        return f"<Measurement of {len(self.trajectories)} runs: {self.summary}>"

    def _repr_html_(self) -> str:
        rows = [row for score in self.scores.values() for row in score.rows]
        return table_to_html(repr(self)[1:-1], HEAD, rows)

    @property
    def summary(self) -> str:
        """The names of the metrics, and the warnings."""
        return "; ".join([listed(list(self.scores)), *self.warnings])

    @property
    def warnings(self) -> tuple[str, ...]:
        """The sentences on the runs that diverged, a step beyond its limit, and the metrics that miss a tolerance."""
        missed = () if self.check is None else tuple(one.miss for one in self.check.metrics if not one.met)
        return tuple(filter(None, (self.trajectories.losses, beyond(tightest(self.limits)), *missed, *self.unseen)))

    @cached_property
    def unseen(self) -> tuple[str, ...]:
        """The sentences on metrics that may miss a pulse between two steps."""
        return unseen_pulses(self.trajectories, [score.metric for score in self.scores.values()], self.looked_at)

    @property
    def h(self) -> float:
        """The step at which the values were taken, in s; of a sampled loop the substep."""
        return self.trajectories.step.h / self.trajectories.step.substeps


@door
def measure(
    equation: Ode | Sampled,
    metrics: Sequence[AbstractMetric],
    p: Array | None = None,
    x0: Array | None = None,
    *,
    until: float,
    h: float | None = None,
    every: float | None = None,
    tolerance: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    arithmetic: str | None = None,
) -> Measurement:
    """Simulate `equation` at the step h and at h / 2 and score both; without h, at a step chosen by pilot runs.

    Parameters
    ----------
    p, x0
        (B, np) and (B, nx) rows as its `parameters.pack` and `states.pack` make them.
    until, h, every
        Horizon, step (of a sampled loop the substep) and distance of the kept states, in s. Without h, `every` bounds
        the steps too.
    tolerance
        Of the relative change of each metric from h to h / 2; without h, also of the states in the pilot runs.
    seed, arithmetic
        Of the noise and of all runs, as `simulate` takes them.

    Raises
    ------
    LookupError
        If a metric watches an output that `equation` does not have.
    ValueError
        If p or x0 is not as wide as its parameters or states, a metric means nothing for it or for the horizon, h does
        not divide the period of a sampled loop, neither h nor a tolerance is given, no step keeps the tolerance, or
        `simulate` refuses. A tolerance that is missed is no error.

    Examples
    --------
    >>> law = wb.PID2(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> scores = wb.measure(loop.ode(), [wb.rmse(), wb.effort()], until=2.0, h=1e-3).scores
    >>> scores["RMSE"].value.round(3), scores["effort"].value.round(1)
    (array([[0.194]]), array([[22.6]]))
    """
    metrics = resolved(equation, metrics, seconds("measure(until=...)", until))
    (equation.flow if isinstance(equation, Sampled) else equation).refuse_beyond("measure(until=...)", until)
    p = None if p is None else table_of("measure(p=...)", equation.parameters, p)
    x0 = None if x0 is None else table_of("measure(x0=...)", equation.states, x0)
    if tolerance is not None:
        tolerance = positive("measure(tolerance=...)", tolerance)
    tell, method = progress_of("measure", progress), "rk4"
    if h is None:
        choice = _choice(equation, metrics, p, x0, until, every, tolerance, seed, arithmetic)
        h, method = choice.h, choice.method
    how = {"p": p, "until": until, "every": every, "seed": seed, "arithmetic": arithmetic}
    return _judged(metrics, *_both(maker(equation, metrics, method), h, x0, tell, how), tolerance)


def _both(
    make: Callable[[float], Step], h: float, x0: Array | None, tell: Progress, how: dict[str, Any]
) -> tuple[Trajectories, Trajectories]:
    coarse, fine = make(h), make(h / 2)
    every = coarse.h if how["every"] is None else how["every"]
    x0 = None if x0 is None else extended(x0, fine)
    call: Any = partial(simulate, x0=x0, **(how | {"every": every}))
    # the longer run first: from it the engine sees how good its code should be
    b = call(fine, progress=lambda done: tell(2 * done / 3))
    a = call(coarse, progress=lambda done: tell((2 + done) / 3))
    return a, b


def _choice(
    equation: Ode | Sampled,
    metrics: Sequence[AbstractMetric],
    p: Array | None,
    x0: Array | None,
    until: float,
    every: float | None,
    tolerance: float | None,
    seed: int,
    arithmetic: str | None,
) -> Choice:
    """The step that keeps the tolerance in a few of the runs."""
    if tolerance is None:
        raise ValueError(
            "`measure(...)` needs a step `h`, or a `tolerance` for which pilot runs choose it; got neither."
        )
    step = equation.step(1) if isinstance(equation, Sampled) else rk4(equation, until)
    p, x0 = rows_of("measure", step, p, x0)
    few = pilot_runs(p, x0)
    every = None if every is None else seconds("measure(every=...)", every)
    how: Any = {"until": until, "every": every, "tolerance": tolerance, "seed": seed, "arithmetic": arithmetic}
    return choose_step(equation, metrics, p[few], x0[few], **how)


def _judged(
    metrics: Sequence[AbstractMetric], coarse: Trajectories, fine: Trajectories, tolerance: float | None
) -> Measurement:
    """The metrics of both runs held against one another, and against the tolerance."""
    h, values, rough = coarse.step.h, final_values(fine, metrics), final_values(coarse, metrics)
    scores = {
        m.name: Score(m, values[m.name], step_size.change(values[m.name], rough[m.name], h if m.is_time else 0.0))
        for m in metrics
    }
    # a limit is costly: along all of a few runs, along pilots of more
    few = len(coarse) <= PILOTS
    looked_at = np.arange(len(coarse)) if few else np.sort(pilot_runs(coarse.p, coarse.x[:, 0]))
    limits, check = _limits(coarse, looked_at), None
    if tolerance is not None:
        found = tuple(step_size.accuracy(name, score.error, score.value, tolerance) for name, score in scores.items())
        check = Check(found, tightest(limits), len(limits), len(fine))
    return Measurement(fine, scores, limits, looked_at, coarse.diverged_at, check=check)


def _limits(runs: Trajectories, looked_at: Integers) -> tuple[StepLimit, ...]:
    """The limit along some of the runs, which are run again where few of their states were kept."""
    stride, kept = runs.job.stride, runs.x.shape[1] - 1
    finer = next((n for n in range(stride, 1, -1) if stride % n == 0 and kept * stride >= POINTS * n), 1)
    if kept < POINTS and finer < stride:
        job, h = runs.job, runs.step.h
        keys: Any = job.runs[looked_at]
        few = partial(simulate, job.step, job.p[looked_at], runs.x[looked_at, 0], seed=job.seed, runs=keys)
        few = partial(few, arithmetic=job.arithmetic)
        runs, looked_at = few(until=kept * stride * h, every=finer * h), np.arange(len(looked_at))
    return tuple(step_limit(runs, int(i)) for i in looked_at)
