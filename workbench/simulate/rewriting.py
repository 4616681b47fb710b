"""Rewriting: the same graph with less work in it.

What is rewritten depends on the graph alone, never on which parameters vary: so no last bit of a run does.
"""

from __future__ import annotations

from workbench.simulate.graph import Graph, Node, Nodes


def rewritten(graph: Graph) -> Graph:
    """The graph with sums of angles opened and products fused."""
    return fused(opened(graph))


def opened(graph: Graph) -> Graph:
    """The same graph, with sin(a + b) made of the sines and cosines of a and b where these are needed anyway."""
    angles = {node.operands[0] for node in graph.nodes if node.op in ("sin", "cos")}
    nodes, new = Nodes(), dict[int, int]()

    def turned(op: str, angle: int) -> int:
        node = graph.nodes[angle]
        if node.op not in ("add", "sub") or not angles.issuperset(node.operands):
            return nodes.add(op, (new[angle],))
        (sin_a, cos_a), (sin_b, cos_b) = ((turned("sin", i), turned("cos", i)) for i in node.operands)
        if op == "sin":
            return nodes.add(node.op, (nodes.add("mul", (sin_a, cos_b)), nodes.add("mul", (cos_a, sin_b))))
        opposite = "sub" if node.op == "add" else "add"
        return nodes.add(opposite, (nodes.add("mul", (cos_a, cos_b)), nodes.add("mul", (sin_a, sin_b))))

    for place, node in enumerate(graph.nodes):
        if node.op in ("sin", "cos"):
            new[place] = turned(node.op, node.operands[0])
        else:
            new[place] = nodes.add(node.op, tuple(new[i] for i in node.operands), node.value, node.entry)
    return nodes.graph(new[place] for place in graph.results)


def fused(graph: Graph) -> Graph:
    """The same graph, with a product that is used once, in a sum of its own level, rounded together with it.

    Levels do not change with the parameters that vary, so neither does what is fused, nor a last bit.
    """
    gone: set[int] = set()
    changed: dict[int, Node] = {}

    def product(place: int, of: int) -> tuple[int, ...]:
        node = graph.nodes[place]
        alone = len(graph.users[place]) == 1 and place not in results and graph.levels[place] == graph.levels[of]
        return node.operands if node.op == "mul" and alone else ()

    results = set(graph.results)
    for place, node in enumerate(graph.nodes):
        if node.op not in ("add", "sub") or node.operands[0] == node.operands[1]:
            continue
        a, b = node.operands
        if pair := product(b, place):
            gone.add(b)
            changed[place] = Node("fma" if node.op == "add" else "fnma", (*pair, a))
        elif pair := product(a, place):
            gone.add(a)
            changed[place] = Node("fma" if node.op == "add" else "fms", (*pair, b))
    return graph.part([place for place in range(len(graph.nodes)) if place not in gone], changed)
