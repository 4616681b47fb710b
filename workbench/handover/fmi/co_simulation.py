"""The model of an FMU: a law, a plant or a closed loop as one step with inputs, parameters, outputs and their names."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, SampledLaw, SampledSystem, StepMap, rk4
from workbench.core.validation.refusals import describe, seconds
from workbench.engine.kernel.graph import Graph
from workbench.engine.kernel.plan import graph_of

PART = r"[A-Za-z_][A-Za-z0-9_]*(\[\d+(,\d+)*\])?"
STRUCTURED_NAME = re.compile(rf"{PART}(\.{PART})*")  # a name of FMI's structured naming, without its quoted ones
START = "start."  # before the name of a state: its value at the first instant
INPUT, PARAMETER, FIXED, OUTPUT = "input", "parameter", "fixed", "output"


class Variable(NamedTuple):
    """One number that an importer sees."""

    reference: int
    name: str
    role: str  # input, parameter, fixed, output
    start: float | None
    unit: str
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Model:
    """x+ = F(k, x, p) and y = h(k, x, p), of whose p some are inputs.

    Attributes
    ----------
    kind
        "law", "plant" or "loop".
    inputs
        The places of the inputs in p.
    output
        y, in the symbols of the step's rule.
    """

    kind: str
    name: str
    about: str
    fingerprint: str
    step: StepMap
    inputs: frozenset[int]
    outputs: Layout
    output: ca.SX
    horizon: float
    law: SampledLaw | None = None

    @cached_property
    def readout(self) -> Graph:
        """The graph of the outputs alone."""
        rule, symbols = self.step.rule, self.outputs.symbols()
        still = replace(rule, rate=ca.SX(0, 1), update=rule.x, output=ca.SX(0, 1))
        update = ca.densify(self.output)
        graph = graph_of(
            replace(
                self.step,
                states=self.step.states + self.outputs.with_prefix("."),
                rule=still.with_memory(symbols, update),
            )
        )
        return Graph(graph.nodes, graph.results[self.step.states.size :])

    @cached_property
    def needs(self) -> tuple[tuple[int, ...], ...]:
        """For each output the references of the inputs that it depends on at once."""
        graph, found = self.readout, []
        for place in graph.results:
            entries = {graph.nodes[i].entry for i in graph.before([place]) if graph.nodes[i].op == "p"}
            found.append(tuple(1 + i for i in sorted(entries & self.inputs)))
        return tuple(found)

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """The variables in the order of their references, from 1 on; 0 is the time."""
        p, x = self.step.parameters, self.step.states
        roles = [INPUT if i in self.inputs else PARAMETER for i in range(p.size)]
        roles += [FIXED] * x.size + [OUTPUT] * self.outputs.size
        found = []
        layouts = (p, x.with_prefix(START), self.outputs)
        for place, (label, unit, entry, value) in enumerate(row for layout in layouts for row in _rows(layout)):
            role = roles[place]
            start = None if role == OUTPUT else value
            found.append(Variable(place + 1, label, role, start, unit, entry.bounds.low, entry.bounds.high))
        return tuple(found)


# What FMI has no way to write: an index within a name, as in 'q[0]_hat', and a number as a part, as in 'hold.next.2'.
INNER = re.compile(r"\[(\d+)\](?=\w)|\.(\d+)(?=[.\[]|$)")


def _rows(layout: Layout) -> Iterable[tuple[str, str, Entry, float]]:
    for entry in layout.entries:
        values = entry.default.ravel(order="F").tolist()
        for label, unit, value in zip(entry.labels(), entry.units, values, strict=True):
            yield INNER.sub(lambda found: f"_{found[1] or found[2]}", label), unit, entry, float(value)


def model_of(what: SampledLaw | Ode | SampledSystem, name: str, h: float | None) -> Model:
    """The model of a law, a plant or a loop; h [s] is the step of the plant's equations."""
    if isinstance(what, SampledLaw):
        model = _of_law(what, name, h)
    elif isinstance(what, Ode):
        model = _of_equations(what, name, seconds("fmu(h=...)", _stated(h)))
    else:
        model = _of_sampled(what, name, seconds("fmu(h=...)", _stated(h)))
    _refuse(model)
    return model


def _stated(h: float | None) -> float:
    if h is None:
        raise ValueError("`fmu(h=...)` must be stated for a plant or a loop: the step of its equations in s; got None.")
    return h


def _of_law(law: SampledLaw, name: str, h: float | None) -> Model:
    if h is not None and h != law.period:
        raise ValueError(f"`fmu(h=...)` of a law is its period, {law.period:g} s, and need not be stated; got {h:g} s.")
    step = law.step
    inputs = range(law.parameters.size, step.parameters.size)
    about = f"{law.name}: the law of a computer, every {law.period:g} s"
    output = step.rule.x[law.memory.size :]
    commands = law.commands.with_prefix("u.")
    fields = (step, frozenset(inputs), commands, output, math.inf, law)
    return Model("law", name, _with_notes(about, law.notes), law.fingerprint, *fields)


def _of_equations(ode: Ode, name: str, h: float) -> Model:
    step = rk4(ode, h)
    inputs = frozenset(i for each in ode.inputs for i in ode.parameters.indices(each))
    kind = "plant" if inputs else "loop"
    about = f"{ode.name}: its equations by the Runge-Kutta method with steps of {h:g} s"
    fields = (step, inputs, ode.outputs, step.rule.output, ode.horizon)
    return Model(kind, name, _with_notes(about, ode.notes), ode.fingerprint, *fields)


def _of_sampled(loop: SampledSystem, name: str, h: float) -> Model:
    step = loop.step(loop.substeps(h))
    about = f"{loop.name}: a loop with a computer, every {loop.period:g} s; its plant in steps of {h:g} s"
    fields = (step, frozenset[int](), loop.outputs, step.rule.output, loop.flow.horizon)
    return Model("loop", name, _with_notes(about, loop.notes), loop.fingerprint, *fields)


def _with_notes(about: str, notes: tuple[str, ...]) -> str:
    return " ".join([f"{about}.", *notes])


def _refuse(model: Model) -> None:
    """Refuse noise, names that FMI has no way to write, two variables of one name, and numbers that are not finite."""
    if model.step.noises:
        raise ValueError(
            f"`fmu(what=...)` takes no noise, for an FMU gives the same numbers in every run; '{model.name}' takes "
            f"{model.step.noises} random numbers a step. Make the loop with instruments that have no noise."
        )
    names = [variable.name for variable in model.variables]
    for name in names:
        if not STRUCTURED_NAME.fullmatch(name):
            raise ValueError(
                "`fmu(what=...)` needs names of letters of ASCII, digits and '_' that begin with a letter, with dots "
                f"and indices between them, as 'controller.K[0,1]' is; got {describe(name)}. Rename it."
            )
    if twice := sorted({name for name in ["time", *names] if ["time", *names].count(name) > 1}):
        raise ValueError(
            f"`fmu(what=...)` needs one name for each variable; two are called {describe(twice[0])} among inputs, "
            "parameters, outputs and the time. Rename one of them."
        )
    for variable in model.variables:
        if variable.start is not None and not np.isfinite(variable.start):
            raise ValueError(f"`fmu(what=...)` needs finite numbers; '{variable.name}' is {variable.start:g}.")


def digest(*parts: str) -> str:
    """The digest of some texts in the form of a GUID without braces."""
    text = hashlib.sha256("\0".join(parts).encode()).hexdigest()
    return "-".join((text[:8], text[8:12], text[12:16], text[16:20], text[20:32]))
