"""Stages: from the graph of a step's rates and updates, which is read once, to that of the whole step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from workbench.core.step import AHEAD, DIVISOR, NODES, WEIGHTS
from workbench.simulate.kernel.graph import Graph, Nodes


def stepped(graph: Graph, rates: int) -> Graph:
    """The graph of x+: its first `rates` results are dx/dt of as many states, which take a Runge-Kutta step.

    The other results are what the other states become, as they are at the beginning of the step. No rate
    knows those.
    """
    nodes = Nodes()
    add, constant = nodes.add, nodes.constant
    needed = {node.entry for node in graph.nodes if node.op == "x"}
    before = {i: add("x", entry=i) for i in sorted(needed.union(range(rates)))}
    if not rates:
        after = _put(graph, graph.results, nodes, 0.0, before)
        return Graph(tuple(nodes.held), tuple(after))
    h = add("h")
    now, total, updates = before, list[int](), list[int]()
    for node, ahead, weight in zip(NODES, AHEAD, WEIGHTS, strict=True):
        made = _put(graph, graph.results[:rates] if total else graph.results, nodes, node, now)
        updates += made[rates:]
        total = [_plus(nodes, weight, *both) for both in zip(made, total, strict=True)] if total else made[:rates]
        if ahead:
            step = add("mul", (constant(ahead), h))
            now = {i: add("fma", (step, made[i], before[i])) for i in range(rates) if i in needed}
    share = add("div", (h, constant(DIVISOR)))
    after = [add("fma", (share, rate, before[i])) for i, rate in enumerate(total)]
    return Graph(tuple(nodes.held), (*after, *updates))


def _plus(nodes: Nodes, weight: float, rate: int, so_far: int) -> int:
    return nodes.add("add", (so_far, rate)) if weight == 1 else nodes.add("fma", (nodes.constant(weight), rate, so_far))


def _put(graph: Graph, results: Sequence[int], nodes: Nodes, node: float, state: Mapping[int, int]) -> list[int]:
    """Where some results are once their graph is among other nodes, at `node` of a step and with this state."""
    new: dict[int, int] = {}
    for place in graph.before(results):
        op, operands, value, entry = graph.nodes[place]
        if op == "t":
            new[place] = _time(nodes, node)
        elif op == "x":
            new[place] = state[entry]
        else:
            new[place] = nodes.add(op, tuple([new[i] for i in operands]), value, entry)
    return [new[place] for place in results]


def _time(nodes: Nodes, node: float) -> int:
    """(k + node) h, the second part added to the first."""
    h = nodes.add("h")
    begin = nodes.add("mul", (nodes.add("k"), h))
    return nodes.add("add", (begin, nodes.add("mul", (nodes.constant(node), h)))) if node else begin
