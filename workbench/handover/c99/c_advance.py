"""NAME_advance: the law's own lines, stage by stage in the order of the loop, under the book's equations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from workbench.core.sampled_law import Stage
from workbench.handover.c99.c_assignments import CCall, Demand, DemandCode, ValueForm, assignments
from workbench.handover.c99.c_equations import opening, printed_equation
from workbench.handover.c99.c_header import block, prototype
from workbench.handover.c99.c_names import comment, places_of
from workbench.handover.c99.c_request import Request
from workbench.handover.c99.c_scope import ROOM, Scope
from workbench.handover.c99.c_variables import LawVariables
from workbench.handover.law_graph import StepGraph, behind_limits


class Advance(NamedTuple):
    """The lines of the function, what they call, and the numbers of the room for the arrays of its loops."""

    lines: tuple[str, ...]
    calls: tuple[CCall, ...]
    room: int = 0


class _StageValue(NamedTuple):
    """A value of a stage by its number, and its nodes."""

    stage: int
    name: str
    places: tuple[int, ...]


def advance_of(request: Request, graph: StepGraph, variables: LawVariables) -> Advance:
    """The function that makes the commands and the memory of the next instant, where all of them are finite."""
    results, hidden = graph.graph.results, _hidden(request, graph)
    values = [
        _StageValue(stage, name, tuple(i for i in places if i is not None))
        for stage, parts in enumerate(graph.values)
        for name, places in parts.items()
    ]
    early = set(graph.graph.before(results)).intersection(graph.parameter_nodes)
    demands = [Demand(tuple(sorted(early))), *(Demand((place,)) for value in values for place in value.places)]
    demands += [Demand(results), Demand(results, ValueForm.TEXT)]
    demands += [Demand(results, ValueForm.VARIABLE), Demand(hidden, ValueForm.VARIABLE)]
    written = assignments(_scope(request, graph, variables), demands)
    first, *made, rest, narrowed, ends, behind = written.answers
    lines = [*variables.opening, *first.lines, *_stages(request, values, iter(made))]
    lines += [*rest.lines, *narrowed.lines, *ends.lines, *behind.lines]
    checks = _checks(request, graph, ends.texts, behind.texts)
    lines += ["", "/* Nothing is kept that is not finite. */", f"const bool done = {_joined(checks)};"]
    lines += ["if (done) {", *_stores(request, ends.texts), "}", "return done;"]
    calls = (*variables.calls, *written.calls, CCall("finite", request.real))
    calls += (CCall("defined", request.real),) if hidden else ()
    return Advance(
        (prototype(request, "static bool", "advance"), "{", *_body(request, variables, lines), "}"), calls, written.room
    )


def _scope(request: Request, graph: StepGraph, variables: LawVariables) -> Scope:
    """The scope of the function; in single precision what no reading changes is made in doubles."""
    return Scope(
        graph.graph,
        request.name,
        request.real,
        graph.numbers,
        variables.sources,
        variables.names,
        request.fused_products,
        frozenset((*graph.parameter_nodes, *graph.instant_nodes)) if request.precision == "single" else frozenset(),
        f"state->{ROOM}",
        variables.arrays,
    )


def _hidden(request: Request, graph: StepGraph) -> tuple[int, ...]:
    """The values behind the limits of results, which can be no number where the results are."""
    fixed = {*graph.numbers, *(() if request.settable else graph.parameter_nodes)}
    return tuple(place for place in behind_limits(graph.graph) if place not in fixed)


def _stages(request: Request, values: Iterable[_StageValue], answers: Iterator[DemandCode]) -> list[str]:
    """The lines of all stages, each below its title, and each value below its equation."""
    lines: list[list[str]] = [[] for _ in request.law.stages]
    for value in values:
        own = [line for _ in value.places for line in next(answers).lines]
        equation = printed_equation(request.law, value.name) if own else ""
        lines[value.stage] += [*([f"/* {comment(equation)} */"] if equation else []), *own]
    stages = zip(request.law.stages, lines, strict=True)
    return [line for stage, own in stages if own for line in ("", *_heading(stage), *own)]


def _heading(stage: Stage) -> list[str]:
    """The comment above a stage."""
    equations = opening(stage.equations)
    return block([stage.title, "", *equations]) if equations else [f"/* {comment(stage.title)} */"]


def _checks(request: Request, graph: StepGraph, ends: tuple[str, ...], behind: tuple[str, ...]) -> list[str]:
    """The conditions that each result is finite, unless it is a finite number, and that no hidden value is NaN."""
    numbers, mark = graph.numbers, request.real.mark
    moving = [
        text
        for place, text in zip(graph.graph.results, ends, strict=True)
        if not math.isfinite(numbers.get(place, math.nan))
    ]
    checks = [f"{request.name}_finite{mark}({text})" for text in dict.fromkeys(moving)]
    return checks + [f"{request.name}_defined{mark}({x})" for x in dict.fromkeys(behind) if x not in ends]


def _joined(conditions: list[str]) -> str:
    return " &&\n        ".join(conditions) or "true"


def _stores(request: Request, ends: tuple[str, ...]) -> list[str]:
    """The lines that keep the results."""
    memory = [f"state->{place}" for place in places_of(request.law.memory)]
    commands = [f"commands->{place}" for place in places_of(request.law.commands)]
    return [f"    {to} = {value};" for to, value in zip([*memory, *commands], ends, strict=True)]


def _body(request: Request, variables: LawVariables, lines: list[str]) -> list[str]:
    """The lines of the function, indented, behind a mention of each struct that they do not read."""
    reads = {*variables.reads, *(["state"] if any(f"state->{ROOM}" in line for line in lines) else [])}
    unread = [f"(void){struct};" for struct in (*request.inputs, "state") if struct not in reads]
    text = [*unread, *lines] if unread or lines[0] else lines[1:]
    return [f"    {line}" if line else "" for line in text]
