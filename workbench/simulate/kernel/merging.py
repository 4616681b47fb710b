"""Merging: one graph that runs each of several, so that loops which are much alike share the vectors of one march.

The graphs are walked side by side, from their results to their sources. Where all of them do the same to what is
already merged, it is done once for all; where they differ, each way is taken, and the one that is a run's own is
selected. So a run's values are made by the very operations of its own graph, and keep their bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.simulate.kernel.graph import COMMUTATIVE, Graph, Node, Nodes
from workbench.simulate.kernel.rewriting import ordered
from workbench.validation.refusals import Array, Integers

FUSED = {"fma", "fms", "fnma"}  # of which the first two operands may change places
WORTH = 0.65  # of all nodes: if no more are left, the graphs are alike

Row = tuple[int | None, ...]  # a place in each graph, or None in those that have no part in it
Column = tuple[Node | None, ...]  # what each graph has there: a number or a parameter


@dataclass(frozen=True, eq=False)
class Merged:
    """One graph for the runs of several.

    Attributes
    ----------
    graph
        Its parameters are those of the graphs, then one for each of the columns.
    parameters
        How many there are before the columns.
    columns
        For each the number that the runs of each graph have there, or which of their parameters.
    """

    graph: Graph
    parameters: int
    columns: tuple[Column, ...]

    def rows(self, p: Array, which: Integers) -> Array:
        """The parameters (B, ...) of the merged graph from those of runs (B, np) of the graphs `which` (B,)."""
        rows = np.zeros((len(p), self.parameters + len(self.columns)))
        rows[:, : p.shape[1]] = p
        for i in np.unique(which):
            of = which == i
            for place, column in enumerate(self.columns, self.parameters):
                if node := column[i]:
                    rows[of, place] = p[of, node.entry] if node.op == "p" else node.value
        return rows


def merged(graphs: Sequence[Graph], parameters: int) -> Merged | None:
    """The graphs, of equally many results and at most so many parameters, as one; None if they are not alike."""
    merger = _Merger(graphs, parameters)
    results = [merger.place(row) for row in zip(*(graph.results for graph in graphs), strict=True)]
    if len(merger.nodes.held) > WORTH * sum(len(graph.nodes) for graph in graphs):
        return None
    return Merged(ordered(Graph(tuple(merger.nodes.held), tuple(results))), parameters, tuple(merger.columns))


def widened(graph: Graph, rates: int, most: int, others: int) -> Graph:
    """The graph of rates and updates with as many of each as the largest of several; what it lacks stays zero.

    Its first `rates` results become the first of `most`, all others the first of `others` behind those.
    """
    nodes = [
        node._replace(entry=node.entry + most - rates) if node.op == "x" and node.entry >= rates else node
        for node in graph.nodes
    ]
    zero, own = len(nodes), graph.results
    lacking = (zero,) * (most - rates), (zero,) * (others - len(own) + rates)
    return Graph((*nodes, Node("const")), (*own[:rates], *lacking[0], *own[rates:], *lacking[1]))


class _Merger:
    """Walks the graphs side by side; a row of places is merged once, and so is what is within it."""

    def __init__(self, graphs: Sequence[Graph], parameters: int) -> None:
        self.graphs = graphs
        self.parameters = parameters
        self.nodes = Nodes()
        self.columns: dict[Column, int] = {}
        self.places: dict[Row, int] = {}
        self.rows: list[dict[int, Row]] = [{} for _ in graphs]  # for each place of a graph the fullest row it is in
        self.names = _names(graphs)
        self.named = [{name: place for place, name in enumerate(names)} for names in self.names]

    def place(self, row: Row) -> int:
        """Where the merged graph has the value of a row."""
        row = self._filled(row)
        stack = [(row, self._ways(row))]
        while stack:
            now, ways = stack[-1]
            below = [] if now in self.places else self._below(now, ways)
            if waiting := [part for part in below if part not in self.places]:
                stack += [(part, self._ways(part)) for part in waiting]
                continue
            stack.pop()
            if now not in self.places:
                self._keep(now, self._made(now, ways, [self.places[part] for part in below]))
        return self.places[row]

    def _filled(self, row: Row) -> Row:
        """The row with what is known to be the same value in the graphs that have no part in it."""
        if None not in row:
            return row
        members = [(i, place) for i, place in enumerate(row) if place is not None]
        i, place = members[0]
        merged = self.rows[i].get(place)
        if merged is not None and all(merged[i] == place for i, place in members):
            return merged
        names = {self.names[i][place] for i, place in members}
        if len(names) > 1:
            return row
        name = names.pop()
        return tuple([named.get(name) if own is None else own for named, own in zip(self.named, row, strict=True)])

    def _ways(self, row: Row) -> list[list[int]]:
        """The graphs that have a part in a row, by what they do there."""
        ways: dict[object, list[int]] = {}
        for i, place in enumerate(row):
            if place is not None:
                op, operands, _, entry = self.graphs[i].nodes[place]
                kind = op if operands else "number" if op in ("const", "p") else (op, entry)
                ways.setdefault(kind, []).append(i)
        return list(ways.values())

    def _below(self, row: Row, ways: list[list[int]]) -> list[Row]:
        """The rows that a row is made of: those of its operands, or of each way for itself."""
        if len(ways) == 1:
            operands = {i: self._operands(row, ways[0][0], i) for i in ways[0]}
            count = len(operands[ways[0][0]])
            rows = [{i: places[k] for i, places in operands.items()} for k in range(count)]
        else:
            rows = [{i: place for i, place in enumerate(row) if place is not None and i in way} for way in ways]
        return [self._filled(tuple([of.get(i) for i in range(len(row))])) for of in rows]

    def _operands(self, row: Row, first: int, i: int) -> tuple[int, ...]:
        """The operands in graph i, in the order in which they are most like those in the first one."""
        (op, mine, *_), (_, others, *_) = self._node(i, row[i]), self._node(first, row[first])
        if i == first or not _loose(op):
            return mine
        (a, b, *rest), (c, d, *_) = mine, others
        straight = self._likeness(first, c, i, a) + self._likeness(first, d, i, b)
        crossed = self._likeness(first, c, i, b) + self._likeness(first, d, i, a)
        return (b, a, *rest) if crossed > straight else mine

    def _likeness(self, first: int, a: int, i: int, b: int) -> int:
        """How alike a value of the first graph is to one of graph i."""
        if self.names[first][a] == self.names[i][b]:
            return 4
        merged, one, other = self.rows[first].get(a), self._node(first, a), self._node(i, b)
        same = (one.op == other.op) + (one.op == other.op and one.entry == other.entry)
        return same + 2 * (merged is not None and merged[i] == b)

    def _made(self, row: Row, ways: list[list[int]], below: list[int]) -> int:
        """What makes the value of a row from those of the rows below it."""
        first = ways[0][0]
        node = self._node(first, row[first])
        if len(ways) > 1:
            chosen = below[0]
            for way, place in zip(ways[1:], below[1:], strict=True):
                own = self._column(tuple([Node("const", value=float(i in way)) for i in range(len(row))]))
                chosen = self.nodes.add("if_else", (own, place, chosen))
            return chosen
        if node.op not in ("const", "p"):
            return self.nodes.add(node.op, tuple(below), entry=node.entry)
        column = tuple([None if place is None else self._node(i, place) for i, place in enumerate(row)])
        return self.nodes.add(*node) if len(set(column) - {None}) == 1 else self._column(column)

    def _column(self, column: Column) -> int:
        return self.nodes.add("p", entry=self.parameters + self.columns.setdefault(column, len(self.columns)))

    def _keep(self, row: Row, made: int) -> None:
        self.places[row] = made
        size = len(row) - row.count(None)
        for i, place in enumerate(row):
            if place is not None:
                known = self.rows[i].get(place)
                if known is None or len(known) - known.count(None) < size:
                    self.rows[i][place] = row

    def _node(self, i: int, place: int | None) -> Node:
        assert place is not None
        return self.graphs[i].nodes[place]


def _names(graphs: Sequence[Graph]) -> list[list[int]]:
    """A number for each value, the same for equal ones of all graphs, in whatever order their sums are written."""
    known: dict[tuple[object, ...], int] = {}
    names: list[list[int]] = []
    for graph in graphs:
        of: list[int] = []
        names.append(of)
        for op, operands, value, entry in graph.nodes:
            below = [of[i] for i in operands]
            loose = _loose(op)
            key = (op, *sorted(below[:loose]), *below[loose:], value, entry)
            of.append(known.setdefault(key, len(known)))
    return names


def _loose(op: str) -> int:
    """How many of the first operands may change places."""
    return 2 if op in COMMUTATIVE or op in FUSED else 0
