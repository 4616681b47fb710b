"""The writer of the loops and arrays of a graph in C, for one that writes its other operations."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Protocol

from workbench.engine.kernel.graph import Graph, Node, length
from workbench.engine.machines.c_real import Real
from workbench.engine.machines.c_spelling import Text
from workbench.engine.machines.operations import Tightness
from workbench.handover.c99.c_loops import LoopNames, LoopText, PartText, array_lines, loop_lines, slice_text


class LoopScope(Protocol):
    """The scope of a writer: its graph, the format of its numbers, and the array for the arrays of loops."""

    @property
    def graph(self) -> Graph: ...  # noqa: D102
    @property
    def real(self) -> Real: ...  # noqa: D102
    @property
    def room(self) -> str: ...  # noqa: D102


class AbstractLoopWriter(ABC):
    """The loops and arrays of a graph, whose other values a writer has as texts."""

    scope: LoopScope
    texts: dict[int, Text]
    lines: list[str]
    loop_names: LoopNames
    loops: dict[int, LoopText]

    @abstractmethod
    def number(self, place: int) -> Text:
        """A value as a number of the scope's format."""

    @abstractmethod
    def variable(self, text: Text) -> Text:
        """A new variable with a value."""

    @abstractmethod
    def inside(self, body: Graph, carry_size: int, sources: Mapping[int, Text]) -> tuple[list[str], list[PartText]]:
        """The lines of a pass of a body, and its results, of which the first are the next carried values."""

    def array(self, place: int, node: Node) -> str:
        """The expression of an array; the lines that make it stand before it. That of a loop is not used."""
        first = node.operands[0]
        match node.op:
            case "loop":
                self.loops[place] = self._loop(node)
                return ""
            case "loop_end":
                return self.loops[first].carry
            case "loop_rows":
                return self.loops[first].rows[node.entry]
            case "slice":
                return slice_text(self.texts[first].text, node.entry)
        parts = [self.part(i) for i in node.operands]
        name, lines = array_lines(self.scope.real.type, self.scope.room, self.loop_names, parts)
        self.lines += lines
        return name

    def part(self, place: int) -> PartText:
        """A value as a part of an array; a number is a variable, or stands as it is."""
        if size := length(self.scope.graph.nodes[place]):
            return PartText(self.texts[place].text, size)
        number = self.number(place)
        return PartText((number if number.plain else self.variable(number)).text)

    def _loop(self, node: Node) -> LoopText:
        loop, parts = node.loop, [self.part(i) for i in node.operands]
        assert loop is not None
        first, last = node.entry, node.entry + len(loop.row_sizes)
        rows, shared = [part.text for part in parts[first:last]], parts[last:]

        def one_pass(carry: str, own: Sequence[str]) -> tuple[list[str], list[PartText]]:
            def source(op: str, entry: int) -> Text:
                text = carry if op == "carried" else own[entry] if op == "row" else shared[entry].text
                return Text(text, Tightness.ATOM, plain=True)

            single = loop.parts[0] if loop.parts[0] == loop.carry_size else 0  # none where arrays are among them
            outside = [(i, one) for i, one in enumerate(loop.body.nodes) if not one.operands and one.op != "const"]
            return self.inside(loop.body, single, {i: source(one.op, one.entry) for i, one in outside})

        scope = self.scope.real.type, self.scope.room
        text = loop_lines(scope, self.loop_names, loop, parts[:first], rows, one_pass)
        self.lines += text.lines
        return text
