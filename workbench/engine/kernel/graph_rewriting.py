"""Barriers: the parts of a graph joined to one, in which nothing is simplified from one part to the next.

The rewriting depends on the graph alone and not on which parameters vary, so neither do the bits of a run. Each part is
read and rewritten by itself. So the part of a computer has the same operations in its loop and alone.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

from workbench.engine.kernel.graph import Graph, Level, Node

BARRIER = "barrier"  # the operation that gives its operand, and through which no folding of constants sees

DEEPEST = 32  # sums of sums of angles that are opened: each adds its rounding


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


def expand_angle_sums(graph: Graph) -> Graph:
    """The same graph, with sin(a + b) made of the sines and cosines of a and b where these are needed anyway."""
    angles = {node.operands[0] for node in graph.nodes if node.op in ("sin", "cos")}
    depth = dict.fromkeys(angles, 0)
    for angle in sorted(angles):
        depth[angle] = 1 + max([depth.get(i, 0) for i in graph.nodes[angle].operands], default=0)
    nodes: list[Node] = []
    new: dict[int, int] = {}
    made: dict[tuple[str, int], int] = {}

    def add(op: str, *operands: int) -> int:
        nodes.append(Node(op, operands))
        return len(nodes) - 1

    def sine_or_cosine(op: str, angle: int) -> int:
        if (op, angle) not in made:
            node = graph.nodes[angle]
            summed = node.op in ("add", "sub") and angles.issuperset(node.operands) and depth[angle] <= DEEPEST
            made[op, angle] = apart(op, node) if summed else add(op, new[angle])
        return made[op, angle]

    def apart(op: str, node: Node) -> int:
        (sin_a, cos_a), (sin_b, cos_b) = ((sine_or_cosine("sin", i), sine_or_cosine("cos", i)) for i in node.operands)
        if op == "sin":
            return add(node.op, add("mul", sin_a, cos_b), add("mul", cos_a, sin_b))
        return add("sub" if node.op == "add" else "add", add("mul", cos_a, cos_b), add("mul", sin_a, sin_b))

    for place, node in enumerate(graph.nodes):
        if node.op in ("sin", "cos"):
            new[place] = sine_or_cosine(node.op, node.operands[0])
        else:
            new[place] = len(nodes)
            operands = tuple([new[i] for i in node.operands])
            nodes.append(node._replace(operands=operands) if operands else node)
    return Graph(tuple(nodes), tuple(new[place] for place in graph.results))


def fuse_products(graph: Graph) -> Graph:
    """The same graph without unused nodes, and with each product rounded together with the sum it is for.

    The product must have no other use, and change with no less than the sum: else it would be made more often.
    """
    needed, nodes, levels = graph.before(graph.results), graph.nodes, graph.levels
    uses = Counter(chain.from_iterable(set(nodes[place].operands) for place in needed))
    uses.update(graph.results)
    gone: set[int] = set()
    changed: dict[int, Node] = {}

    def product(place: int, of: int) -> tuple[int, ...]:
        alone = nodes[place].op == "mul" and uses[place] == 1 and levels[place] == levels[of] > Level.LENGTH
        return nodes[place].operands if alone else ()

    for place in needed:
        op, operands = nodes[place].op, nodes[place].operands
        if op not in ("add", "sub") or operands[0] == operands[1]:
            continue
        a, b = operands
        if pair := product(b, place):
            gone.add(b)
            changed[place] = Node("fma" if op == "add" else "fnma", (*pair, a))
        elif pair := product(a, place):
            gone.add(a)
            changed[place] = Node("fma" if op == "add" else "fms", (*pair, b))
    return graph.part((place for place in needed if place not in gone), changed)


def order_nodes(graph: Graph) -> Graph:
    """The same graph in an order with few values alive at once: deepest operand first, shallowest result first."""
    height: list[int] = []
    for node in graph.nodes:
        height.append(1 + max([height[i] for i in node.operands], default=0))
    order: dict[int, None] = {}
    stack = sorted(set(graph.results), key=lambda place: -height[place])
    while stack:
        place = stack[-1]
        waiting = [i for i in graph.nodes[place].operands if i not in order]
        if place in order or not waiting:
            order.setdefault(stack.pop())
        else:
            stack += sorted(waiting, key=lambda i: height[i])
    return graph.part(order, {})
