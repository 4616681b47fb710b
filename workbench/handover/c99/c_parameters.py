"""The parameters of a law in C: a number each, which can be edited in the text or set in a struct."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable
from typing import Any

from workbench.core import SampledLaw
from workbench.core.units import ANY
from workbench.handover.c99.c_header import WIDTH, block
from workbench.handover.c99.c_names import Variables, comment, entries_of
from workbench.handover.c99.c_primitives import DOUBLE, SINGLE, word_text
from workbench.handover.law_graph import graph_of_law

EDIT = (
    "Numbers of the law. To change one, edit its line here: all that depends on it is computed from this line, and "
    "equal numbers are not merged. The start of the memory, the safe command and the period are not made of them."
)


def parameters_of(code: Any, variables: Variables) -> list[tuple[str, str, str]]:
    """A variable, its value as C reads it and a label for each number of the parameters."""
    law: SampledLaw = code.law
    own = entries_of(variables, law.parameters, "state->parameters.")
    if code.settable:
        return own
    units = [unit for entry in law.parameters.entries for unit in entry.units]
    labels = [
        f"{path}{f' [{unit}]' if unit not in ('', ANY) else ''}" for (*_, path), unit in zip(own, units, strict=True)
    ]
    values = [_text(code.name, value) for value in law.parameters.default.tolist()]
    return [(name, value, label) for (name, *_), value, label in zip(own, values, labels, strict=True)]


def _text(prefix: str, value: float) -> str:
    if math.isfinite(value):
        return DOUBLE.literal(value)
    return f"{prefix}_number({word_text(DOUBLE.pattern(value))})"


def built_in(entries: Iterable[tuple[str, str, str]]) -> list[str]:
    """The lines of the numbers that are built in, each with its path and unit."""
    lines = [f"const double {name} = {value}; /* {comment(label)} */" for name, value, label in entries]
    return ["", *block(textwrap.wrap(EDIT, WIDTH)), *lines] if lines else []


def refuse_numbers_beyond_single(law: SampledLaw) -> None:
    """Refuse a law whose numbers, or what is made of them alone, have no finite value in single precision."""
    graph = graph_of_law(law)
    nodes, numbers = graph.graph.nodes, graph.numbers
    moving = (place for place in graph.graph.before(graph.graph.results) if place not in numbers)
    for place in dict.fromkeys(i for moved in moving for i in nodes[moved].operands if i in numbers):
        if math.isfinite(numbers[place]):
            SINGLE.literal(numbers[place])
