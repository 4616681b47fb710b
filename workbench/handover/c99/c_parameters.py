"""The parameters of a law in C: a number each, which can be edited in the text or set in a struct."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable

from workbench.core import SampledLaw
from workbench.core.units import ANY
from workbench.engine.machines.c_real import DOUBLE, SINGLE, word_text
from workbench.handover.c99.c_header import WIDTH, block
from workbench.handover.c99.c_names import Member, Variables, comment, entries_of
from workbench.handover.c99.c_request import Request
from workbench.handover.law_graph import graph_of_law

EDIT = (
    "Numbers of the law. To change one, edit its line here: all that depends on it is computed from this line, and "
    "equal numbers are not merged. The start of the memory, the safe command and the period are not made of them."
)


def parameters_of(request: Request, variables: Variables) -> list[Member]:
    """A variable for each number of the parameters, whose value is in a struct, or built in as C reads it."""
    law = request.law
    own = entries_of(variables, law.parameters, "state->parameters.")
    if request.settable:
        return own
    units = [unit for entry in law.parameters.entries for unit in entry.units]
    return [
        Member(name, _text(request.name, value), f"{path}{f' [{unit}]' if unit not in ('', ANY) else ''}")
        for (name, _, path), unit, value in zip(own, units, law.parameters.default.tolist(), strict=True)
    ]


def _text(prefix: str, value: float) -> str:
    if math.isfinite(value):
        return DOUBLE.literal(value)
    return f"{prefix}_number({word_text(DOUBLE.pattern(value))})"


def built_in(entries: Iterable[Member], tables: Iterable[str] = ()) -> list[str]:
    """The lines of the numbers that are built in, each with its path and unit, and behind them those of tables."""
    lines = [f"const double {name} = {value}; /* {comment(label)} */" for name, value, label in entries]
    lines += tables
    return ["", *block(textwrap.wrap(EDIT, WIDTH)), *lines] if lines else []


def refuse_numbers_beyond_single(law: SampledLaw) -> None:
    """Refuse a law whose numbers, or what is made of them alone, have no finite value in single precision."""
    graph = graph_of_law(law)
    nodes, numbers = graph.graph.nodes, graph.numbers
    moving = (place for place in graph.graph.before(graph.graph.results) if place not in numbers)
    for place in dict.fromkeys(i for moved in moving for i in nodes[moved].operands if i in numbers):
        if math.isfinite(numbers[place]):
            SINGLE.literal(numbers[place])
