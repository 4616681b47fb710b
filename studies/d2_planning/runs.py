"""The loops of the comparison: what is drawn for each run, its metrics, and the cost."""

from __future__ import annotations

import casadi as ca
import numpy as np

import workbench as wb
from studies.d2_planning.designs import LOAD, Law
from studies.d2_planning.problems import Knobs, Problem, observer_of

HALF = 0.5  # of the time, that counts as late


def reference_of(problem: Problem) -> wb.Reference:
    """A constant target; its numbers are drawn."""
    if len(problem.tracks) == 1:
        return wb.Constant(problem.tracks[0], problem.output_unit, problem.r0)
    parts = (wb.Constant(name, problem.output_unit, (r,)) for name, r in zip(problem.tracks, problem.r0, strict=True))
    return wb.CombinedReference(tuple(parts))


def loop_of(problem: Problem, law: Law, knobs: Knobs, late: bool = False) -> wb.DigitalLoop:
    """A law in the computer of its problem."""
    plant = problem.plant
    closed = wb.ClosedLoop(
        plant, observer_of(problem, knobs[LOAD.name]), law.block(problem, knobs), reference_of(problem)
    )
    names = plant.inputs.names
    ends = {
        name: (np.array(problem.low), np.array(problem.high)) if len(names) == 1 else (problem.low[i], problem.high[i])
        for i, name in enumerate(names)
    }
    instruments = wb.Instruments.of(plant, noise=dict(problem.noise), quantum=dict(problem.quantum), limit=ends)
    return wb.DigitalLoop(closed, problem.period, instruments, late)


def factors_of(problem: Problem, loop: wb.DigitalLoop) -> tuple[wb.Factor, ...]:
    """All that is drawn for each run: numbers of the plant, its start and the target. The observer starts at zero."""
    target = [f"reference.position[{i}]" for i in (0, 1)]
    if len(problem.tracks) > 1:
        target = [f"reference.parts[{i}].position" for i in (0, 1)]
    return (
        *(wb.Factor(one.name, one.paths, wb.Uniform(one.low, one.high), share=True) for one in problem.unknowns),
        *(
            wb.Factor(f"start of {name}", (f"plant.{name}", estimate_path(name)), wb.Uniform(low, high))
            for name, low, high in problem.starts
        ),
        *(
            wb.Factor(f"target {i + 1}", (path,), wb.Uniform(*ends))
            for i, (path, ends) in enumerate(zip(target, problem.targets, strict=True))
        ),
    )


def estimate_path(state: str) -> str:
    """The path of the first estimate of a state, which is told to the observer."""
    name, bracket, rest = state.partition("[")
    return f"observer.{name}_hat{bracket}{rest}"


def error_names(problem: Problem) -> tuple[str, ...]:
    """The names of the errors of the outputs that follow a reference."""
    one = len(problem.tracks) == 1
    return ("e",) if one else tuple(f"e_{name}" for name in problem.tracks)


def metrics_of(problem: Problem) -> tuple[wb.metrics.AbstractMetric, ...]:
    """The metrics of a run."""
    return (
        *(wb.rmse(name, name=f"RMSE of {name}") for name in error_names(problem)),
        *(late_error(problem, name) for name in error_names(problem)),
        wb.total_variation(problem.period),
    )


def late_error(problem: Problem, name: str) -> wb.metrics.Integral:
    """The root mean square of an error over the second half of a run."""
    return wb.metrics.Integral(
        f"late {name}",
        problem.output_unit,
        "root mean square of e over the second half of the run",
        lambda t, y: ca.if_else(t >= HALF * problem.horizon, y[name] ** 2, 0),
        lambda integral, horizon: np.sqrt(np.maximum(integral, 0) / (HALF * horizon)),
        signals=(name,),
    )


def terms_of(problem: Problem, measurement: wb.metrics.Measurement) -> wb.Array:
    """RMSE, late RMSE and total variation of each run, both signals together, (N, 3); NaN for a run that diverged."""
    heads = ("RMSE", "late", "TV")
    places = [[i for i, one in enumerate(measurement.columns) if one.metric.startswith(head)] for head in heads]
    ends = measurement.values[:, -1, :]
    return np.stack([np.sqrt((ends[:, own] ** 2).sum(axis=1)) for own in places], axis=1)


def cost_of(problem: Problem, terms: wb.Array, weights: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> wb.Array:
    """The sum of the terms in units of what is acceptable, (N,); NaN for a run that is lost."""
    cost = (terms / np.array(problem.acceptable)) @ np.array(weights)
    return np.where(is_lost(problem, terms), np.nan, cost)


def is_lost(problem: Problem, terms: wb.Array) -> wb.Array:
    """True for a run that diverged or ends far from its target, (N,)."""
    return np.asarray(~(terms[:, 1] <= problem.lost_beyond))
