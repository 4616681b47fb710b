"""Marches: the steps of a loop as modules that a browser runs, with the numbers that they are handed."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, SampledSystem, StepMap, rk4
from workbench.core.validation.refusals import Array
from workbench.engine.kernel.graph import Level
from workbench.engine.kernel.plan import KernelPlan, pass_of
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.study.study import Outcome

MANY = 20_000  # steps of a run that takes so long in a browser that a coarse picture comes first
JUMPS = {"sign", "lt", "le", "eq", "ne", "floor", "fmod", "if_else"}  # operations that do


@dataclass(frozen=True)
class Modules:
    """The modules of a page, each once, packed as the page holds them."""

    packed_modules: dict[bytes, str] = field(default_factory=dict)

    def place(self, code: bytes) -> int:
        """The place of a module among them."""
        if code not in self.packed_modules:
            self.packed_modules[code] = page_text(code)
        return [*self.packed_modules].index(code)


def page_text(code: bytes) -> str:
    """Bytes as a page holds them."""
    squeeze = zlib.compressobj(9, wbits=-15)  # raw, as a browser's "deflate-raw"
    return base64.b64encode(squeeze.compress(code) + squeeze.flush()).decode("ascii")


def march(step: StepMap, stride: int, modules: Modules, has_switches: bool = True) -> dict[str, object]:
    """The march of a step that keeps each `stride`-th state, as plain data; with its switches unless there are none.

    Raises
    ------
    ValueError
        If the graph does not know an operation, or no browser can run the code.
    """
    from workbench.engine.kernel import webassembly  # with llvmlite, which not every machine has

    plan = KernelPlan.of_step(step, (), has_switches)
    return {
        "module": modules.place(webassembly.compile_plan(plan)),
        "h": step.h,
        "stride": stride,
        "states": step.states.size,
        "parameters": list(plan.parameters),
        "constants": plain(plan.constants(step.h)),
        "lanes": len(plan.lanes),
        "table": len(plan.table),
    }


def coarser(step: StepMap, rows: int, stride: int, has_switches: bool = True) -> list[dict[str, object]]:
    """The numbers with which the module of a step makes longer ones, for a picture before a long run is there.

    Each length divides every one of the `rows`, of `stride` steps, into fewer steps, at most two thirds as many as the
    one before; the first is the finest. A run of few steps needs none.
    """
    lengths: list[dict[str, object]] = []
    plan, last = KernelPlan.of_step(step, (), has_switches), float(stride)
    for fewer in range(stride - 1, 0, -1) if rows * stride >= MANY else ():
        if stride % fewer or 3 * fewer > 2 * last:
            continue
        h, last = step.h * (stride // fewer), fewer
        lengths.append({"h": h, "stride": fewer, "constants": plain(plan.constants(h))})
    return lengths


def evaluation(step: StepMap, expressions: ca.SX) -> StepMap:
    """The step that leaves the states x as they are and makes expressions (n, 1) in them, which stand behind x."""
    rule = step.rule
    n = int(expressions.numel())
    y, none = ca.SX.sym("y", n), ca.SX(0, 1)
    held = replace(
        rule,
        x=ca.vertcat(rule.x, y),
        rate=none,
        update=ca.vertcat(rule.x, ca.densify(expressions)),
        output=none,
        segments=None,
    )
    states = step.states + Layout(tuple(Entry(f"watched {i}", np.zeros(())) for i in range(n)))
    return replace(step, states=states, outputs=Layout(), rule=held)


def may_switch(step: StepMap, p: Array, places: Sequence[int]) -> bool:
    """True if a run with the parameters p (np,), of which those at some places are turned, has switches in time."""
    segments = step.rule.segments
    return segments is not None and (segments.can_occur(p[np.newaxis]) or segments.switches.depends_on(places))


def switches(equation: Ode | SampledSystem) -> bool:
    """True if an equation jumps where a comparison of states turns: there rounding may decide when."""
    graph = pass_of(rk4(equation, 1.0) if isinstance(equation, Ode) else equation.step(1))
    return any(node.op in JUMPS and level is Level.STATE for node, level in zip(graph.nodes, graph.levels, strict=True))


def whole_and_half(outcome: Outcome) -> tuple[StepMap, StepMap]:
    """The step of the values of an outcome, with its metrics beside it, and half of it, for their errors."""
    whole, h = outcome.measurement.trajectories.step, outcome.measurement.h
    return whole, MeasuredEquation.of(outcome.ode, outcome.measurement.metrics).step(h / 2, whole.rule.method.name)


def plain(numbers: Sequence[float] | Array) -> list[float | str]:
    """Numbers for JSON, which knows no infinite ones: these as the words from which JavaScript makes them."""
    words = {float("inf"): "Infinity", float("-inf"): "-Infinity"}
    return [words.get(float(x), float(x)) if x == x else "NaN" for x in numbers]
