"""Graph: a block of operations, each of them once; and the same with less work in it.

The rewriting depends on the graph alone and not on which parameters vary, so neither do the bits of a run.
"""

from __future__ import annotations

import enum
import math
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import NamedTuple

from workbench.engine.kernel.loop_node import ARRAYS, LOOP_SOURCES, GraphLoop
from workbench.engine.machines.operations import OPERATIONS

DEEPEST = 32  # sums of sums of angles that are opened: each adds its rounding


class Level(enum.IntEnum):
    """The most variable thing that a value depends on: the length of the step, parameters, time, the state of a run."""

    LENGTH = 0
    PARAMETERS = 1
    TIME = 2
    STATE = 3


class Node(NamedTuple):
    """One operation on the values of earlier nodes; `value` is that of a constant, `entry` that of an input.

    The nodes of loops and arrays are described in `loop_node`; the value of an array is its length.
    """

    op: str
    operands: tuple[int, ...] = ()
    value: float = 0.0
    entry: int = 0
    loop: GraphLoop | None = None


# v is what an earlier part hands over, d the recorded numbers of a step, m the middle of a step or segment, s the
# offset at which a segment begins, z the state there, and e the state at the end of the step without its segments.
SOURCES = ("h", "k", "t", "x", "p", "w", "v", "m", "d", "s", "e")
LEVELS = {
    "const": Level.LENGTH,
    "h": Level.LENGTH,
    "p": Level.PARAMETERS,
    "k": Level.TIME,
    "t": Level.TIME,
    "m": Level.TIME,
    "s": Level.STATE,
    "z": Level.STATE,
    "e": Level.STATE,
    "x": Level.STATE,
    "w": Level.STATE,
    "v": Level.STATE,
    "d": Level.STATE,
    **dict.fromkeys((*ARRAYS, *LOOP_SOURCES, "loop", "item"), Level.STATE),
}
COMMUTATIVE = {name for name, row in OPERATIONS.items() if row.symmetric}
CONSTANT_FOLDS: Mapping[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b if b else a * math.inf,
    "neg": lambda a: -a,
    "inv": lambda a: 1.0 / a if a else math.inf,
    "sqrt": lambda a: math.sqrt(a) if a >= 0 else math.nan,
    "floor": lambda a: float(math.floor(a)) if math.isfinite(a) else a,
}


@dataclass(frozen=True, eq=False)
class Graph:
    """The nodes of x+ = F(h, k, x, p, w) in the order of evaluation, and which of them are the entries of x+.

    The results of the parts `earlier` are the sources v, in their order; see `barriers`.
    """

    nodes: tuple[Node, ...]
    results: tuple[int, ...]
    earlier: tuple[Graph, ...] = ()

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """The level of each node; constants that Python cannot fold have the level of the parameters."""
        found: list[Level] = []
        length, parameters = Level.LENGTH, Level.PARAMETERS
        for op, operands, *_ in self.nodes:
            level = LEVELS.get(op, length if op in CONSTANT_FOLDS else parameters)
            for i in operands:
                level = max(level, found[i])
            found.append(level)
        return tuple(found)

    def numbers(self, h: float) -> dict[int, float]:
        """The values of the nodes that change with the length of the step alone, for one of h [s]."""
        values: dict[int, float] = {}
        for place in (i for i, level in enumerate(self.levels) if level is Level.LENGTH):
            op, operands, value, *_ = self.nodes[place]
            values[place] = (
                CONSTANT_FOLDS[op](*(values[i] for i in operands)) if operands else h if op == "h" else value
            )
        return values

    @cached_property
    def of_segments(self) -> frozenset[int]:
        """The nodes that depend on where a segment begins, and in which state."""
        found: set[int] = set()
        for place, node in enumerate(self.nodes):
            if node.op in ("s", "z") or not found.isdisjoint(node.operands):
                found.add(place)
        return frozenset(found)

    def after(self, op: str, indices: Collection[int]) -> frozenset[int]:
        """The nodes that depend on the sources `op` of the given indices."""
        found: set[int] = set()
        for place, node in enumerate(self.nodes):
            if (node.op == op and node.entry in indices) or not found.isdisjoint(node.operands):
                found.add(place)
        return frozenset(found)

    def before(self, places: Iterable[int]) -> list[int]:
        """The given nodes and all that they need, in the order of evaluation."""
        needed: set[int] = set()
        stack = list(places)
        while stack:
            place = stack.pop()
            if place not in needed:
                needed.add(place)
                stack.extend(self.nodes[place].operands)
        return sorted(needed)

    def part(self, places: Iterable[int], replacements: Mapping[int, Node]) -> Graph:
        """The graph of some of its places in order, with other nodes at some of them."""
        new: dict[int, int] = {}
        nodes: list[Node] = []
        for place in places:
            node = replacements.get(place) or self.nodes[place]
            if node.operands:
                node = node._replace(operands=tuple([new[i] for i in node.operands]))
            new[place] = len(nodes)
            nodes.append(node)
        return Graph(tuple(nodes), tuple(new[i] for i in self.results))


class Nodes:
    """The nodes of a graph while it is built, each one once, with constants folded."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self.places: dict[Node, int] = {}

    def __getitem__(self, place: int) -> Node:
        return self.nodes[place]

    def constant(self, value: float) -> int:
        """A number; minus zero is zero, as the two are one key."""
        return self.add("const", value=float(value) + 0.0)

    def add(
        self, op: str, operands: tuple[int, ...] = (), value: float = 0.0, entry: int = 0, loop: GraphLoop | None = None
    ) -> int:
        """The place of an operation on the values at earlier places."""
        if op in CONSTANT_FOLDS and self.nodes[operands[0]].op == "const":
            given = [self.nodes[i] for i in operands]
            if all(node.op == "const" for node in given):
                return self.constant(CONSTANT_FOLDS[op](*[node.value for node in given]))
        if op in COMMUTATIVE and operands[0] > operands[1]:
            operands = operands[::-1]
        node = Node(op, operands, value, entry, loop)
        place = self.places.setdefault(node, len(self.nodes))
        if place == len(self.nodes):
            self.nodes.append(node)
        return place


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
