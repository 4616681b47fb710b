"""Run a loop twice, at its step and at half of it: metrics with their errors, and the limit on the step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from math import ceil
from typing import Any

import numpy as np

from workbench.core import Ode, Sampled, Step, rk4
from workbench.metrics.accumulators import common_grid, final_values, maker, resolved
from workbench.metrics.contract import AbstractMetric
from workbench.metrics.measurement import Measurement, Score
from workbench.simulate import StepLimit, Trajectories, simulate, step_limit
from workbench.simulate.batch import progress_of, rows_of, table_of
from workbench.simulate.job import Progress
from workbench.simulate.stability import POINTS, tightest
from workbench.simulate.step_size import (
    HALVINGS,
    PILOTS,
    Check,
    accuracy,
    change,
    pilot_runs,
    step_for_tolerance,
)
from workbench.validation.refusals import Array, Integers, positive, seconds
from workbench.validation.signatures import door

COUNT = 100  # of the longest steps that are tried, in a horizon, or about that many
SUBSTEPS = 7  # halvings of a sampling period at most: all substeps of a period are written out


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

    Of a sampled loop h is the substep, and a part of the period is chosen for it where there is none: the period
    belongs to the controller and is the same in both.

    Parameters
    ----------
    p, x0
        (B, np) and (B, nx) rows as its `parameters.pack` and `states.pack` make them.
    until, h, every
        Horizon, step and distance of the kept states, in s. Without h, `every` bounds the steps too.
    tolerance
        Of the relative change of each metric as the steps are halved: `check` of the result says by which
        metric it is met, and by which it is not. Without h, also that of the change of a state in the pilot runs.
    seed, arithmetic
        Of the noise and of all runs, as `simulate` takes them.

    Raises
    ------
    LookupError
        If a metric watches an output that `equation` does not have.
    ValueError
        If `equation` is none, p or x0 is not as wide as its parameters or states, a metric means nothing
        for it or for the horizon, h does not divide the period of a sampled loop, neither h nor a tolerance
        is given, no step keeps the tolerance, or `simulate` refuses. A tolerance that is missed is no error.

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
    asked = _Asked(equation, metrics, p, x0, until, every, progress_of("measure", progress), arithmetic)
    h = _step_of(asked, tolerance, seed) if h is None else h
    return _judged(metrics, _at_steps(asked, h, seed), tolerance)


@dataclass(frozen=True, eq=False)
class _Asked:
    """The arguments of `measure`, checked except for the steps."""

    equation: Ode | Sampled
    metrics: Sequence[AbstractMetric]
    p: Array | None
    x0: Array | None
    until: float
    every: float | None
    tell: Progress
    arithmetic: str | None


@dataclass(frozen=True, eq=False)
class _Pair:
    """The same runs at the step `h` [s] and at its half, and the stability limits at `h`."""

    coarse: Trajectories
    fine: Trajectories
    h: float
    limits: tuple[StepLimit, ...]
    looked_at: Integers


def _at_steps(asked: _Asked, h: float, seed: int) -> _Pair:
    """The runs at the step h and at its half."""
    make = maker(asked.equation, asked.metrics)
    coarse, fine = make(h), make(h / 2)
    every = coarse.h if asked.every is None else asked.every
    call = partial(simulate, p=asked.p, x0=_extended(asked.x0, fine), until=asked.until, every=every, seed=seed)
    # the longer run first: from it the engine sees how good its code should be
    call = partial(call, arithmetic=asked.arithmetic)
    b = call(fine, progress=lambda done: asked.tell(2 * done / 3))
    a = call(coarse, progress=lambda done: asked.tell((2 + done) / 3))
    looked_at = _looked_at(a.p, a.x[:, 0])
    return _Pair(a, b, coarse.h, _limits(a, looked_at), looked_at)


def _step_of(asked: _Asked, tolerance: float | None, seed: int) -> float:
    """The step, or the substep of a sampled loop, that keeps the tolerance in a few of the runs, in s."""
    if tolerance is None:
        raise ValueError(
            "`measure(...)` needs a step `h`, or a `tolerance` for which pilot runs choose it; got neither."
        )
    equation = asked.equation
    step = equation.step() if isinstance(equation, Sampled) else rk4(equation, asked.until)
    p, x0 = rows_of("measure", step, asked.p, asked.x0)
    few = pilot_runs(p, x0)
    every = None if asked.every is None else seconds("measure(every=...)", asked.every)
    how = (asked.until, every, tolerance, seed, asked.arithmetic)
    return chosen_step(equation, asked.metrics, p[few], x0[few], *how)


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
    if isinstance(equation, Sampled):
        longest, halvings = equation.period, SUBSTEPS
    else:
        unit = common_grid(metrics, until, *([] if every is None else [every])) or every or until
        longest, halvings = unit / ceil(COUNT * unit / until), HALVINGS
    start = _extended(x0, make(longest))
    assert start is not None
    return step_for_tolerance(
        make, p, start, until, tolerance, longest, halvings=halvings, seed=seed, arithmetic=arithmetic
    )


def _judged(metrics: Sequence[AbstractMetric], pair: _Pair, tolerance: float | None) -> Measurement:
    """The metrics of both runs of each pair held against one another, and against the tolerance."""
    values, rough = final_values(pair.fine, metrics), final_values(pair.coarse, metrics)
    scores = {
        m.name: Score(m, values[m.name], change(values[m.name], rough[m.name], pair.h if m.is_time else 0.0))
        for m in metrics
    }
    check = None
    if tolerance is not None:
        found = tuple(accuracy(name, score.error, score.value, tolerance) for name, score in scores.items())
        check = Check(found, tightest(pair.limits), len(pair.limits), len(pair.fine))
    return Measurement(pair.fine, scores, pair.limits, pair.looked_at, pair.coarse.diverged_at, check=check)


def _looked_at(p: Array, x0: Array) -> Integers:
    """The runs along which a limit, which is costly, is taken: all of a few, pilots of more."""
    return np.arange(len(p)) if len(p) <= PILOTS else np.sort(pilot_runs(p, x0))


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


def _extended(rows: Array | None, step: Step) -> Array | None:
    """Initial states of the loop with those of the metrics behind them."""
    if rows is None:
        return None
    rest = step.states.default[rows.shape[1] :]
    return np.hstack([rows, np.tile(rest, (len(rows), 1))])
