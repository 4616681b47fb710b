"""Arrays that a law need not make in a call: tables of its numbers, and parts of its state where they are."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from workbench.engine.kernel.graph import Graph
from workbench.handover.c99.c_names import Member, Variables, comment
from workbench.handover.c99.c_request import Request

LEAST = 8  # entries of a table
INDEX = re.compile(r"(.*)\[(\d+)\]")


class LawArrays(NamedTuple):
    """The texts of arrays by their nodes, the nodes that only they need, and the lines that declare tables."""

    texts: Mapping[int, str]
    inside: frozenset[int]
    lines: tuple[str, ...]


def arrays_of(
    request: Request, graph: Graph, names: Variables, parameters: Sequence[Member], memory: Sequence[Member]
) -> LawArrays:
    """The arrays of a law's graph that are made of numbers of the law, or of memory in its order, alone."""
    users = Counter(i for place in graph.before(graph.results) for i in graph.nodes[place].operands)
    users.update(graph.results)
    texts, lines, inside = dict[int, str](), list[str](), set[int]()
    values = request.law.parameters.default.tolist()
    for place in graph.before(graph.results):
        node = graph.nodes[place]
        parts = [graph.nodes[i] for i in node.operands]
        if node.op != "array" or len(parts) < LEAST:
            continue
        if all(one.op == "x" for one in parts):
            text = _part_of_memory([memory[one.entry].source for one in parts])
        elif all(one.op == "p" and users[i] == 1 for one, i in zip(parts, node.operands, strict=True)):
            own = [one.entry for one in parts]
            text, is_of_law = "", max(own) < len(parameters)
            if request.settable and is_of_law and request.real.type == "double":
                text = _part_of_memory([parameters[i].source for i in own])
            elif not request.settable and is_of_law and all(math.isfinite(values[i]) for i in own):
                text = names.new(f"{parameters[own[0]].variable.partition('_')[0]}_table")
                lines += _table(request, text, [parameters[i] for i in own])
        else:
            continue
        if text:
            texts[place] = text
            inside |= {i for i in node.operands if users[i] == 1}
    return LawArrays(texts, frozenset(inside), tuple(lines))


def _part_of_memory(sources: Sequence[str]) -> str:
    """The expression of entries of the memory that stand one behind the other; empty if they do not."""
    matches = [INDEX.fullmatch(source) for source in sources]
    places = [(match[1], int(match[2])) for match in matches if match]
    if len(places) != len(sources):
        return ""
    name, first = places[0]
    if places != [(name, first + i) for i in range(len(places))]:
        return ""
    return f"{name} + {first}" if first else name


def _table(request: Request, name: str, members: Sequence[Member]) -> list[str]:
    """The declaration of a table, with a line for each number."""
    cast = "" if request.real.type == "double" else f"({request.real.type})"
    lines = [f"    {cast}{source}, /* {comment(label)} */" for _, source, label in members]
    return [f"static const {request.real.type} {name}[{len(members)}] = {{", *lines, "};"]
