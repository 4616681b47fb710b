"""Stages: the graph of a whole step from that of its rates: a Runge-Kutta step, and one from switch to switch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from workbench.core.methods import RK4, Method
from workbench.engine.kernel.graph import Graph, Nodes


class SegmentPlaces(NamedTuple):
    """The places of the results of a step that may have several segments."""

    several: int
    start: tuple[int, ...]  # the states at the begin of the first
    more: int  # whether another segment follows one that begins at s in the state z
    end: int  # where that one ends
    ends: tuple[int, ...]  # the states there


def step_graph(graph: Graph, rates: int, segments: Graph | None = None, method: Method = RK4) -> Graph:
    """The graph of x+: a Runge-Kutta step of the first `rates` results, which are dx/dt; the others unchanged.

    Behind x+ stand the results of `_segmented`, if the graph of the parts of `core.Segments` is given.
    """
    nodes = Nodes()
    needed = {node.entry for node in graph.nodes if node.op == "x"}
    before = {i: nodes.add("x", entry=i) for i in sorted(needed.union(range(rates)))}
    after = _advance(graph, graph.results, _Span(nodes), before, rates, method)
    if segments is not None:
        after += _segment_results(segments, nodes, method, after)
    return Graph(tuple(nodes.nodes), tuple(after))


def _segment_results(graph: Graph, nodes: Nodes, method: Method, after: Sequence[int]) -> list[int]:
    """The truth that a step has several segments, and the states at the begin of the first; then one from s and z.

    Of that one: the truth that another follows, the offset at which it ends, and the states there.
    """
    first, length, end, *others = graph.results
    n, whole = len(others) // 2, _Span(nodes)
    before = {node.entry: nodes.add("x", entry=node.entry) for node in graph.nodes if node.op == "x"}
    first, length, *start = _put_results(graph, (first, length, *others[:n]), nodes, whole, 0.0, before, after)
    state = {i: nodes.add("z", entry=i) for i in range(n)}
    s = nodes.add("s")
    (end,) = _put_results(graph, (end,), nodes, whole, 0.0, state)
    ends = _advance(graph, others[n:], _Span(nodes, s, nodes.add("sub", (end, s))), state, n, method)
    # a run whose segments are done waits for those beside it
    goes = nodes.add("lt", (s, length))
    ends = [nodes.add("if_else", (goes, new, state[i])) for i, new in enumerate(ends)]
    end = nodes.add("if_else", (goes, end, s))
    return [nodes.add("lt", (first, length)), *start, nodes.add("lt", (end, length)), end, *ends]


class _Span(NamedTuple):
    """A step, or a segment of one that begins at an offset from k h and has a length."""

    nodes: Nodes
    offset: int | None = None
    part: int | None = None

    @property
    def length(self) -> int:
        """The place of its length."""
        return self.nodes.add("h") if self.part is None else self.part

    def time(self, node: float) -> int:
        """The time at a `node` of it, from 0 to 1, each part added to those before it."""
        add = self.nodes.add
        begin = add("mul", (add("k"), add("h")))
        if self.offset is not None:
            begin = add("add", (begin, self.offset))
        return add("add", (begin, add("mul", (self.nodes.constant(node), self.length)))) if node else begin


def _advance(
    graph: Graph, results: Sequence[int], span: _Span, before: Mapping[int, int], rates: int, method: Method
) -> list[int]:
    """The Runge-Kutta step along a span of the first results, which are dx/dt, and the others at its begin."""
    nodes = span.nodes
    add, constant = nodes.add, nodes.constant
    if not rates:
        return _put_results(graph, results, nodes, span, 0.0, before)
    needed = {node.entry for node in graph.nodes if node.op == "x"}
    now, total, updates = before, list[int](), list[int]()
    for node, ahead, weight in zip(method.nodes, method.ahead, method.weights, strict=True):
        made = _put_results(graph, results[:rates] if total else results, nodes, span, node, now)
        updates += made[rates:]
        total = [_plus(nodes, weight, *both) for both in zip(made, total, strict=True)] if total else made[:rates]
        if ahead:
            step = add("mul", (constant(ahead), span.length))
            now = {**before, **{i: add("fma", (step, made[i], before[i])) for i in range(rates) if i in needed}}
    share = add("div", (span.length, constant(method.divisor)))
    return [*(add("fma", (share, rate, before[i])) for i, rate in enumerate(total)), *updates]


def _plus(nodes: Nodes, weight: float, rate: int, so_far: int) -> int:
    return nodes.add("add", (so_far, rate)) if weight == 1 else nodes.add("fma", (nodes.constant(weight), rate, so_far))


def _put_results(
    graph: Graph,
    results: Sequence[int],
    nodes: Nodes,
    span: _Span,
    node: float,
    state: Mapping[int, int],
    after: Sequence[int] = (),
) -> list[int]:
    """The places of some results once their graph is among others, at `node` of a span, this state, and x+ `after`."""
    new: dict[int, int] = {}
    for place in graph.before(results):
        op, operands, value, entry, loop = graph.nodes[place]
        if op in ("t", "m"):
            new[place] = span.time(0.5 if op == "m" else node)
        elif op == "x":
            new[place] = state[entry]
        elif op == "e":
            new[place] = after[entry]
        else:
            new[place] = nodes.add(op, tuple([new[i] for i in operands]), value, entry, loop)
    return [new[place] for place in results]
