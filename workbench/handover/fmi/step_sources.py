"""The C of a model: its numbers, its names, and the functions `model_step` and `model_outputs`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from workbench.core import Layout, SampledLaw
from workbench.core.templates import fill, template_text
from workbench.engine.kernel.graph import Graph
from workbench.engine.kernel.plan import graph_of
from workbench.handover.c99.c_body import ATOM, Body, Text
from workbench.handover.c99.c_code import c_code
from workbench.handover.c99.c_functions import definitions
from workbench.handover.c99.c_names import members
from workbench.handover.c99.c_primitives import DOUBLE
from workbench.handover.c99.c_source import GUARDS
from workbench.handover.fmi.co_simulation import Model

HEAD = "(uint64_t k, const double *x, const double *p, double *{})"


def sources_of(model: Model, identifier: str, version: str, token: str) -> dict[str, str]:
    """The files of C by their names; the first of them are compiled."""
    runtime = f"fmi{version[0]}.c"
    files = {runtime: template_text("workbench.handover", f"fmi/{runtime}")}
    if model.law is not None:
        files |= c_code(model.law, identifier, parameters="settable").files
    files["model.h"] = _model_header(model, identifier, token)
    files["instance.h"] = template_text("workbench.handover", "fmi/instance.h")
    return files


def compiled_files(files: Iterable[str]) -> list[str]:
    """Those that a compiler is handed."""
    return [name for name in files if name.endswith(".c")]


def _model_header(model: Model, identifier: str, token: str) -> str:
    step, bounded = model.step, math.isfinite(model.horizon)
    functions = _law_functions(model, model.law, identifier) if model.law is not None else _functions(model)
    return fill(
        "workbench.handover",
        "fmi/model.h.j2",
        guards=GUARDS,
        token=token,
        step=repr(float(step.h)),
        has_horizon=int(bounded),
        horizon=repr(float(model.horizon) if bounded else 0.0),
        parameters=step.parameters.size,
        states=step.states.size,
        outputs=model.outputs.size,
        default_parameters=[repr(number) for number in step.parameters.default.tolist()],
        default_states=[repr(number) for number in step.states.default.tolist()],
        names=[variable.name for variable in model.variables],
        functions="\n".join(functions),
    )


def _functions(model: Model) -> list[str]:
    """The two functions of a plant or a loop, and those that they call."""
    step = _body(graph_of(model.step), model)
    outputs = _body(model.readout, model)
    texts = [
        *_function("int model_step", "next", step, ["return 1;"]),
        "",
        *_function("void model_outputs", "y", outputs, []),
    ]
    functions = dict.fromkeys(name for body in (step, outputs) for name, _ in body.functions)
    primitives = dict.fromkeys(name for body in (step, outputs) for name, _ in body.primitives)
    called = definitions("model", DOUBLE, list(functions), list(primitives))
    return [*(line for text in called for line in (text, "")), *texts]


def _body(graph: Graph, model: Model) -> Body:
    forms: dict[str, Callable[[int], str]] = {
        "k": lambda entry: "time",
        "x": lambda entry: f"x[{entry}]",
        "p": lambda entry: f"p[{entry}]",
    }

    def load(place: int) -> Text:
        node = graph.nodes[place]
        return Text(forms[node.op](node.entry), ATOM)

    return Body(graph, "model", DOUBLE, graph.numbers(model.step.h), load)


def _function(head: str, target: str, body: Body, ends: list[str]) -> list[str]:
    body.prepare(body.graph.results)
    body.make(body.graph.results)
    results = [f"{target}[{i}] = {body.value(place)};" for i, place in enumerate(body.graph.results)]
    lines = ["const double time = (double)k; /* steps */", *body.lines, *results]
    unread = [f"(void){name};" for name in ("time", "x", "p") if not any(_reads(line, name) for line in lines[1:])]
    unread += [] if results else [f"(void){target};"]
    return [
        f"static {head}{HEAD.format(target)}",
        "{",
        *(f"    {line}" for line in (*lines[:1], *unread)),
        *(f"    {line}" for line in (*lines[1:], *ends)),
        "}",
    ]


def _reads(line: str, name: str) -> bool:
    return f"{name}[" in line if name in "xp" else name in line


def _law_functions(model: Model, law: SampledLaw, identifier: str) -> list[str]:
    """The two functions of a law around its own C."""
    q, y = law.parameters.size, law.readings.size
    lines = [f"{identifier}_state state;", f"{identifier}_readings readings;"]
    lines += [f"{identifier}_references references;"] if law.references.size else []
    lines += [f"{identifier}_commands commands;", f"{identifier}_init(&state);"]
    lines += _copies(law.parameters, "state.parameters.", "p", 0)
    lines += ["state.k = k;" if law.uses_time else "(void)k;"]
    lines += _copies(law.memory, "state.", "x", 0)
    lines += _copies(law.readings, "readings.", "p", q) + _copies(law.references, "references.", "p", q + y)
    lines += [] if law.memory.size else ["(void)x;"]
    ports = ", ".join(
        f"&{port}" for port in ("state", "readings", "references", "commands") if f" {port};" in str(lines)
    )
    lines += [f"if ({identifier}_step({ports}) != (unsigned){identifier.upper()}_OK) {{", "    return 0;", "}"]
    lines += _copies(law.memory, "state.", "next", 0, back=True)
    lines += _copies(law.commands, "commands.", "next", law.memory.size, back=True)
    outputs = [f"y[{i}] = x[{law.memory.size + i}];" for i in range(law.commands.size)]
    return [
        f'#include "{identifier}.h"',
        "",
        f"static int model_step{HEAD.format('next')}",
        "{",
        *(f"    {line}" for line in (*lines, "return 1;")),
        "}",
        "",
        f"static void model_outputs{HEAD.format('y')}",
        "{",
        *(f"    {line}" for line in ("(void)k;", "(void)p;", *outputs)),
        "}",
    ]


def _copies(layout: Layout, struct: str, array: str, first: int, back: bool = False) -> list[str]:
    """Assignments from an array to the members of a struct, or back."""
    names, lines = members(layout), list[str]()
    for entry in layout.entries:
        for i in range(entry.size):
            place = f"{struct}{names[entry.name]}{f'[{i}]' if entry.shape else ''}"
            number = f"{array}[{first + len(lines)}]"
            lines.append(f"{number} = {place};" if back else f"{place} = {number};")
    return lines
