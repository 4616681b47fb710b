"""The variables of a law in C: one for each number that it reads, and one for each value that a stage names."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from workbench.core import SampledLaw
from workbench.core.sampled_law import Stage
from workbench.engine.machines.c_elementary_functions import ABOUT
from workbench.engine.machines.c_primitives import HARDWARE, PRIMITIVES
from workbench.engine.machines.c_real import DOUBLE, SINGLE
from workbench.engine.machines.c_spelling import Text
from workbench.engine.machines.operations import Tightness
from workbench.handover.c99.c_assignments import CCall
from workbench.handover.c99.c_header import STRUCTS
from workbench.handover.c99.c_names import Member, Variables, entries_of, letter_of
from workbench.handover.c99.c_parameters import built_in, parameters_of
from workbench.handover.c99.c_request import Request
from workbench.handover.c99.c_tables import arrays_of
from workbench.handover.law_graph import StepGraph

FUNCTIONS = ("pair", *STRUCTS, "state", "init", "reset", "step", "advance")


@dataclass(frozen=True, eq=False)
class LawVariables:
    """The variables that the lines of a law begin with.

    Attributes
    ----------
    opening
        The lines that put readings, memory and parameters into variables.
    sources
        The texts of the nodes without operands.
    names
        The variables of the values of stages, by their nodes.
    reads
        The structs that the opening or a source reads: "readings", "references", "state".
    calls
        The functions that the opening calls.
    arrays
        The texts of the arrays that no line makes, by their nodes.
    """

    opening: tuple[str, ...]
    sources: Mapping[int, Text]
    names: Mapping[int, str]
    reads: frozenset[str]
    calls: tuple[CCall, ...]
    arrays: Mapping[int, str]


@dataclass(frozen=True, eq=False)
class _Inputs:
    """The variable of each number that a law is handed, in the order of its layouts."""

    memory: tuple[Member, ...]
    readings: tuple[Member, ...]
    references: tuple[Member, ...]
    parameters: tuple[Member, ...]

    def text(self, op: str, entry: int) -> Text:
        """The text of a source of the law's graph; its parameters are those of the law, readings and references."""
        if op == "k":
            return Text("(double)state->k", Tightness.UNARY)
        members = self.memory if op == "x" else (*self.parameters, *self.readings, *self.references)
        return Text(members[entry].variable, Tightness.ATOM, plain=True)


def variables_of(request: Request, graph: StepGraph) -> LawVariables:
    """The variables of a law, told apart from each other and from all functions."""
    law, names = request.law, _free_names(request.name)
    inputs = _Inputs(
        tuple(entries_of(names, law.memory, "state->")),
        tuple(entries_of(names, law.readings, "readings->")),
        tuple(entries_of(names, law.references, "references->", "{}_ref")),
        tuple(parameters_of(request, names)),
    )
    nodes = graph.graph.nodes
    sources = {i: inputs.text(node.op, node.entry) for i, node in enumerate(nodes) if node.op in ("x", "p", "k")}
    needed = [i for i in graph.graph.before(graph.graph.results) if i in sources]
    arrays = arrays_of(request, graph.graph, names, inputs.parameters, inputs.memory)
    used = {sources[i].text for i in needed if i not in arrays.inside}

    def used_members(members: Iterable[Member]) -> list[Member]:
        return [member for member in members if member.variable in used]

    read = used_members((*inputs.readings, *inputs.references, *inputs.memory))
    own = used_members(inputs.parameters)
    opening = _section(request.real.type, "Readings and memory", read)
    opening += _section("double", "Parameters", own) if request.settable else built_in(own, arrays.lines)
    keeps = bool(law.memory.size or used_members(inputs.memory) or (request.settable and own))
    counts = any(nodes[i].op == "k" for i in needed)
    readings, references = used_members(inputs.readings), used_members(inputs.references)
    reads = {"readings": readings, "references": references, "state": keeps or counts}
    numbers = zip(inputs.parameters, law.parameters.default.tolist(), strict=True)
    odd = not request.settable and any(member in own and not math.isfinite(value) for member, value in numbers)
    return LawVariables(
        tuple(opening),
        sources,
        _names_of_values(law, graph, names),
        frozenset(struct for struct, read in reads.items() if read),
        (CCall("number", DOUBLE),) if odd else (),
        arrays.texts,
    )


def _free_names(prefix: str) -> Variables:
    """Names that no function of the law has."""
    calls = (*PRIMITIVES, *HARDWARE, *ABOUT, *FUNCTIONS)
    return Variables(f"{prefix}_{call}{mark}" for call in calls for mark in ("", SINGLE.mark))


def _section(type_: str, title: str, members: Iterable[Member]) -> list[str]:
    lines = [f"const {type_} {name} = {source};" for name, source, _ in members]
    return ["", f"/* {title} */", *lines] if lines else []


def _names_of_values(law: SampledLaw, graph: StepGraph, variables: Variables) -> dict[int, str]:
    """A variable for each value of a stage that is computed; the first name of a value is its own."""
    names: dict[int, str] = {}
    for stage, places in zip(law.stages, graph.values, strict=True):
        for name, entries in places.items():
            own = variables.entries(_variable_of(name, law), _shape(stage, name))
            for place, variable in zip(entries, own, strict=True):
                if place is not None and place not in graph.numbers and graph.graph.nodes[place].operands:
                    names.setdefault(place, variable)
    return names


def _variable_of(name: str, law: SampledLaw) -> str:
    """The variable of a value of a stage: one of the memory is that of the next instant."""
    return f"{letter_of(name, {})}_next" if name in law.memory else name.rpartition(".")[2]


def _shape(stage: Stage, name: str) -> tuple[int, ...]:
    rows, columns = stage.values[name].shape
    return (rows, columns) if columns > 1 else (rows,) if rows > 1 else ()
