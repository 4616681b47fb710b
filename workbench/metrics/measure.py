"""Run a loop twice, at a step and at half of it: metrics with their errors, and the limit on the step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode, Sampled, Step, rk4, with_quadrature
from workbench.core.layout import Array, nearest, numbers
from workbench.metrics.contract import AbstractMetric
from workbench.simulate import StepLimit, Trajectories, simulate, step_limit
from workbench.simulate.batch import Progress, continued, seconds


@dataclass(frozen=True, eq=False)
class Score:
    """A metric of B runs, (B, k), and its error: the change from the step to half of it.

    For a smooth loop the change is about 15 times the error of the value. Where switching makes the
    method first order and its error irregular, the change tells the size of the error and bounds
    nothing: it has been seen five times too small. A time is known to one step at best. A run that
    diverged has NaN in both.
    """

    metric: AbstractMetric
    value: Array
    error: Array


@dataclass(frozen=True, eq=False)
class Measurement:
    """What a loop gave at the half step, with the change from the whole step, and the limit on the step.

    `coarse_diverged_at` (B,) tells of runs that diverged at the whole step; the limit is that of the
    whole step's trajectories, one a run.
    """

    trajectories: Trajectories
    scores: Mapping[str, Score]
    limits: tuple[StepLimit, ...]
    coarse_diverged_at: Array

    @property
    def h(self) -> float:
        """The step at which the values were taken, in s; of a sampled loop the substep."""
        return self.trajectories.step.h / self.trajectories.step.substeps


def measured(equation: Ode | Sampled, metrics: Sequence[AbstractMetric], h: float) -> Step:
    """The step of `equation` with every metric accumulated beside it.

    Of a sampled loop h is the substep. Integrals run along in the substeps; what looks at samples looks
    once a period, at what holds after the jump.

    Raises
    ------
    LookupError
        If a metric watches an output that `equation` does not have.
    ValueError
        If `equation` is none, h is none or does not divide the period of a sampled loop, two metrics have
        one name, or one means nothing for `equation`.
    """
    resolved(equation, metrics)
    ode = _flow(equation)
    y = ode.outputs.view(ode.output)
    integrands = {f"integral of {m.name}": ca.densify(g) for m in metrics if (g := m.integrand(ode.t, y)) is not None}
    ode = with_quadrature(ode, integrands)
    step = rk4(ode, h) if isinstance(equation, Ode) else replace(equation, flow=ode).step(equation.substeps(h))
    memories = (m.memory(ode.outputs[m.watches[0]].size).prefixed(f"{m.name}.") for m in metrics)
    extra = sum(memories, Layout())
    if not extra.size:
        return step
    symbols = extra.symbols()
    z, y = extra.view(symbols), step.outputs.view(step.output)
    updates = {
        f"{m.name}.{name}": ca.densify(part)
        for m in metrics
        for name, part in m.update(step.k, step.h, _below(z, m), y).items()
    }
    return step.extended(extra, symbols, extra.flatten(updates))


def resolved(
    equation: Ode | Sampled, metrics: Sequence[AbstractMetric], horizon: float = np.inf
) -> tuple[AbstractMetric, ...]:
    """The metrics with the units of what they watch, once each is found to mean something for `equation`."""
    if not isinstance(equation, Ode | Sampled):
        raise ValueError(
            f"A metric is measured on an `Ode` or a `Sampled`; got {type(equation).__name__}. Of a loop, call `.ode()` "
            "for its equations, or `.digital(period)`."
        )
    ode = _flow(equation)
    names = [metric.name for metric in metrics]
    if len(set(names)) < len(names):
        raise ValueError(f"`measured(metrics=...)` needs distinct names; got {names}.")
    for m in metrics:
        for signal in m.watches:
            if signal not in ode.outputs:
                known = nearest(signal, ode.outputs.names) or f" It has: {', '.join(ode.outputs.names) or 'none'}."
                raise LookupError(
                    f"The metric '{m.name}' needs the output '{signal}', which '{ode.name}' does not have.{known}"
                )
        m.check(ode, horizon)
    return tuple(replace(m, unit=m.unit or ode.outputs[m.watches[0]].unit) for m in metrics)


def measure(
    equation: Ode | Sampled,
    metrics: Sequence[AbstractMetric],
    p: Array | None = None,
    x0: Array | None = None,
    *,
    until: float,
    h: float,
    every: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Measurement:
    """Simulate `equation` at the step h and at h / 2 and score both.

    Of a sampled loop h is the substep: the period belongs to the controller and is the same in both.

    Parameters
    ----------
    p, x0
        (B, np) and (B, nx) rows as its `parameters.pack` and `states.pack` make them.
    until, h, every
        Horizon, step and distance of the kept states, in s.
    seed
        Of the noise, which is the same at both steps.

    Raises
    ------
    LookupError
        If a metric watches an output that `equation` does not have.
    ValueError
        If `equation` is none, p or x0 is not as wide as its parameters or states, a metric means nothing
        for it or for the horizon, h does not divide the period of a sampled loop, or `simulate` refuses.
    """
    metrics = resolved(equation, metrics, seconds("until", until))
    p, x0 = _rows("p", equation.parameters, p), _rows("x0", equation.states, x0)
    coarse, fine = measured(equation, metrics, h), measured(equation, metrics, h / 2)
    share = progress or (lambda done: None)
    start = None if x0 is None else _extended(x0, fine)
    run = partial(simulate, p=p, x0=start, until=until, every=every or coarse.h, seed=seed)
    b = run(coarse, progress=lambda d: share(d / 3))
    a = run(fine, progress=lambda d: share((1 + 2 * d) / 3))
    values, rough = final_values(a, metrics), final_values(b, metrics)
    scores = {
        m.name: Score(m, values[m.name], _difference(values[m.name], rough[m.name], coarse.h if m.unit == "s" else 0.0))
        for m in metrics
    }
    limits = tuple(step_limit(b, run) for run in range(len(b)))
    return Measurement(a, scores, limits, b.diverged_at)


def final_values(runs: Trajectories, metrics: Sequence[AbstractMetric]) -> dict[str, Array]:
    """Each metric of each run, (B, k), with the last look taken at the horizon; NaN for a diverged run."""
    step, horizon = runs.step, float(runs.t[-1])
    x = step.states.unpack(runs.x[:, -1])
    # the memory was last updated one step before the horizon: look once more
    z = step.states.unpack(continued(runs.job, runs.x[:, -1], round(horizon / step.h), 1))
    values = {}
    for m in metrics:
        integral = x.get(f"integral of {m.name}", np.zeros((len(runs), 0)))
        memory = {name.removeprefix(f"{m.name}."): part for name, part in z.items() if name.startswith(f"{m.name}.")}
        value = m.value(integral, memory, horizon)
        values[m.name] = np.where(runs.diverged[:, np.newaxis], np.nan, value)
    return values


def _flow(equation: Ode | Sampled) -> Ode:
    """What is true between two samples, or always."""
    return equation if isinstance(equation, Ode) else equation.flow


def _below(z: Mapping[str, ca.SX], metric: AbstractMetric) -> dict[str, ca.SX]:
    prefix = f"{metric.name}."
    return {name.removeprefix(prefix): part for name, part in z.items() if name.startswith(prefix)}


def _rows(name: str, layout: Layout, given: Array | None) -> Array | None:
    """Rows as wide as the layout, or a refusal."""
    try:
        rows = None if given is None else np.atleast_2d(numbers(given))
    except (TypeError, ValueError):
        raise ValueError(f"`measure({name}=...)` must be rows of numbers; got {given!r}.") from None
    if rows is not None and (rows.ndim != 2 or rows.shape[1] != layout.size):
        raise ValueError(
            f"`measure({name}=...)` takes one row per run: (B, {layout.size}). Got {rows.shape}. "
            "`pack({...})` of the layout makes such rows from names."
        )
    return rows


def _extended(rows: Array, step: Step) -> Array:
    """Initial states of the loop with those of the metrics behind them."""
    rest = step.states.default[rows.shape[1] :]
    return np.hstack([rows, np.tile(rest, (len(rows), 1))])


def _difference(fine: Array, coarse: Array, least: float) -> Array:
    """|fine - coarse|, but at least what one step can tell; zero where two infinite values agree."""
    with np.errstate(invalid="ignore"):
        change = np.maximum(np.abs(fine - coarse), least)
    return np.where(np.isinf(fine) & np.isinf(coarse), 0.0, change)
