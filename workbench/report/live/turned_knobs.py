"""A case of a study run again in Python as its live page runs it, with knobs turned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.core import Ode, SampledSystem, StepMap
from workbench.core.equations import equations_of
from workbench.core.validation.refusals import Array, finite, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear_loop import LinearLoop
from workbench.engine.metrics import Measurement, measure
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.report.live.linear_data import linear_at
from workbench.study.design_knob import DesignKnob
from workbench.study.knob import Knob, has
from workbench.study.pid_specification import knobs_among
from workbench.study.run_and_sweep import Run
from workbench.study.study import Study


@check_arguments
def turn_knobs(study: Study, case: str, values: Mapping[str, float], seed: int | None = None) -> Measurement:
    """The measurement of a case, named 'scenario: law', with knobs of the study turned to `values`, by name.

    It is bit for bit the same as on the page, in the portable arithmetic. `seed` is the seed of the noise, by default
    that of the case.

    Raises
    ------
    LookupError
        If the study has no such case or knob, or the case has nothing that the knob turns.
    ValueError
        If the cases follow from tunings, the case has no step `h`, or a value leads beyond the bounds of a number.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> case = wb.Case("speed", "PI", wb.Run(loop, (wb.rmse(),), until=5.0, h=1e-3))
    >>> knobs = (wb.Knob("Kp", "controller.Kp", 10.0, 1000.0, log=True),)
    >>> study = wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(case,), live=knobs)
    >>> wb.turn_knobs(study, "speed: PI", {"Kp": 50.0}).score("RMSE").value.round(3)
    array([0.151])
    """
    run, equation, step, row = _at_knobs("turn_knobs", study, case, values)
    size = step.parameters.size
    return measure(
        equation,
        run.metrics,
        row[np.newaxis, :size],
        row[np.newaxis, size : size + equation.states.size],
        until=run.until,
        h=run.h,
        every=run.every,
        seed=run.seed if seed is None else seed,
        arithmetic="portable",
    )


@check_arguments
def linear_loop_at_knobs(study: Study, case: str, values: Mapping[str, float]) -> LinearLoop:
    """The linear loop of a case, named 'scenario: law', with knobs of the study turned to `values`, by name.

    The live page shows its Bode plot, poles and margins. The loop is linearised at its equilibrium. If it has none, its
    adaptive gains are held constant, and it is linearised at the equilibrium that it then has. If there is none either,
    it is linearised at its initial state. Which of the three points is used is decided once, for the original numbers.
    If a knob turns an initial state, the search for the equilibrium starts there.

    Raises
    ------
    LookupError
        If the study has no such case or knob, or the case has nothing that the knob turns.
    ValueError
        If the cases follow from tunings, the case has no step `h`, a value leads beyond the bounds of a number, or the
        loop has no linear answer.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> case = wb.Case("speed", "PI", wb.Run(loop, (wb.rmse(),), until=5.0, h=1e-3))
    >>> knobs = (wb.Knob("Kp", "controller.Kp", 10.0, 1000.0, log=True),)
    >>> study = wb.Study("s", "T", "Q?", "M.", lambda results: [], cases=(case,), live=knobs)
    >>> linear = wb.linear_loop_at_knobs(study, "speed: PI", {"Kp": 100.0})
    >>> linear.margins()["v"].margins.phase_margin.value.__round__(2)
    38.67
    """
    run, _, step, row = _at_knobs("linear_loop_at_knobs", study, case, values)
    return linear_at(run.loop, step, row)


def _at_knobs(
    call: str, study: Study, case: str, values: Mapping[str, float]
) -> tuple[Run, Ode | SampledSystem, StepMap, Array]:
    """The run of a case, its equations and step, and its parameters, then states, with the knobs at their values."""
    if callable(study.cases):
        raise ValueError(f"`{call}(study, ...)` needs the cases themselves: take `study.resolve(tuned)`.")
    cases = {one.name: one for one in study.cases}
    run = cases[known_name(case, cases, "cases of this study")].run
    equation = equations_of(run.loop, case)
    if run.h is None:
        raise ValueError(f"`{call}(study, {case!r}, ...)` needs a case with a step; this one's was chosen by pilots.")
    step = MeasuredEquation.of(equation, run.metrics).step(run.h)
    knobs: dict[str, Knob | DesignKnob]
    knobs = {knob.name: knob for knob in knobs_among(study.live) or knobs_of_sweeps(study, [step])}
    row = np.concatenate([step.parameters.default, step.states.default])
    own = row.copy()
    for name, value in values.items():
        knob = knobs[known_name(name, knobs, "knobs of this study")]
        places = [*knob.places(step)]
        if not places:
            raise LookupError(f"`{call}(study, {case!r}, ...)`: the knob '{name}' turns nothing in this case.")
        value = finite(f"{call}(values={{{name!r}: ...}})", value)
        row[places] = knob.numbers_at(value, own[places])
    return run, equation, step, row


def knobs_of_sweeps(study: Study, steps: Sequence[StepMap]) -> tuple[Knob, ...]:
    """The factors of the sweeps of a study, of which some loop has a path; those of one name are one knob.

    A factor along a direction has no knob, as it moves each of its numbers by another amount.
    """
    knobs: dict[str, Knob] = {}
    for sweep in () if callable(study.sweeps) else study.sweeps:
        for factor in sweep.factors:
            if factor.direction is not None:
                continue
            new = Knob.of(factor)
            knobs[new.name] = new.together(knobs.get(new.name, new))
    return tuple(knob for knob in knobs.values() if any(has(step, path) for step in steps for path in knob.paths))
