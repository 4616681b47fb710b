"""The measurement of a loop: its metrics at a step, with their errors, and the limit on the step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.core import Ode, SampledSystem, rk4
from workbench.core.equations import LOOP, Loop, equations_of, is_loop
from workbench.core.validation.refusals import Array, multiple, positive, refusal, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.engine.batch import progress_of, rows_of, table_of
from workbench.engine.job import Progress
from workbench.engine.metrics.contract import AbstractMetric
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.engine.metrics.measured_run import MeasuredRun, arithmetic_for, points_of
from workbench.engine.metrics.measurement import Measurement
from workbench.engine.metrics.score import Score
from workbench.engine.metrics.step_for_metrics import step_for
from workbench.engine.pilot_selection import pilot_runs
from workbench.engine.step_choice import StepChoice

__all__ = ["Measurement", "Score", "measure"]

TOLERANCE = 1e-3  # for which a step is chosen, where none is given


@check_arguments
def measure(
    equation: Ode | SampledSystem | Loop,
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
    """Simulate a loop or its equation at the step h and compute metrics, with errors from h / 2.

    Parameters
    ----------
    p, x0
        Rows (B, np) and (B, nx), as its `parameters.pack` and `states.pack` make them; by default one row of defaults.
    until, h, every
        Horizon, step of the values (or substep of a sampled loop) and time between kept states, in s; `every` bounds h.
    tolerance
        The largest error of each metric relative to its value; without metrics, the largest change of the states.
        Without h, pilot runs choose the step for this tolerance, by default 0.001.
    seed, progress, arithmetic
        As of `simulate`.

    Raises
    ------
    LookupError
        If a metric watches an output that `equation` does not have.
    ValueError
        If p or x0 is not as wide as its parameters or states, a metric is not defined for it or for the horizon, h does
        not divide the period of a sampled loop, no step keeps the tolerance, or `simulate` refuses.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> found = wb.measure(loop.ode(), [wb.rmse(), wb.effort()], until=2.0, h=1e-3)
    >>> found.score("RMSE").value.round(3), found.score("effort", "v").value.round(1)
    (array([0.194]), array([22.6]))
    """
    equation = _equations(equation)
    measured = MeasuredEquation.of(equation, metrics, seconds("measure(until=...)", until))
    p, x0 = _rows(equation, until, p, x0)
    tolerance = None if tolerance is None else positive("measure(tolerance=...)", tolerance)
    every = None if every is None else seconds("measure(every=...)", every)
    tell, runs, choice, method = progress_of("measure", progress), np.arange(len(p)), None, "rk4"
    if h is None:
        choice = _choice(measured, p, x0, until, every, tolerance := tolerance or TOLERANCE, seed, arithmetic)
        h, method = choice.h, choice.method
    multiple("measure(until=...)", until, (step := measured.step(h, method)).h, "the step")
    how = seed, arithmetic_for(step, arithmetic), method, points_of(len(p))
    run = MeasuredRun(measured, h, until, every or step.h, until, *how)
    found, trajectories = run.march(p, x0, runs, runs, tell)
    return run.measurement(found, p, runs, tolerance=tolerance, choice=choice, kept_runs=trajectories)


def _equations(equation: Ode | SampledSystem | Loop) -> Ode | SampledSystem:
    if not is_loop(equation):
        raise refusal("measure(equation=...)", LOOP, equation)
    return equations_of(equation, "loop")


def _choice(
    measured_equation: MeasuredEquation,
    p: Array,
    x0: Array,
    until: float,
    every: float | None,
    tolerance: float,
    seed: int,
    arithmetic: str | None,
) -> StepChoice:
    """The step at which the pilots of the runs keep the tolerance."""
    few = pilot_runs(p, x0)
    return step_for(
        measured_equation,
        p[few],
        x0[few],
        until=until,
        every=every,
        tolerance=tolerance,
        seed=seed,
        arithmetic=arithmetic,
    )


def _rows(equation: Ode | SampledSystem, until: float, p: Array | None, x0: Array | None) -> tuple[Array, Array]:
    """The rows (B, np) and (B, nx) of all runs; an equation without states has metrics to integrate all the same."""
    (equation.flow if isinstance(equation, SampledSystem) else equation).refuse_beyond("measure(until=...)", until)
    p = None if p is None else table_of("measure(p=...)", equation.parameters, p)
    x0 = None if x0 is None else table_of("measure(x0=...)", equation.states, x0)
    if not equation.states.size:
        p = table_of("measure(p=...)", equation.parameters, p)
        return p, np.empty((len(p), 0))
    return rows_of("measure", equation.step(1) if isinstance(equation, SampledSystem) else rk4(equation, until), p, x0)
