"""The lines of Python for a graph."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from workbench.engine.kernel.graph import ARRAYS, Graph, Level, Node, length
from workbench.engine.machines.operations import OF_NUMBERS, OPERATIONS, Kind
from workbench.engine.machines.python_elementary_functions import NAMES, TURNS
from workbench.engine.machines.python_spelling import PythonLines, literal

OF_ARRAYS = frozenset((*ARRAYS, "item"))


def lines_of(graph: Graph, h: float, source: Callable[[str, int], str]) -> tuple[list[str], list[str]]:
    """The assignments that make the values of a graph for steps of h [s], and the texts of its results.

    `source` has the variable of an entry of k, x or p.
    """
    writer = _Graph(graph, h, source)
    for place in range(len(graph.nodes)):
        writer.write(place)
    return writer.machine.lines, [writer.number_of(place) for place in graph.results]


def _range(k: str, size: int) -> str:
    return f"{size} * {k}:{size} * {k} + {size}"


def _part(name: str, array: str, k: str, size: int) -> str:
    return f"{name} = {array}[{_range(k, size)}]"


class _Graph:
    def __init__(
        self, graph: Graph, h: float, source: Callable[[str, int], str], counts: Iterator[int] | None = None
    ) -> None:
        self.graph, self.source, self.h = graph, source, h
        self.machine = PythonLines(counts)
        self.constants = graph.numbers(h)
        self.numbers: dict[int, str] = {}
        self.truths: dict[int, str] = {}
        self.angles: dict[int, str] = {}
        self.loops: dict[int, list[str]] = {}

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
        if node.op == "loop":
            self.loops[place] = self._loop(node)
        elif node.op in OF_ARRAYS:
            self.numbers[place] = self._of_arrays(node)
        elif self.graph.levels[place] is Level.LENGTH:
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

    def _of_arrays(self, node: Node) -> str:
        """A list, or an entry of one."""
        first = node.operands[0]
        match node.op:
            case "loop_end":
                return self.loops[first][0]
            case "loop_rows":
                return self.loops[first][1 + node.entry]
            case "item":
                return self.machine.line(f"{self.numbers[first]}[{node.entry}]")
            case "slice":
                return self.machine.line(f"{self.numbers[first]}[{node.entry}:{node.entry + length(node)}]")
        return self.machine.line(self._list(node.operands))

    def _list(self, places: Sequence[int]) -> str:
        stars = ("*" if length(self.graph.nodes[i]) else "" for i in places)
        return f"[{', '.join(star + self.number_of(i) for star, i in zip(stars, places, strict=True))}]"

    def _loop(self, node: Node) -> list[str]:
        """The lists of the carried values at the end of a loop, and of the rows that it made."""
        loop, names = node.loop, [self.number_of(i) for i in node.operands[node.entry :]]
        assert loop is not None
        rows, shared = names[: len(loop.row_sizes)], names[len(loop.row_sizes) :]
        machine, last = self.machine, loop.count - 1
        carried = machine.line(self._list(node.operands[: node.entry]))
        made = [machine.line(f"[0.0] * {size * loop.count}") for size in loop.result_sizes]
        k = f"k{next(machine.counts)}"
        machine.lines.append(f"for {k} in range({f'{last}, -1, -1' if loop.backward else loop.count}):")
        own = [f"row{next(machine.counts)}" for _ in rows]
        inner = [_part(array, name, k, size) for array, name, size in zip(own, rows, loop.row_sizes, strict=True)]

        def source(op: str, entry: int) -> str:
            return carried if op == "carried" else own[entry] if op == "row" else shared[entry]

        body = _Graph(loop.body, self.h, source, machine.counts)
        for place in range(len(loop.body.nodes)):
            body.write(place)
        ends, *made_rows = loop.split(loop.body.results)
        inner += body.machine.lines
        inner += [
            f"{array}[{_range(k, size)}] = {body._list(row)}"
            for array, size, row in zip(made, loop.result_sizes, made_rows, strict=True)
        ]
        machine.lines += [f"    {line}" for line in (*inner, f"{carried} = {body._list(ends)}")]
        return [carried, *made]

    def _turn(self, op: str, angle: int) -> str:
        if angle not in self.angles:
            self.angles[angle] = self.machine.line(f"reduced({self.number_of(angle)})")
        return self.machine.line(f"{TURNS[op]}(*{self.angles[angle]})")
