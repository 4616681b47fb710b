"""Barriers: the parts of a graph joined to one, in which nothing is simplified from one part to the next.

Each part is read and rewritten by itself. So the part of a computer has the same operations in its loop and alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from workbench.engine.kernel.graph import Graph, Node, expand_angle_sums, fuse_products, order_nodes

BARRIER = "barrier"  # the operation that gives its operand, and through which no folding of constants sees


def rewrite(graph: Graph) -> Graph:
    """The graph with sums of angles opened and products fused in each part, in an order for few registers."""
    first, *others = (fuse_products(expand_angle_sums(part)) for part in (graph, *graph.earlier))
    return order_nodes(join_parts(replace(first, earlier=tuple(others))))


def join_parts(graph: Graph) -> Graph:
    """The graph with its earlier parts before it, and each value that they hand over behind a barrier."""
    nodes, handed, barriers = list[Node](), list[int](), dict[int, int]()
    results: tuple[int, ...] = ()
    for part in (*graph.earlier, graph):
        new: list[int] = []
        for node in part.nodes:
            new.append(handed[node.entry] if node.op == "v" else len(nodes))
            if node.op != "v":
                nodes.append(_renumber(node, new))
        results = tuple(new[i] for i in part.results)
        for place in results if part is not graph else ():
            if place not in barriers:
                barriers[place] = len(nodes)
                nodes.append(Node(BARRIER, (place,)))
            handed.append(barriers[place])
    return Graph(tuple(nodes), results)


def without_barriers(graph: Graph) -> Graph:
    """The same graph without its barriers, for a reader who changes no bit of what stands on their two sides."""
    nodes, new = list[Node](), list[int]()
    for node in graph.nodes:
        new.append(new[node.operands[0]] if node.op == BARRIER else len(nodes))
        if node.op != BARRIER:
            nodes.append(_renumber(node, new))
    return Graph(tuple(nodes), tuple(new[i] for i in graph.results))


def _renumber(node: Node, new: Sequence[int]) -> Node:
    """The node with its operands at their new places."""
    if not node.operands:
        return node
    return node._replace(operands=tuple([new[i] for i in node.operands]))
