"""An equation with its metrics: its steps, with accumulators beside the states, and the values that these give."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, reduce
from typing import TypeVar

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode, SampledSystem, StepMap, runge_kutta_step, with_quadrature
from workbench.core.units import checked_unit
from workbench.core.validation.refusals import MOST, Array, multiple, seconds, text
from workbench.core.validation.signatures import check_arguments
from workbench.engine import Trajectories
from workbench.engine.arithmetic import advance_states
from workbench.engine.metrics.contract import AbstractMetric, watches
from workbench.engine.metrics.score import MetricColumn
from workbench.engine.metrics.signal_choice import refuse_unknown
from workbench.engine.state_bounds import StateExtremes, watch_memory, with_watch

T = TypeVar("T")
LARGEST_RATIO = 1000  # in the ratio of two sample times that have a common divisor


@dataclass(frozen=True, eq=False)
class MeasuredEquation:
    """An equation and its metrics, each with the units and labels of the signals that it watches."""

    equation: Ode | SampledSystem
    metrics: tuple[AbstractMetric, ...]

    @staticmethod
    @check_arguments
    def of(
        equation: Ode | SampledSystem, metrics: Sequence[AbstractMetric], horizon: float = np.inf
    ) -> MeasuredEquation:
        """The equation with its metrics, once both are checked.

        Raises
        ------
        LookupError
            If a metric watches an output that `equation` does not have.
        ValueError
            If two metrics have the same name, or a metric is not defined for `equation` or for the horizon [s].
        """
        ode = _flow(equation)
        names = [text("metric(name=...)", metric.name) for metric in metrics]
        if len(set(names)) < len(names):
            raise ValueError(f"`measured(metrics=...)` needs distinct names; got {names}.")
        bound = tuple(m.of(ode) for m in metrics)
        for m in bound:
            checked_unit(f"{type(m).__name__}({m.name}, unit=...)", m.unit)
            for signal in watches(m):
                refuse_unknown(m.name, signal, ode)
            _grid(m)
            m.check(ode, horizon)
        return MeasuredEquation(equation, bound)

    @property
    def columns(self) -> tuple[MetricColumn, ...]:
        """A column for each number of each metric, in their order."""
        return tuple(
            MetricColumn(m.name, number, unit, label)
            for m in self.metrics
            for number, (unit, label) in enumerate(zip(m.units, m.labels, strict=True))
        )

    @property
    def times(self) -> tuple[bool, ...]:
        """For each column, true if it is a time, which is known to one step at best."""
        return tuple(m.is_time for m in self.metrics for _ in m.labels)

    def step(self, h: float, method: str = "rk4") -> StepMap:
        """The step of length h [s] by a method; for a sampled loop, its period in substeps of length h.

        Integrals are advanced in the substeps. A metric that samples does so once a period, after the jump.

        Raises
        ------
        ValueError
            If h is not a positive time or does not divide the period of a sampled loop, or the step does not divide the
            sample time of a metric.
        """
        equation = self.equation
        if isinstance(equation, SampledSystem):
            span, substeps = equation.period, equation.substeps(h)
        else:
            span, substeps = seconds("measured(h=...)", h), 1
        for sample in filter(None, map(_grid, self.metrics)):
            multiple("metric(sample=...)", sample, span, "the step")
        if (made := self._steps.get((substeps, method))) is None:
            if isinstance(equation, SampledSystem):
                plain = replace(equation, flow=self._flow).step(substeps, method)
            else:
                plain = runge_kutta_step(self._flow, span, method)
            made = self._steps[substeps, method] = with_watch(_with_memories(plain, self.metrics))
        return replace(made, h=span)

    @cached_property
    def _steps(self) -> dict[tuple[int, str], StepMap]:
        """The steps that were made, by the number of their substeps and their method."""
        return {}

    @cached_property
    def _flow(self) -> Ode:
        """The equation with the integrals of the metrics behind its states."""
        ode = _flow(self.equation)
        y = ode.outputs.view(ode.output)
        integrands = ((m, m.integrand(ode.t, y)) for m in self.metrics)
        return with_quadrature(ode, {_integral(m): ca.densify(g) for m, g in integrands if g is not None})

    @cached_property
    def accumulators(self) -> Layout:
        """The states of a step that belong to its metrics, integrals and memories, and to the watch of bounds."""
        states = _flow(self.equation).states
        own = self._flow.states.entries[len(states.entries) :]
        return Layout((*own, *_memories(self.metrics).entries, *watch_memory(states).entries))

    def grid(self, *times: float) -> float | None:
        """The longest time [s] that divides the sample times of the metrics and `times`; None if no metric samples."""
        return common_grid(self.metrics, *times)

    def totals(self, runs: Trajectories, row: int = -1) -> Array:
        """The accumulators of each run, (B, a), at a kept time, with the memories updated there."""
        return accumulator_totals(runs, self.accumulators, self.metrics, row)

    def extremes(self, step: StepMap, totals: Array) -> StateExtremes:
        """The extremes of the states with bounds, from accumulators (B, a)."""
        return StateExtremes.of_totals(step, _flow(self.equation).states, self.accumulators, totals)

    def values(self, totals: Array, times: Array, diverged_at: Array) -> Array:
        """The metrics (B, T, k) from accumulators (B, T, a) at T times [s]; NaN from when a run diverged, (B,) in s."""
        rows: list[Array] = []
        if not len(totals):
            return np.empty((0, len(times), len(self.columns)))
        for row, time in enumerate(times.tolist()):
            found = values(self.metrics, self.accumulators, totals[:, row], time)
            numbers = np.hstack([np.empty((len(diverged_at), 0)), *(found[m.name] for m in self.metrics)])
            rows.append(np.where((diverged_at <= time)[:, np.newaxis], np.nan, numbers))
        return np.stack(rows, axis=1)


def accumulator_totals(runs: Trajectories, accumulators: Layout, metrics: Sequence[AbstractMetric], row: int) -> Array:
    """The `accumulators` of each run, (B, a), at a kept time, with the memories updated there."""
    step, state = runs.step, runs.x[:, row]
    later = advance_states(runs.job, state, round(float(runs.t[row]) / step.h), 1)
    integrals = set(map(_integral, metrics))
    parts = [(state if name in integrals else later)[:, step.states.slice(name)] for name in accumulators.names]
    return np.hstack([np.empty((len(state), 0)), *parts])


def accumulators_in(step: StepMap, metrics: Sequence[AbstractMetric]) -> Layout:
    """The states of a step that belong to metrics, by their names."""
    memories, integrals = tuple(f"{m.name}." for m in metrics), set(map(_integral, metrics))
    return Layout(tuple(e for e in step.states.entries if e.name in integrals or e.name.startswith(memories)))


def values(
    metrics: Sequence[AbstractMetric], accumulators: Layout, totals: Array, horizon: float
) -> Mapping[str, Array]:
    """Each metric, (B, k), from the accumulators (B, a) of its runs and their horizon in s."""
    parts, found = accumulators.unpack(totals), {}
    for m in metrics:
        integral = parts.get(_integral(m), np.zeros((len(totals), 0)))
        found[m.name] = m.value(integral, _below(parts, m), horizon)
    return found


@check_arguments
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


def _grid(metric: AbstractMetric) -> float | None:
    grid = metric.grid
    return None if grid is None else seconds(f"{type(metric).__name__}.grid", grid)


def _flow(equation: Ode | SampledSystem) -> Ode:
    return equation if isinstance(equation, Ode) else equation.flow


def _integral(metric: AbstractMetric) -> str:
    """The name of the state that integrates a metric."""
    return f"integral of {metric.name}"


def _memories(metrics: Sequence[AbstractMetric]) -> Layout:
    return sum((m.memory(len(m.labels)).with_prefix(f"{m.name}.") for m in metrics), Layout())


def _with_memories(step: StepMap, metrics: Sequence[AbstractMetric]) -> StepMap:
    """The step with the memories of its metrics updated beside its states."""
    outputs, rule, extra = step.outputs, step.rule, _memories(metrics)
    if not extra.size:
        return step
    symbols = extra.symbols()
    z, y = extra.view(symbols), outputs.view(rule.output)
    updates = {
        f"{m.name}.{name}": ca.densify(part)
        for m in metrics
        for name, part in m.update(rule.k, rule.h, _below(z, m), y).items()
    }
    return step.with_memory(extra, symbols, extra.flatten(updates))


def _below(z: Mapping[str, T], metric: AbstractMetric) -> dict[str, T]:
    prefix = f"{metric.name}."
    return {name.removeprefix(prefix): part for name, part in z.items() if name.startswith(prefix)}
