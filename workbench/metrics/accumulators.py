"""The accumulators of metrics: the step of an equation with them beside its states, and the values at its end."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import reduce
from typing import TypeVar

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode, Sampled, Step, runge_kutta_step, with_quadrature
from workbench.metrics.contract import AbstractMetric, watches
from workbench.metrics.signal_choice import refuse_unknown
from workbench.simulate import Trajectories
from workbench.simulate.arithmetic import continued
from workbench.validation.refusals import MOST, Array, multiple, seconds, text, whole
from workbench.validation.signatures import door

T = TypeVar("T")
LARGEST_RATIO = 1000  # in the ratio of two sample times that have a common divisor


@door
def measured(equation: Ode | Sampled, metrics: Sequence[AbstractMetric], h: float) -> Step:
    """The step of `equation` with every metric accumulated beside it; of a sampled loop h is the substep.

    Integrals run along in the substeps; what looks at samples looks once a period, at what holds after the jump.

    Raises
    ------
    LookupError
        If a metric watches an output that `equation` does not have.
    ValueError
        If h is none or does not divide the period of a sampled loop, two metrics have one name, or one means nothing
        for `equation`.
    """
    return maker(equation, metrics)(h)


@door
def maker(equation: Ode | Sampled, metrics: Sequence[AbstractMetric], method: str = "rk4") -> Callable[[float], Step]:
    """The function that makes the steps of `measured` of length h [s], which share their rule."""
    metrics = resolved(equation, metrics)
    ode = _flow(equation)
    y = ode.outputs.view(ode.output)
    integrands = {f"integral of {m.name}": ca.densify(g) for m in metrics if (g := m.integrand(ode.t, y)) is not None}
    ode = with_quadrature(ode, integrands)
    sampled = replace(equation, flow=ode) if isinstance(equation, Sampled) else None
    made: dict[int, Step] = {}

    def make(h: float) -> Step:
        if isinstance(equation, Sampled):
            span, substeps = equation.period, equation.substeps(h)
        else:
            span, substeps = seconds("measured(h=...)", h), 1
        for sample in filter(None, map(_grid, metrics)):
            multiple("metric(sample=...)", sample, span, "the step")
        if substeps not in made:
            plain = sampled.step(substeps, method) if sampled else runge_kutta_step(ode, span, method)
            made[substeps] = _with_memories(plain, metrics)
        return replace(made[substeps], h=span)

    return make


def _with_memories(step: Step, metrics: Sequence[AbstractMetric]) -> Step:
    """The step with the memories of its metrics updated beside its states."""
    outputs, rule = step.outputs, step.rule
    memories = (m.memory(len(m.labels)).prefixed(f"{m.name}.") for m in metrics)
    extra = sum(memories, Layout())
    if not extra.size:
        return step
    symbols = extra.symbols()
    z, y = extra.view(symbols), outputs.view(rule.output)
    updates = {
        f"{m.name}.{name}": ca.densify(part)
        for m in metrics
        for name, part in m.update(rule.k, rule.h, _below(z, m), y).items()
    }
    return step.extended(extra, symbols, extra.flatten(updates))


@door
def resolved(
    equation: Ode | Sampled, metrics: Sequence[AbstractMetric], horizon: float = np.inf
) -> tuple[AbstractMetric, ...]:
    """The metrics with units and labels of the signals that they watch in `equation`, after their checks."""
    ode = _flow(equation)
    names = [text("metric(name=...)", metric.name) for metric in metrics]
    if len(set(names)) < len(names):
        raise ValueError(f"`measured(metrics=...)` needs distinct names; got {names}.")
    bound = tuple(m.of(ode) for m in metrics)
    for m in bound:
        for signal in watches(m):
            refuse_unknown(m.name, signal, ode)
        _grid(m)
        m.check(ode, horizon)
    return bound


def _grid(metric: AbstractMetric) -> float | None:
    grid = metric.grid
    return None if grid is None else seconds(f"{type(metric).__name__}.grid", grid)


@door
def common_grid(metrics: Sequence[AbstractMetric], *times: float) -> float | None:
    """The longest time [s] that divides the sample times of the metrics and `times`; None if no metric samples."""
    samples = list(filter(None, map(_grid, metrics)))
    if not samples:
        return None
    spans = sorted({*samples, *(seconds("common_grid(*times)", time) for time in times)})
    if spans[-1] / spans[0] > MOST:
        raise ValueError(
            f"`measure(...)` needs times of which the longest has at most 2^53 of the shortest; got {spans[0]:g} s and "
            f"{spans[-1]:g} s."
        )
    grid = reduce(lambda a, b: a / Fraction(b / a).limit_denominator(LARGEST_RATIO).denominator, spans)
    if any(abs(span / grid - round(span / grid)) > 1e-6 for span in spans):
        raise ValueError(
            "`measure(...)` needs sample times, a horizon and kept times that one step divides; got "
            f"{', '.join(f'{span:g} s' for span in spans)}."
        )
    return grid


def _flow(equation: Ode | Sampled) -> Ode:
    return equation if isinstance(equation, Ode) else equation.flow


def _below(z: Mapping[str, T], metric: AbstractMetric) -> dict[str, T]:
    prefix = f"{metric.name}."
    return {name.removeprefix(prefix): part for name, part in z.items() if name.startswith(prefix)}


@door
def accumulators(step: Step, metrics: Sequence[AbstractMetric]) -> Layout:
    """The states of a step that belong to its metrics: their integrals and memories."""
    memories = tuple(f"{m.name}." for m in metrics)
    wanted = (e for e in step.states.entries if e.name in _integrals(metrics) or e.name.startswith(memories))
    return Layout(tuple(wanted))


@door
def accumulated(runs: Trajectories, metrics: Sequence[AbstractMetric], row: int = -1) -> Array:
    """The accumulators of each run, (B, a), at a kept time, the last unless given, with the memories updated there."""
    row = whole("accumulated(row=...)", row, -len(runs.t), len(runs.t) - 1)
    step, state = runs.step, runs.x[:, row]
    later = continued(runs.job, state, round(float(runs.t[row]) / step.h), 1)
    names, integrals = accumulators(step, metrics).names, _integrals(metrics)
    parts = [(state if name in integrals else later)[:, step.states.slice(name)] for name in names]
    return np.hstack([np.empty((len(state), 0)), *parts])


@door
def values(metrics: Sequence[AbstractMetric], held: Layout, accumulated: Array, horizon: float) -> Mapping[str, Array]:
    """Each metric, (B, k), from the accumulators (B, a) of its runs and their horizon in s."""
    parts, found = held.unpack(accumulated), {}
    for m in metrics:
        integral = parts.get(f"integral of {m.name}", np.zeros((len(accumulated), 0)))
        found[m.name] = m.value(integral, _below(parts, m), horizon)
    return found


@door
def final_values(runs: Trajectories, metrics: Sequence[AbstractMetric], row: int = -1) -> dict[str, Array]:
    """Each metric of each run, (B, k), until a kept time, the last unless given; NaN for a run that has diverged."""
    row = whole("final_values(row=...)", row, -len(runs.t), len(runs.t) - 1)
    horizon = float(runs.t[row])
    lost = (runs.diverged_at <= horizon)[:, np.newaxis]
    found = values(metrics, accumulators(runs.step, metrics), accumulated(runs, metrics, row), horizon)
    return {name: np.where(lost, np.nan, value) for name, value in found.items()}


def _integrals(metrics: Sequence[AbstractMetric]) -> set[str]:
    return {f"integral of {m.name}" for m in metrics}
