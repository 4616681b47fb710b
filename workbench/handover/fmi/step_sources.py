"""The C of a model: its numbers, its names, and the functions `model_step` and `model_outputs`."""

from __future__ import annotations

import math
from collections.abc import Iterable

from workbench.core import Layout, SampledLaw
from workbench.core.templates import fill, template_text
from workbench.engine.kernel.graph import Graph
from workbench.engine.kernel.plan import graph_of
from workbench.engine.machines.c_elementary_functions import definitions
from workbench.engine.machines.c_real import DOUBLE
from workbench.engine.machines.c_spelling import Text
from workbench.engine.machines.operations import Tightness
from workbench.handover.c99.c_assignments import Assignments, Demand, ValueForm, assignments
from workbench.handover.c99.c_files import c_code
from workbench.handover.c99.c_names import members
from workbench.handover.c99.c_scope import ROOM, Scope
from workbench.handover.c99.c_source import guards
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
        guards=guards(),
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
    step, outputs = _scope(graph_of(model.step), model), _scope(model.readout, model)
    steps, reads = (assignments(scope, _demands(scope)) for scope in (step, outputs))
    texts = [
        *_function("int model_step", "next", step, steps, ["return 1;"]),
        "",
        *_function("void model_outputs", "y", outputs, reads, []),
    ]
    called = definitions("model", DOUBLE, [call.name for call in (*steps.calls, *reads.calls)])
    return [*(line for text in called for line in (text, "")), *texts]


def _demands(scope: Scope) -> tuple[Demand, ...]:
    return Demand(scope.graph.results), Demand(scope.graph.results, ValueForm.TEXT)


def _scope(graph: Graph, model: Model) -> Scope:
    forms = {"k": "time", "x": "x[{}]", "p": "p[{}]"}
    sources = {
        place: Text(forms[node.op].format(node.entry), Tightness.ATOM)
        for place, node in enumerate(graph.nodes)
        if node.op in forms
    }
    return Scope(graph, "model", DOUBLE, graph.numbers(model.step.h), sources)


def _function(head: str, target: str, scope: Scope, written: Assignments, ends: list[str]) -> list[str]:
    made, asked = written.answers
    results = [f"{target}[{i}] = {text};" for i, text in enumerate(asked.texts)]
    ops = {scope.graph.nodes[i].op for i in scope.graph.before(scope.graph.results)}
    unread = [f"(void){name};" for name, op in (("time", "k"), ("x", "x"), ("p", "p")) if op not in ops]
    unread += [] if results else [f"(void){target};"]
    room = [f"double {ROOM}[{written.room}];"] if written.room else []
    lines = ["const double time = (double)k; /* steps */", *unread, *room, *made.lines, *asked.lines, *results, *ends]
    return [f"static {head}{HEAD.format(target)}", "{", *(f"    {line}" for line in lines), "}"]


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
