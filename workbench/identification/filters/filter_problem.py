"""A stochastic model and a log, joined to what a filter runs over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy.linalg

from workbench.core import Layout, Ode, SampledSystem
from workbench.core.step import StepMap
from workbench.core.validation.refusals import Array, one_of
from workbench.identification.datasets import Dataset
from workbench.identification.filters.array_steps import square_root
from workbench.identification.filters.discrete_model import DiscreteModel
from workbench.identification.filters.filter_columns import FilterColumns, LogReading, columns_of
from workbench.identification.filters.filter_input import covariance, initial_mean
from workbench.identification.filters.motions import AbstractMotion, MapExpressions, MapMotion, OdeMotion
from workbench.identification.filters.parameter_walk import starts_of, with_walks
from workbench.identification.filters.stochastic_model import StochasticModel

HOLDS = ("hold", "linear")


@dataclass(frozen=True, eq=False)
class FilterProblem:
    """The mean and covariances of a filter, and its motion for a number of steps between two samples."""

    x0: Array
    P0: Array
    R: Array
    states: Layout
    motion: Callable[[int], AbstractMotion]
    has_parts: bool  # True for an `Ode`
    remarks: tuple[str, ...] = ()  # on the log

    def remarks_on(self, x: Array) -> tuple[str, ...]:
        """The remarks on the log, and one for each state whose estimates (N, n) leave the bounds that it declares."""
        remarks, rows = list(self.remarks), x[np.isfinite(x).all(axis=1)]
        for entry in self.states.entries:
            if entry.bounds.symmetric or not len(rows):
                continue
            outside = np.logical_not(entry.bounds.allow(rows[:, self.states.slice(entry.name)]))
            if outside.any():
                remarks.append(
                    f"'{entry.name}' must be {entry.bounds}, and {int(outside.any(axis=1).sum())} of {len(rows)} "
                    "estimates are not: its variance is too large for a linearised filter."
                )
        return tuple(remarks)


def problem_of(call: str, log: Dataset, model: StochasticModel, reading: LogReading) -> FilterProblem:
    """The problem of a log and a model."""
    one_of(f"{call}(hold=...)", reading.hold, HOLDS)
    if isinstance(model.equations, Ode):
        return _of_ode(call, log, model, model.equations, reading)
    step = model.equations.step() if isinstance(model.equations, SampledSystem) else model.equations
    inputs = step.inputs.names if isinstance(step, DiscreteModel) else step.flow.inputs
    columns = columns_of(call, log, reading, model.parameters, inputs, step.outputs)
    base = model.parameters.default if model.p is None else model.p
    rows = np.array(np.broadcast_to(base, (len(columns.t), base.size)))
    rows[:, [model.parameters.labels.index(label) for label in columns.input_labels]] = columns.u
    noise = square_root(covariance(call, "Q", model.Q, step.states.size))
    if isinstance(step, DiscreteModel):
        expressions, k = MapExpressions.of_model(step), np.arange(len(rows), dtype=float)
    else:
        expressions, k = _of_step(call, step, columns), _numbers(call, step, columns.t)
    return FilterProblem(
        *_start(call, model, columns),
        step.states,
        lambda _: MapMotion(step.states, columns, expressions, rows, k, noise),
        has_parts=False,
        remarks=columns.remarks,
    )


def _start(call: str, model: StochasticModel, columns: FilterColumns) -> tuple[Array, Array, Array]:
    """x0, P0 and R, whose size must be the number of outputs that are read."""
    n = model.equations.states.size
    return (
        initial_mean(call, model.x0, n),
        covariance(call, "P0", model.P0, n),
        covariance(call, "R", model.R, columns.outputs.size, definite=True),
    )


def _of_ode(call: str, log: Dataset, model: StochasticModel, ode: Ode, reading: LogReading) -> FilterProblem:
    n, base = ode.states.size, ode.parameters.default if model.p is None else model.p
    means, variances, intensities = starts_of(ode, model.walks, base)
    wider = with_walks(ode, list(model.walks))
    names = wider.states.labels[n:]
    rest = base[[place for place, label in enumerate(ode.parameters.labels) if label not in names]]
    columns = columns_of(call, log, reading, wider.parameters, ode.inputs, ode.outputs)
    ode.refuse_beyond(f"{call}(log=...)", float(columns.t[-1]))
    x0, P0, R = _start(call, model, columns)
    noise = square_root(covariance(call, "Q", model.Q, n))
    noise = scipy.linalg.block_diag(noise, np.diag(np.sqrt(intensities)))
    return FilterProblem(
        *(np.concatenate([x0, means]), scipy.linalg.block_diag(P0, np.diag(variances)), R),
        wider.states,
        lambda parts: OdeMotion(wider, columns, rest, noise, reading.hold, parts),
        has_parts=True,
        remarks=columns.remarks,
    )


def _of_step(call: str, step: StepMap, columns: FilterColumns) -> MapExpressions:
    if step.recorded_numbers is not None:
        raise ValueError(
            f"`{call}(model=...)` must have a step without recorded numbers: give the `Ode` itself, and its inputs in "
            "the log."
        )
    expressions = MapExpressions.of_step(step)
    if ca.depends_on(expressions.output[list(columns.output_places)], expressions.w):
        raise ValueError(
            f"`{call}(outputs=...)` must be outputs without random numbers, as v is their noise; those of "
            f"{', '.join(columns.outputs.names)} have some: read other outputs, or give the loop no instruments."
        )
    return expressions


def _numbers(call: str, step: StepMap, t: Array) -> Array:
    """The number of the step at each time of a log."""
    k = np.round(t / step.h)
    if np.abs(t - k * step.h).max() > 1e-6 * step.h + 1e-12 * np.abs(t).max() or (np.diff(k) != 1).any():
        raise ValueError(
            f"`{call}(log=...)` must have its samples at multiples of the step, {step.h:g} s, without a gap, as a map "
            "knows no other times: resample the log, or give the `Ode`."
        )
    return np.asarray(k)
