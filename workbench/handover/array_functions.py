"""Laws without memory as functions of arrays: a file in C, a module of Python over NumPy, or one with CasADi.

The readings of a law are the arguments of its function, one array each, and its parameters are the array `p`; the
function gives the commands. C and Python have the bits of the portable arithmetic.
"""

from __future__ import annotations

import keyword
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import casadi as ca

from workbench.core.layout import Entry, Layout
from workbench.core.notation.comments import harmless
from workbench.core.notation.program import straight_line
from workbench.core.sampled_law import SampledLaw
from workbench.core.templates import fill
from workbench.core.validation.refusals import known_name
from workbench.core.validation.signatures import check_arguments
from workbench.engine.kernel.graph import Graph
from workbench.engine.machines.c_elementary_functions import definitions as definitions_in_c
from workbench.engine.machines.c_real import DOUBLE
from workbench.engine.machines.c_spelling import Text
from workbench.engine.machines.operations import Tightness
from workbench.engine.machines.python_elementary_functions import PYTHON_FUNCTIONS
from workbench.engine.machines.python_elementary_functions import definitions as definitions_in_python
from workbench.engine.machines.python_spelling import HELPERS
from workbench.handover.c99.c_assignments import Assignments, Demand, ValueForm, assignments
from workbench.handover.c99.c_names import Variables, prefix_of
from workbench.handover.c99.c_scope import ROOM, Scope
from workbench.handover.c99.c_source import guards
from workbench.handover.law_graph import StepGraph, graph_of_law
from workbench.handover.programs.casadi_law import CASADI
from workbench.handover.programs.python_lines import lines_of

PREFIX, PARAMETERS = "workbench", "p"
# Names that the files use themselves: modules, the parameters, and the functions that Python's lines call.
RESERVED_NAMES = frozenset(
    ["np", "ca", "math", "struct", "float", "abs", "int", "NOMINAL", PARAMETERS, *HELPERS, *PYTHON_FUNCTIONS]
)

Words = dict[str, object]


@check_arguments
def array_functions(
    laws: Sequence[SampledLaw],
    form: str,
    about: Sequence[str],
    parameters: Sequence[str],
    sizes: Mapping[str, int] | None = None,
) -> str:
    """The text of a file with the function of each law, called by the law's name.

    Parameters
    ----------
    laws
        Laws without memory and references, which share their parameters.
    form
        "c", "python" or "casadi".
    about
        The lines at the head of the file.
    parameters
        A line about each number of the parameters.
    sizes
        Whole numbers that the file in C defines, by their names.

    Raises
    ------
    ValueError
        If a law has memory or references, or depends on the time, or an operation that no kernel has.
    LookupError
        If there is no such form.
    """
    writer = FORMS[known_name(form, FORMS, "forms of functions")]
    _refuse(laws, parameters)
    values = [repr(float(value)) for value in laws[0].parameters.default]
    nominal = list(zip(values, map(harmless, parameters), strict=True))
    return writer(laws, {"about": [harmless(line) for line in about], "nominal": nominal, "sizes": sizes or {}})


def _refuse(laws: Sequence[SampledLaw], parameters: Sequence[str]) -> None:
    """Refuse laws that are no functions of their readings, that differ in their parameters, or have odd names."""
    if not laws or any(law.parameters.labels != laws[0].parameters.labels for law in laws):
        raise ValueError("`array_functions(laws=...)` must be one law or more, with the same parameters.")
    if len(parameters) != laws[0].parameters.size:
        raise ValueError(
            f"`array_functions(parameters=...)` must have one line for each of the {laws[0].parameters.size} "
            f"numbers of the parameters; got {len(parameters)}."
        )
    for law in laws:
        if law.memory.size or law.references.size or law.uses_time:
            raise ValueError(
                "`array_functions(laws=...)` must be laws without memory, references and time, so that they are "
                f"functions; '{law.name}' has one of these. Take `c_code(law)`, which has a struct for them."
            )
        names = [law.name, *law.readings.names, *law.commands.names]
        for name in map(prefix_of, names):
            if keyword.iskeyword(name) or name in RESERVED_NAMES or names.count(name) > 1:
                raise ValueError(
                    "`array_functions(laws=...)` needs a different name for each function, reading and command; no "
                    f"name may be a keyword of Python or a name that the file uses. '{law.name}' has '{name}'. Rename "
                    "it."
                )


def _words(law: SampledLaw) -> Words:
    return {
        "name": law.name,
        "about": harmless(" ".join(law.notes)),
        "arguments": list(law.readings.names),
        "outputs": list(law.commands.names),
    }


class Input(NamedTuple):
    """A number that a law is handed: its variable, and the entry of an array that it is read from."""

    variable: str
    place: str


def _inputs(law: SampledLaw) -> list[Input]:
    """The parameters and the readings of a law, in the order of its step's parameters."""
    variables = Variables([*law.readings.names, *law.commands.names, *RESERVED_NAMES, *keyword.kwlist])
    inputs = [
        Input(variables.new(f"{PARAMETERS}_{label}"), f"{PARAMETERS}[{i}]")
        for i, label in enumerate(law.parameters.labels)
    ]
    for entry in law.readings.entries:
        names = variables.entries(entry.name, entry.shape)
        inputs += [Input(name, f"{entry.name}[{i}]") for i, name in enumerate(names)]
    return inputs


def _variable(inputs: Sequence[Input], _: str, entry: int) -> str:
    return inputs[entry].variable


def _reads(graph: Graph, inputs: Sequence[Input]) -> list[Input]:
    """The inputs that the results of a graph need."""
    needed = {graph.nodes[i].entry for i in graph.before(graph.results) if graph.nodes[i].op == "p"}
    return [each for entry, each in enumerate(inputs) if entry in needed]


def _rows(entry: Entry, texts: Sequence[str]) -> list[list[str]]:
    """The texts of an entry's numbers, which lie column by column, row by row."""
    rows, columns = (*entry.shape, 1, 1)[:2]
    return [[texts[i + rows * j] for j in range(columns)] for i in range(rows)]


def _outputs(commands: Layout, texts: Sequence[str]) -> list[tuple[Entry, list[list[str]]]]:
    return [(entry, _rows(entry, texts[commands.slice(entry.name)])) for entry in commands.entries]


def _in_c(laws: Sequence[SampledLaw], words: Words) -> str:
    functions, calls = list[Words](), dict[str, None]()
    for law in laws:
        inputs, step = _inputs(law), graph_of_law(law, settable=True)
        made = _assignments(step, inputs)
        reads = _reads(step.graph, inputs)
        arguments = [*law.readings.names, PARAMETERS]
        unread = [name for name in arguments if not any(each.place.startswith(f"{name}[") for each in reads)]
        flat = [
            (f"{entry.name}[{i}]", text)
            for entry, rows in _outputs(law.commands, made.answers[-1].texts)
            for i, text in enumerate(text for row in rows for text in row)
        ]
        lines = [f"double {ROOM}[{made.room}];"] if made.room else []
        lines += [line for answer in made.answers for line in answer.lines]
        functions.append(
            _words(law) | {"arguments": arguments, "unread": unread, "reads": reads, "lines": lines, "results": flat}
        )
        calls |= dict.fromkeys(call.name for call in made.calls)
    own = {"prefix": PREFIX, "guards": guards(), "definitions": definitions_in_c(PREFIX, DOUBLE, calls)}
    return fill("workbench.handover", "functions/functions.c.j2", **words, **own, functions=functions)


def _assignments(step: StepGraph, inputs: Sequence[Input]) -> Assignments:
    """The lines in C of the results of a step, and their texts."""
    graph = step.graph
    sources = {
        place: Text(inputs[node.entry].variable, Tightness.ATOM)
        for place, node in enumerate(graph.nodes)
        if node.op == "p"
    }
    scope = Scope(graph, PREFIX, DOUBLE, step.numbers, sources)
    return assignments(scope, [Demand(graph.results), Demand(graph.results, ValueForm.TEXT)])


def _in_python(laws: Sequence[SampledLaw], words: Words) -> str:
    functions, lines = list[Words](), list[str]()
    for law in laws:
        graph, inputs = graph_of_law(law, settable=True).graph, _inputs(law)
        made, texts = lines_of(graph, law.period, partial(_variable, inputs))
        results = [
            (entry.name, [f"[{', '.join(row)}]" if len(entry.shape) > 1 else row[0] for row in rows])
            for entry, rows in _outputs(law.commands, texts)
        ]
        functions.append(_words(law) | {"reads": _reads(graph, inputs), "lines": made, "results": results})
        lines += made
    own = {"definitions": definitions_in_python(lines), "functions": functions}
    return fill("workbench.handover", "functions/functions.py.j2", **words, **own)


def _in_casadi(laws: Sequence[SampledLaw], words: Words) -> str:
    functions, sizes = list[Words](), {PARAMETERS: laws[0].parameters.size}
    for law in laws:
        inputs = _inputs(law)
        symbols = ca.vertcat(ca.SX(0, 1), *(ca.SX.sym(each.variable) for each in inputs))
        value = ca.substitute([ca.densify(law.command)], [ca.vertcat(law.p, law.y)], [symbols])[0]
        program = straight_line({"w": value}, {}, CASADI)
        entries = dict(inputs)
        texts = [row[0] for row in program.entries["w"]]
        results = [
            (entry.name, [f"ca.horzcat({', '.join(row)})" if len(entry.shape) > 1 else row[0] for row in rows])
            for entry, rows in _outputs(law.commands, texts)
        ]
        reads = [(variable, entries[symbol]) for variable, symbol in program.inputs]
        functions.append(_words(law) | {"reads": reads, "lines": program.lines, "results": results})
        sizes |= {entry.name: entry.size for entry in law.readings.entries}
    return fill("workbench.handover", "functions/casadi_functions.py.j2", **words, functions=functions, symbols=sizes)


FORMS: Mapping[str, Callable[[Sequence[SampledLaw], Words], str]] = {
    "c": _in_c,
    "python": _in_python,
    "casadi": _in_casadi,
}
