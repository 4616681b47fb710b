"""Rewriting: the same graph with less work in it.

What is rewritten depends on the graph alone, never on which parameters vary: so no last bit of a run does.
"""

from __future__ import annotations

from workbench.simulate.graph import Graph, Node


def rewritten(graph: Graph) -> Graph:
    """The graph with sums of angles opened and products fused."""
    return fused(opened(graph))


def opened(graph: Graph) -> Graph:
    """The same graph, with sin(a + b) made of the sines and cosines of a and b where these are needed anyway."""
    angles = {node.operands[0] for node in graph.nodes if node.op in ("sin", "cos")}
    nodes: list[Node] = []
    new: dict[int, int] = {}
    made: dict[tuple[str, int], int] = {}

    def add(op: str, *operands: int) -> int:
        nodes.append(Node(op, operands))
        return len(nodes) - 1

    def turned(op: str, angle: int) -> int:
        if (op, angle) not in made:
            node = graph.nodes[angle]
            summed = node.op in ("add", "sub") and angles.issuperset(node.operands)
            made[op, angle] = apart(op, node) if summed else add(op, new[angle])
        return made[op, angle]

    def apart(op: str, node: Node) -> int:
        (sin_a, cos_a), (sin_b, cos_b) = ((turned("sin", i), turned("cos", i)) for i in node.operands)
        if op == "sin":
            return add(node.op, add("mul", sin_a, cos_b), add("mul", cos_a, sin_b))
        return add("sub" if node.op == "add" else "add", add("mul", cos_a, cos_b), add("mul", sin_a, sin_b))

    for place, node in enumerate(graph.nodes):
        if node.op in ("sin", "cos"):
            new[place] = turned(node.op, node.operands[0])
        else:
            nodes.append(node._replace(operands=tuple([new[i] for i in node.operands])) if node.operands else node)
            new[place] = len(nodes) - 1
    whole = Graph(tuple(nodes), tuple(new[place] for place in graph.results))
    return whole.part(whole.before(whole.results), {})


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
