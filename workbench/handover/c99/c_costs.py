"""Costs of a call of a law in C: its operations by kind, and a bound of its stack, counted in the text."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

from workbench.engine.machines.operations import OPERATIONS
from workbench.handover.c99.c_loops import operations
from workbench.handover.law_graph import StepGraph

PLURALS = {  # of the kinds of operations, in the order of the sentence
    "sum": "sums",
    "product": "products",
    "quotient": "quotients",
    "comparison or choice": "comparisons and choices",
    "change of sign": "changes of sign",
}
FUNCTION = re.compile(r"^(?:static )?[\w ]+?\b(\w+)\(([^;{]*?)\)\n\{\n(.*?)^\}", re.MULTILINE | re.DOTALL)
ARRAY = re.compile(r"^ +(?:double|float) \w+\[(\d+)\];", re.MULTILINE)
BRANCH = re.compile(r"^ {8,}if \(w_", re.MULTILINE)  # in a loop
TABLE = re.compile(r"^ +static const (?:double|float) \w+\[(\d+)\]", re.MULTILINE)
VARIABLE = re.compile(r"^ +(?:for \()?(?:const )?(?:\w+|union \{[^}]*\}) (?:\*const )?(?:\w+)(?: =|;)", re.MULTILINE)
FRAME = 96  # bytes of a frame beside its variables: what is saved of registers, the address to return to, alignment


class CallCost(NamedTuple):
    """The sentence on the operations of a call, and the bytes of stack that it takes at most, as counted.

    `room` is the length of the array in the state for the arrays of loops, and `constants` that of all tables.
    """

    operations: str
    stack: int
    room: int = 0
    constants: int = 0


def costs_of(graph: StepGraph, text: str, name: str, room: int) -> CallCost:
    """The costs of a law from its graph, and from the text of its functions for NAME_step."""
    needed = [i for i in graph.graph.before(graph.graph.results) if i not in graph.numbers]
    kinds, calls = Counter[str](), Counter[str]()
    for op, times in operations(graph.graph, needed):
        words = OPERATIONS[op].count_words
        for kind in words:
            kinds[kind] += times
        if not words:
            calls[op] += times
    used = set(needed)
    fixed = sum(bool(graph.graph.nodes[i].operands) for i in graph.parameter_nodes if i in used)
    parts = [f"{kinds[one]} {one if kinds[one] == 1 else many}" for one, many in PLURALS.items() if kinds[one]]
    parts += [f"{count} {op}" for op, count in sorted(calls.items())]
    also = f"; {fixed} of them depend on numbers of the law alone" if fixed else ""
    most = "at most " if BRANCH.search(text) else ""
    made, constants = f"{most}{', '.join(parts) or 'nothing to compute'}{also}", sum(map(int, TABLE.findall(text)))
    return CallCost(made, deepest_chain(text, f"{name}_step"), room, constants)


def deepest_chain(text: str, start: str) -> int:
    """Bytes of the frames along the deepest chain of calls, if each variable, argument and call has 8 bytes."""
    bodies: dict[str, tuple[str, str]] = {name: (arguments, body) for name, arguments, body in FUNCTION.findall(text)}

    def called_functions(body: str) -> Iterator[str]:
        return (word for word in re.findall(r"\b(\w+)\(", body) if word in bodies)

    def depth(name: str) -> int:
        arguments, body = bodies[name]
        own = (
            len(VARIABLE.findall(body))
            + sum(map(int, ARRAY.findall(body)))
            + arguments.count(",")
            + 1
            + sum(1 for _ in called_functions(body))
        )
        return FRAME + 8 * own + max((depth(other) for other in set(called_functions(body))), default=0)

    return depth(start)
