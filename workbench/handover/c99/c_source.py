"""The source of a law in C: its stages in the order of the loop, in the book's letters."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from workbench.core import SampledLaw
from workbench.core.sampled_law import Stage
from workbench.handover.c99.c_body import ATOM, SIGNED, Body, Text
from workbench.handover.c99.c_calls import init_of, places_of, reset_of, step_of
from workbench.handover.c99.c_costs import Costs, costs_of
from workbench.handover.c99.c_functions import ABOUT, definitions
from workbench.handover.c99.c_header import STRUCTS, about, block, prototype
from workbench.handover.c99.c_names import Variables, comment, entries_of, letter_of
from workbench.handover.c99.c_parameters import built_in, parameters_of, refuse_numbers_beyond_single
from workbench.handover.c99.c_primitives import DOUBLE, PRIMITIVES, SINGLE, Real
from workbench.handover.law_graph import StepGraph, behind_limits, graph_of_law

GUARDS = """#include <float.h>
#include <stdbool.h>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || \\
    defined(__NO_SIGNED_ZEROS__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "This law needs each operation rounded as IEEE 754 says: compile it without -ffast-math and its parts."
#endif
#if FLT_EVAL_METHOD != 0
#error "This law needs operations of the width of their type: on x86 compile it with -msse2 -mfpmath=sse."
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract (off)
#endif"""
SECTION = re.compile(r"^(Parameters|Attributes|Raises|References|Examples)$", re.MULTILINE)


@dataclass(frozen=True, eq=False)
class Writer:
    """The parts of the source of one law: its graph, the body that grows, and the names of its variables."""

    code: Any
    law: SampledLaw
    real: Real
    graph: StepGraph
    body: Body
    variables: Variables


def functions_of(code: Any) -> tuple[str, Costs]:
    """The functions of NAME.c, and what a call of its step costs."""
    writer = _writer(code)
    advance = _advance(writer)
    parts = [line for text in _definitions(writer) for line in (text, "")]
    parts += [*advance, "", *step_of(code), "", *reset_of(code), "", *init_of(code)]
    text = "\n".join(parts) + "\n"
    return text, costs_of(writer.graph, text, code.name)


def source_of(code: Any, functions: str) -> str:
    """The text of NAME.c around its functions."""
    library = ["#include <math.h>"] if code.hardware else []
    parts = [*block(about(code)), f'#include "{code.name}.h"', "", *library, GUARDS, ""]
    return "\n".join([*parts, functions])


def _writer(code: Any) -> Writer:
    law, real = code.law, SINGLE if code.precision == "single" else DOUBLE
    if real is SINGLE and not code.settable:
        refuse_numbers_beyond_single(law)
    graph = graph_of_law(law, True, "fma" in code.hardware)  # each parameter by itself: equal numbers stay two
    calls = [*PRIMITIVES, *ABOUT, "fma", "pair", *STRUCTS, "state", "init", "reset", "step", "advance"]
    variables = Variables(f"{code.name}_{call}{mark}" for call in calls for mark in ("", SINGLE.mark))
    names = dict[int, str]()
    fused = "fma" in code.hardware
    body = Body(graph.graph, code.name, real, graph.numbers, lambda place: texts[place], names, fused)
    body = replace(body, doubles=frozenset() if real is DOUBLE else frozenset((*graph.adjustable, *graph.timed)))
    texts = _sources(code, graph, variables, body)
    _name_values(law, graph, variables, names)
    body.prepare(graph.graph.results)
    return Writer(code, law, real, graph, body, variables)


def _sources(code: Any, graph: StepGraph, variables: Variables, body: Body) -> dict[int, Text]:
    """The texts of the nodes without operands; a line for each reading and each kept number in a variable."""
    law, texts = code.law, dict[int, Text]()
    memory = entries_of(variables, law.memory, "state->")
    held = law.parameters.size
    ports = entries_of(variables, law.readings, "readings->")
    ports += entries_of(variables, law.references, "references->", "{}_ref")
    own = parameters_of(code, variables)
    for place, node in enumerate(graph.graph.nodes):
        if node.op == "x":
            texts[place] = Text(memory[node.entry][0], ATOM)
        elif node.op == "p":
            texts[place] = Text((ports[node.entry - held] if node.entry >= held else own[node.entry])[0], ATOM)
        elif node.op == "k":
            texts[place] = Text("(double)state->k", SIGNED)
    needed = {texts[place].text for place in graph.graph.before(graph.graph.results) if place in texts}
    body.lines.extend(_lines(body.real.type, "Readings and memory", [x for x in (*ports, *memory) if x[0] in needed]))
    used = [x for x in own if x[0] in needed]
    if code.settable:
        body.lines.extend(_lines("double", "Parameters", used))
    else:
        body.primitives.update({("number", DOUBLE): None} if any("_number(" in x[1] for x in used) else {})
        body.lines.extend(built_in(used))
    return texts


def _lines(type_: str, title: str, entries: Iterable[tuple[str, str, str]]) -> list[str]:
    lines = [f"const {type_} {name} = {source};" for name, source, _ in entries]
    return ["", f"/* {title} */", *lines] if lines else []


def _name_values(law: SampledLaw, graph: StepGraph, variables: Variables, names: dict[int, str]) -> None:
    """Names for the values of stages."""
    for stage, places in zip(law.stages, graph.values, strict=True):
        for name, entries in places.items():
            own = variables.entries(_value_name(stage, name, law), _shape(stage, name))
            for place, variable in zip(entries, own, strict=True):
                fresh = place is not None and place not in names and place not in graph.numbers
                if fresh and graph.graph.nodes[place].operands:  # type: ignore[index]
                    names[place] = variable  # type: ignore[index]


def _value_name(stage: Stage, name: str, law: SampledLaw) -> str:
    """The variable of a value of a stage: one of the memory is that of the next instant."""
    if name in law.memory:
        return f"{letter_of(name, {})}_next"
    return name.rpartition(".")[2]


def _shape(stage: Stage, name: str) -> tuple[int, ...]:
    rows, columns = stage.values[name].shape
    return (rows, columns) if columns > 1 else (rows,) if rows > 1 else ()


def _advance(writer: Writer) -> list[str]:
    """The function that makes the commands and the memory of the next instant."""
    body, graph, code = writer.body, writer.graph, writer.code
    if graph.adjustable:
        used = _used(writer)
        body.make([i for i in graph.adjustable if i in used])
    for stage, places in zip(writer.law.stages, graph.values, strict=True):
        _stage(writer, stage, places)
    body.make(graph.graph.results)
    ends = [body.value(i) for i in graph.graph.results]
    memory = [f"state->{x}" for x in places_of(writer.law.memory)]
    commands = [f"commands->{x}" for x in places_of(writer.law.commands)]
    variables = [_variable(writer, text) for text in ends]
    body.primitives["finite", writer.real] = None
    fixed = {*graph.numbers, *(() if code.settable else graph.adjustable)}
    hidden = [_variable(writer, body.value(i)) for i in behind_limits(graph.graph) if i not in fixed]
    finite = [f"{code.name}_finite{writer.real.mark}({x})" for x in dict.fromkeys(variables) if not _plain(x)]
    finite += [f"{code.name}_defined{writer.real.mark}({x})" for x in dict.fromkeys(hidden) if x not in variables]
    body.primitives.update({("defined", writer.real): None} if hidden else {})
    lines = [*body.lines, "", "/* Nothing is kept that is not finite. */"]
    lines += [f"const bool done = {_joined(finite)};" if finite else "const bool done = true;", "if (done) {"]
    lines += [f"    {to} = {value};" for to, value in zip([*memory, *commands], variables, strict=True)]
    lines += ["}", "return done;"]
    head = prototype(code, "static bool", "advance")
    unread = [
        f"(void){port};" for port in ("readings", "references") if port in code.structs and not _reads(lines, port)
    ]
    unread += [] if any("state->" in line for line in lines) else ["(void)state;"]
    text = [*unread, *lines] if unread or lines[0] else lines[1:]
    return [head, "{", *(_indented(line) for line in text), "}"]


def _indented(line: str) -> str:
    return f"    {line}" if line else ""


def _reads(lines: list[str], port: str) -> bool:
    return any(f"{port}->" in line for line in lines)


def _joined(texts: list[str]) -> str:
    return " &&\n        ".join(texts)


def _plain(text: str) -> bool:
    return not text[0].isalpha()


def _variable(writer: Writer, text: str) -> str:
    """A result as a variable, for it is looked at twice."""
    if re.fullmatch(r"\w+|-?[\d.e+-]+f?", text):
        return text
    name = writer.body._free()
    writer.body.lines.append(f"const {writer.real.type} {name} = {text};")
    return name


def _used(writer: Writer) -> set[int]:
    return set(writer.graph.graph.before(writer.graph.graph.results))


def _stage(writer: Writer, stage: Stage, values: Mapping[str, tuple[int | None, ...]]) -> None:
    """The lines of a stage below its title and its equations."""
    body = writer.body
    before = len(body.lines)
    for name, places in values.items():
        start = len(body.lines)
        for place in places:
            body.make([] if place is None else [place])
        if len(body.lines) > start and (equation := _equation(writer.law, name)):
            body.lines.insert(start, f"/* {comment(equation)} */")
    lines = body.lines[before:]
    del body.lines[before:]
    if lines:
        body.lines.extend(["", *_heading(stage), *lines])


def _heading(stage: Stage) -> list[str]:
    """The comment above a stage."""
    end = SECTION.search(stage.equations)
    equations = (stage.equations[: end.start()] if end else stage.equations).strip()
    if not equations:
        return [f"/* {comment(stage.title)} */"]
    return block([stage.title, "", *equations.splitlines()])


def _equation(law: SampledLaw, name: str) -> str:
    """The printed equation of a value, with its number; of one of the memory that of its rate or its next value."""
    letter = re.escape(letter_of(name, {}))
    rate = name in law.memory
    pattern = re.compile(rf"^\s*{letter}{chr(39) if rate else ''}(?:\[k\+1\])?\s+=\s.*\(\d+[a-z]?\)\s*$")
    socket = "Observer" if name.startswith("observer.") else "Law"
    for stage in law.stages:
        if stage.title.startswith(socket):
            for line in stage.equations.splitlines():
                if pattern.match(line):
                    return re.sub(r"\s{2,}", "  ", line.strip())
    return ""


def _definitions(writer: Writer) -> list[str]:
    """The elementary functions that the body calls, of each format."""
    texts = []
    for real in (DOUBLE, SINGLE):
        functions = [name for name, format_ in writer.body.functions if format_ is real]
        primitives = {name for name, format_ in writer.body.primitives if format_ is real}
        if real is writer.real:
            primitives.add("finite")
        texts += definitions(writer.code.name, real, functions, sorted(primitives), writer.code.hardware)
    return texts
