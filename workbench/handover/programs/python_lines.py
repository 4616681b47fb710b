"""The lines of Python for a graph."""

from __future__ import annotations

from collections.abc import Callable

from workbench.engine.kernel.graph import Graph, Level
from workbench.engine.machines.operations import OF_NUMBERS, OPERATIONS, Kind
from workbench.engine.machines.python_elementary_functions import NAMES, TURNS
from workbench.engine.machines.python_spelling import PythonLines, literal


def lines_of(graph: Graph, h: float, source: Callable[[str, int], str]) -> tuple[list[str], list[str]]:
    """The assignments that make the values of a graph for steps of h [s], and the texts of its results.

    `source` has the variable of an entry of k, x or p.
    """
    writer = _Graph(graph, h, source)
    for place in range(len(graph.nodes)):
        writer.write(place)
    return writer.machine.lines, [writer.number_of(place) for place in graph.results]


class _Graph:
    def __init__(self, graph: Graph, h: float, source: Callable[[str, int], str]) -> None:
        self.graph, self.source = graph, source
        self.machine = PythonLines()
        self.constants = graph.numbers(h)
        self.numbers: dict[int, str] = {}
        self.truths: dict[int, str] = {}
        self.angles: dict[int, str] = {}

    def number_of(self, place: int) -> str:
        if place not in self.numbers:
            self.numbers[place] = self.machine.do("select", self.truths[place], "1.0", "0.0")
        return self.numbers[place]

    def truth_of(self, place: int) -> str:
        if place not in self.truths:
            self.truths[place] = self.machine.do("ne", self.numbers[place], "0.0")
        return self.truths[place]

    def write(self, place: int) -> None:
        node = self.graph.nodes[place]
        if self.graph.levels[place] is Level.LENGTH:
            self.numbers[place] = literal(self.constants[place])
        elif not node.operands:
            self.numbers[place] = self.source(node.op, node.entry)
        elif node.op in TURNS:
            self.numbers[place] = self._turn(node.op, node.operands[0])
        elif node.op in NAMES:
            arguments = ", ".join(map(self.number_of, node.operands))
            self.numbers[place] = self.machine.line(f"{NAMES[node.op]}({arguments})")
        elif node.op in OF_NUMBERS:
            self.numbers[place] = self.machine.do(node.op, *map(self.number_of, node.operands))
        else:
            row = OPERATIONS[node.op]
            pairs = zip(node.operands, row.operands, strict=True)
            operands = [self.truth_of(i) if kind is Kind.TRUTH else self.number_of(i) for i, kind in pairs]
            values = self.truths if row.result is Kind.TRUTH else self.numbers
            values[place] = self.machine.do(node.op, *operands)

    def _turn(self, op: str, angle: int) -> str:
        if angle not in self.angles:
            self.angles[angle] = self.machine.line(f"reduced({self.number_of(angle)})")
        return self.machine.line(f"{TURNS[op]}(*{self.angles[angle]})")
