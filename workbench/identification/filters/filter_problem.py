"""A model, a log and their covariances, checked and joined to what a filter runs over."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy.linalg

from workbench.core import Layout, Ode, SampledSystem
from workbench.core.step import StepMap
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, one_of, vector
from workbench.identification.datasets import Dataset
from workbench.identification.filters.array_steps import square_root
from workbench.identification.filters.discrete_model import DiscreteModel
from workbench.identification.filters.filter_input import covariance, initial_mean
from workbench.identification.filters.log_columns import LogColumns, Names, columns_of
from workbench.identification.filters.motions import AbstractMotion, MapExpressions, MapMotion, OdeMotion
from workbench.identification.filters.parameter_walk import ParameterWalk, starts_of, with_walks

Model = Ode | SampledSystem | StepMap | DiscreteModel
HOLDS = ("zero", "linear")


@dataclass(frozen=True, eq=False)
class FilterProblem:
    """The mean and covariances of a filter, and its motion for a number of steps between two samples."""

    x0: Array
    P0: Array
    R: Array
    states: Layout
    motion: Callable[[int], AbstractMotion]
    has_parts: bool  # True for an `Ode`

    def remarks_on(self, x: Array) -> tuple[str, ...]:
        """A remark for each state and parameter whose estimates (N, n) leave the bounds that it declares."""
        remarks, rows = [], x[np.isfinite(x).all(axis=1)]
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


def problem_of(
    call: str,
    log: Dataset,
    model: Model,
    covariances: tuple[Numbers, Numbers, Numbers | None],
    values: tuple[Numbers | None, Numbers | None],
    names: tuple[Names | None, Names | None],
    choices: tuple[Mapping[str, ParameterWalk], str],
) -> FilterProblem:
    """The problem of Q, R and P0, of x0 and p, of inputs and outputs, of walks and hold."""
    (Q, R, P0), (x0, p), (walks, hold) = covariances, values, choices
    one_of(f"{call}(hold=...)", hold, HOLDS)
    if isinstance(model, Ode):
        return _of_ode(call, log, model, covariances, values, names, choices)
    if walks:
        raise ValueError(
            f"`{call}(walks=...)` needs an `Ode`, whose parameters are known by name; make them states of the model."
        )
    if isinstance(model, SampledSystem):
        model = model.step()
    n, parameters = model.states.size, model.inputs if isinstance(model, DiscreteModel) else model.parameters
    default = parameters.names if isinstance(model, DiscreteModel) else model.flow.inputs
    columns = columns_of(call, log, parameters, default if names[0] is None else names[0], model.outputs, names[1])
    base = parameters.default if p is None else vector(f"{call}(p=...)", p, parameters.size, "parameters")
    rows = np.array(np.broadcast_to(base, (len(columns.t), parameters.size)))
    rows[:, [parameters.labels.index(label) for label in columns.input_labels]] = columns.u
    noise = square_root(covariance(call, "Q", Q, n))
    if isinstance(model, DiscreteModel):
        expressions, k = MapExpressions.of_model(model), np.arange(len(rows), dtype=float)
    else:
        expressions, k = _of_step(call, model, columns), _numbers(call, model, columns.t)
    states = model.states
    R_, P = covariance(call, "R", R, columns.outputs.size, definite=True), covariance(call, "P0", P0, n)
    return FilterProblem(
        initial_mean(call, x0, n),
        *(P, R_, states),
        lambda _: MapMotion(states, columns, expressions, rows, k, noise),
        has_parts=False,
    )


def _of_ode(
    call: str,
    log: Dataset,
    ode: Ode,
    covariances: tuple[Numbers, Numbers, Numbers | None],
    values: tuple[Numbers | None, Numbers | None],
    names: tuple[Names | None, Names | None],
    choices: tuple[Mapping[str, ParameterWalk], str],
) -> FilterProblem:
    (Q, R, P0), (x0, p), (walks, hold), n = covariances, values, choices, ode.states.size
    base = ode.parameters.default if p is None else vector(f"{call}(p=...)", p, ode.parameters.size, "parameters")
    means, variances, intensities = starts_of(ode, walks, base)
    wider = with_walks(ode, list(walks)) if walks else ode
    labels = wider.states.labels[n:]
    rest = base[[place for place, label in enumerate(ode.parameters.labels) if label not in labels]]
    columns = columns_of(
        call, log, wider.parameters, ode.inputs if names[0] is None else names[0], ode.outputs, names[1]
    )
    ode.refuse_beyond(f"{call}(log=...)", float(columns.t[-1]))
    P = scipy.linalg.block_diag(covariance(call, "P0", P0, n), np.diag(variances))
    noise = scipy.linalg.block_diag(square_root(covariance(call, "Q", Q, n)), np.diag(np.sqrt(intensities)))
    return FilterProblem(
        np.concatenate([initial_mean(call, x0, n), means]),
        P,
        covariance(call, "R", R, columns.outputs.size, definite=True),
        wider.states,
        lambda parts: OdeMotion(wider, columns, rest, noise, hold, parts),
        has_parts=True,
    )


def _of_step(call: str, step: StepMap, columns: LogColumns) -> MapExpressions:
    if step.recorded_numbers is not None:
        raise ValueError(
            f"`{call}(model=...)` must be a step without recorded numbers: give the `Ode` itself, and its inputs in "
            "the log."
        )
    expressions = MapExpressions.of_step(step)
    if ca.depends_on(expressions.output[list(columns.output_places)], expressions.w):
        raise ValueError(
            f"`{call}(model=...)` must have outputs without random numbers, as v is their noise; those of "
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
    return k
