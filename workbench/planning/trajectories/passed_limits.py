"""The distances by which the march of a plan passes its limits, at the nodes and between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.planning.trajectories.marching import MarchedArc
from workbench.planning.trajectories.plan_problem import PlanProblem
from workbench.planning.trajectories.plan_values import Values


@dataclass(frozen=True, eq=False)
class MarchedSignal:
    """A limited state, input, output or rate of a phase over its march: values (M,) between low and high.

    `phase` is empty for a plan of one phase.
    """

    phase: str
    label: str
    low: float
    high: float
    values: Array

    @property
    def below(self) -> float:
        """The largest excess below the lower limit, at least zero."""
        return max(float((self.low - self.values).max()), 0.0)

    @property
    def above(self) -> float:
        """The largest excess above the upper limit, at least zero."""
        return max(float((self.values - self.high).max()), 0.0)

    @property
    def excess(self) -> float:
        """The larger of both over the distance of the limits, or over the larger of range and limit where one is.

        Of a value at the end, over its size.
        """
        finite = [abs(end) for end in (self.low, self.high) if np.isfinite(end)]
        is_pair = len(finite) == 2 and self.high > self.low
        size = self.high - self.low if is_pair else max(float(np.ptp(self.values)), *finite)
        over = max(self.above, self.below)
        return over / size if size > 0 else over


def violations_of(problem: PlanProblem, values: Values, runs: tuple[MarchedArc, ...]) -> dict[str, float]:
    """By limit, the largest excess on the march of each phase, over the size of the limit; zero where it holds."""
    signals = limited_signals(problem, values, runs)
    return {f"{signal.phase}: {signal.label}" if signal.phase else signal.label: signal.excess for signal in signals}


def limited_signals(problem: PlanProblem, values: Values, runs: tuple[MarchedArc, ...]) -> Iterator[MarchedSignal]:
    """All that is limited, over the march of each phase."""
    begin = 0.0
    for phase, arc, run in zip(problem.phases, values, runs, strict=True):
        shares = np.linspace(0.0, 1.0, run.x.shape[1])
        x = run.x.reshape(-1, problem.nx)
        u = (arc.begins[:, None] + shares[:, None] * (arc.ends - arc.begins)[:, None]).reshape(-1, problem.nu)
        nodes = begin + arc.T * arc.shares
        t = (nodes[:-1, None] + shares * np.diff(nodes)[:, None]).ravel()
        g = np.array(phase.path(t[np.newaxis], x.T, u.T)).T if phase.path_names else np.zeros((len(t), 0))
        slope = (arc.ends - arc.begins) / np.diff(nodes)[:, None]
        groups = [(problem.ode.states.labels, phase.x, x), (problem.inputs, phase.u, u), (phase.path_names, phase.g, g)]
        groups.append((tuple(f"rate of {label}" for label in problem.inputs), phase.slope, slope))
        name = phase.name if len(problem.phases) > 1 else ""
        for labels, ends, rows in groups:
            for j, label in enumerate(labels):
                low, high = float(ends.low[j]), float(ends.high[j])
                if np.isfinite(low) or np.isfinite(high):
                    yield MarchedSignal(name, label, low, high, rows[:, j])
        for place in map(int, np.flatnonzero(np.isfinite(phase.g_end.low))):
            value = float(phase.g_end.low[place])
            yield MarchedSignal(name, f"end of {phase.path_names[place]}", value, value, g[-1:, place])
        begin = float(nodes[-1])
