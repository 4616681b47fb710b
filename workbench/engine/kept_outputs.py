"""The outputs at the kept times of runs: only those that are asked for, and those behind loops by the batch kernel."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, StepMap
from workbench.core.bounded_loop import operation_codes
from workbench.core.expressions import rows
from workbench.core.validation.refusals import Array, Integers
from workbench.engine.arithmetic import CASADI, advance_states
from workbench.engine.job import Job

MEMORY = "output "  # the prefix of the memories by which a step hands over its outputs


@dataclass(frozen=True, eq=False)
class OutputGroup:
    """Outputs of a step that are evaluated together: all that need a loop of the graph, or all others."""

    step: StepMap
    layout: Layout
    has_loops: bool

    @cached_property
    def _places(self) -> list[int]:
        return [i for name in self.layout.names for i in self.step.outputs.indices(name)]

    @cached_property
    def function(self) -> ca.Function:
        """The outputs as a CasADi function of the symbols of `StepMap.y`."""
        if self.layout.size == self.step.outputs.size:
            return self.step.y
        symbols = self.step.y.sx_in()
        return ca.Function("workbench_outputs", symbols, [self.step.y(*symbols)[self._places]])

    @cached_property
    def recorder(self) -> StepMap:
        """The step with a memory in which it hands over the outputs at its beginning."""
        entries = (Entry(f"{MEMORY}{entry.name}", entry.default) for entry in self.layout.entries)
        memory, output = Layout(tuple(entries)), ca.densify(self.step.rule.output)
        return self.step.with_memory(memory, memory.symbols(), output[self._places])

    def values(self, job: Job, k: Integers, x: Array) -> dict[str, Array]:
        """The outputs by name, each (B, N, *shape), at states x (B, N, nx) before the steps k (N,)."""
        if self.has_loops and job.arithmetic != CASADI:
            n, more = x.shape[2], np.zeros((len(x), self.layout.size))
            job = replace(job, step=self.recorder)
            found = [advance_states(job, np.hstack([x[:, i], more]), int(step), 1)[:, n:] for i, step in enumerate(k)]
            values = np.stack(found, axis=1)
            values[np.isnan(x).any(axis=2)] = np.nan
            return self.layout.unpack(values)
        each, numbers = [], np.asarray(k[:, np.newaxis], dtype=float)
        for run in range(len(x)):
            noise = job.part(np.array([run]), 1, 0).noise(k)[0]
            each.append(rows(self.function, numbers, x[run], job.p[run : run + 1], noise))
        return self.layout.unpack(np.stack(each))


@lru_cache(maxsize=16)
def output_groups(step: StepMap) -> tuple[OutputGroup, ...]:
    """The outputs of a step in groups: those without loops, and those with loops."""
    if ca.OP_CALL not in operation_codes(step.y):
        return (OutputGroup(step, step.outputs, False),)
    symbols = step.y.sx_in()
    value = step.y(*symbols)
    parts: tuple[list[Entry], list[Entry]] = ([], [])
    for entry in step.outputs.entries:
        own = ca.Function("own", symbols, [value[step.outputs.slice(entry.name)]])
        parts[ca.OP_CALL in operation_codes(own)].append(entry)
    return tuple(OutputGroup(step, Layout(tuple(part)), bool(i)) for i, part in enumerate(parts) if part)


def group_of(step: StepMap, name: str) -> OutputGroup:
    """The group in which an output is evaluated."""
    return next(group for group in output_groups(step) if name in group.layout)
