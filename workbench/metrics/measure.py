"""Run a loop twice, at its steps and at half of each: metrics with their errors, and the limit on the step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from math import ceil
from typing import Any

import numpy as np

from workbench.core import Ode, Sampled, Step
from workbench.metrics.accumulators import common_grid, final_values, maker, resolved
from workbench.metrics.contract import AbstractMetric
from workbench.metrics.measurement import Measurement, Score
from workbench.simulate import StepLimit, Trajectories, choose, run, simulate, simulate_alike, simulate_both, step_limit
from workbench.simulate.job import Progress
from workbench.simulate.marches import arithmetic_of
from workbench.simulate.request import rows_of, table_of, told
from workbench.simulate.stepping.accuracy import Check, accuracy, change
from workbench.simulate.stepping.cells import COUNT
from workbench.simulate.stepping.pilot import RUNS, Choice, pilot_runs
from workbench.simulate.stepping.single import HALVINGS, single_step
from workbench.simulate.stepping.stability import POINTS, schedule_limits, tightest
from workbench.validation.doors import door
from workbench.validation.words import Array, Integers, positive, seconds

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
    """Simulate `equation` at the step h and at h / 2 and score both; without h, at steps that a pilot chooses.

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
        metric it is met, and by which it is not. Without h, also that of the pilot's local errors.
    seed, arithmetic
        Of the noise and of all runs, as `simulate` takes them.

    Raises
    ------
    LookupError
        If a metric watches an output that `equation` does not have.
    ValueError
        If `equation` is none, p or x0 is not as wide as its parameters or states, a metric means nothing
        for it or for the horizon, h does not divide the period of a sampled loop, neither h nor a tolerance
        is given, or `simulate` or `choose` refuses. A tolerance that is missed is no error: it is said.

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
    asked = _Asked(equation, metrics, p, x0, until, every, told("measure", progress), arithmetic)
    pair = _at_choice(asked, tolerance, seed) if h is None else _at_steps(asked, h, seed)
    return _judged(metrics, pair, tolerance)


@door
def measure_alike(
    equations: Sequence[Ode | Sampled],
    metrics: Sequence[Sequence[AbstractMetric]],
    *,
    until: Sequence[float],
    h: float,
    every: float | None = None,
    tolerance: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    arithmetic: str | None = None,
) -> list[Measurement]:
    """What `measure` makes of each of several equations; where they are much alike, in the time of a few of them.

    Variants of one law are alike, and so is one law with other numbers or in another scenario. What a run gives is
    what it gives alone, to the last bit.

    Parameters
    ----------
    metrics, until
        Of each equation its own.

    Raises
    ------
    LookupError, ValueError
        If `measure` refuses one of them.
    """
    for name, given, of in (("metrics", metrics, "metrics"), ("until", until, "a horizon")):
        if len(given) != len(equations):
            raise ValueError(
                f"`measure_alike({name}=...)` needs {of} for each of the {len(equations)} equations; got {len(given)}."
            )
    h = seconds("measure_alike(h=...)", h)
    if tolerance is not None:
        tolerance = positive("measure_alike(tolerance=...)", tolerance)
    if not equations:
        return []
    asked = zip(equations, metrics, until, strict=True)
    wanted = [resolved(of, some, seconds("measure(until=...)", end)) for of, some, end in asked]
    makers = [maker(equation, of) for equation, of in zip(equations, wanted, strict=True)]
    steps = [(make("rk4", h), make("rk4", h / 2)) for make in makers]
    every = steps[0][0].h if every is None else every
    runs = simulate_alike(steps, until=until, every=every, seed=seed, progress=progress, arithmetic=arithmetic)
    return [_judged(of, _pair(*both), tolerance) for of, both in zip(wanted, runs, strict=True)]


@dataclass(frozen=True, eq=False)
class _Asked:
    """What `measure` is to run, checked but for its steps."""

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
    """The same runs at some steps, of which `h` [s] is the longest, and at their halves; and the former's limits."""

    coarse: Trajectories
    fine: Trajectories
    h: float
    limits: tuple[StepLimit, ...]
    looked_at: Integers
    choice: Choice | None = None


def _at_steps(asked: _Asked, h: float, seed: int) -> _Pair:
    """At the step h and at its half."""
    make = maker(asked.equation, asked.metrics)
    coarse, fine = make("rk4", h), make("rk4", h / 2)
    every = coarse.h if asked.every is None else asked.every
    call = partial(simulate_both, coarse, fine, asked.p, _extended(asked.x0, fine), until=asked.until, every=every)
    return _pair(*call(seed=seed, progress=asked.tell, arithmetic=asked.arithmetic))


def _pair(coarse: Trajectories, fine: Trajectories) -> _Pair:
    """Runs at a step and at its half, with the limits of the step."""
    looked_at = _looked_at(coarse.p, coarse.x[:, 0])
    return _Pair(coarse, fine, coarse.step.h, _limits(coarse, looked_at), looked_at)


def _at_choice(asked: _Asked, tolerance: float | None, seed: int) -> _Pair:
    """Through the schedule that a pilot chooses for the tolerance, or at a substep of a sampled loop, and at half."""
    if tolerance is None:
        raise ValueError(
            "`measure(...)` needs a step `h`, or a `tolerance` for which a pilot chooses the steps; got neither."
        )
    if isinstance(asked.equation, Sampled):
        return _at_steps(asked, _substep(asked, asked.equation, tolerance, seed), seed)
    make, until, every = cache(maker(asked.equation, asked.metrics)), asked.until, asked.every
    grid = common_grid(asked.metrics, until, *(() if every is None else (seconds("measure(every=...)", every),)))
    step = make("rk4", grid or until)
    p, x0 = rows_of("measure", step, asked.p, _extended(asked.x0, step))
    few = pilot_runs(p, x0)
    arithmetic = arithmetic_of(step, len(p), asked.arithmetic)  # one for the pilot, both schedules and their limits
    cell = _cell(until, every, grid)
    choice = choose(make, p[few], x0[few], until, tolerance, cell=cell, grid=grid, arithmetic=arithmetic)
    schedule = choice.schedule
    kept = 1 if every is None else round(every / schedule.cell)
    b = run(schedule, make, p, x0, kept, lambda d: asked.tell(d / 3), arithmetic)
    a = run(schedule.halved, make, p, x0, kept, lambda d: asked.tell((1 + 2 * d) / 3), arithmetic)
    looked_at = _looked_at(p, x0)
    limits = schedule_limits(schedule, make, p[looked_at], x0[looked_at], arithmetic)
    return _Pair(b, a, schedule.longest, limits, looked_at, choice)


def _substep(asked: _Asked, loop: Sampled, tolerance: float, seed: int) -> float:
    """The substep of a sampled loop that keeps the tolerance in a few of the runs, in s."""
    p, x0 = rows_of("measure", loop.step(), asked.p, asked.x0)
    few = pilot_runs(p, x0)
    return chosen_step(loop, asked.metrics, p[few], x0[few], asked.until, None, tolerance, seed, asked.arithmetic)


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
    start = _extended(x0, make("rk4", longest))
    assert start is not None
    return single_step(make, p, start, until, tolerance, longest, halvings=halvings, seed=seed, arithmetic=arithmetic)


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
    return Measurement(
        pair.fine, scores, pair.limits, pair.looked_at, pair.coarse.diverged_at, check=check, choice=pair.choice
    )


def _looked_at(p: Array, x0: Array) -> Integers:
    """The runs along which a limit is taken, which costs as much as a thousand runs: all of a few, pilots of more."""
    return np.arange(len(p)) if len(p) <= RUNS else np.sort(pilot_runs(p, x0))


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


def _cell(until: float, every: float | None, grid: float | None) -> float | None:
    """A part of `every` that is a multiple of the grid, such that the horizon has about as many as usual."""
    if every is None:
        return None
    kept, most = until / every, COUNT if grid is None else round(every / grid)
    if abs(kept - round(kept)) > 1e-6 or round(kept) < 1:
        raise ValueError(f"`measure(until=...)` must be a multiple of `every` = {every:g} s; got {until:g} s.")
    parts = (n for n in range(1, min(most, COUNT) + 1) if grid is None or most % n == 0)
    return every / min(parts, key=lambda n: abs(np.log(kept * n / COUNT)))


def _extended(rows: Array | None, step: Step) -> Array | None:
    """Initial states of the loop with those of the metrics behind them."""
    if rows is None:
        return None
    rest = step.states.default[rows.shape[1] :]
    return np.hstack([rows, np.tile(rest, (len(rows), 1))])
