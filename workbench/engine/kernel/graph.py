"""Graph: a block of operations, each of them once, with its loops."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import NamedTuple, TypeVar

from workbench.engine.machines.operations import OPERATIONS


class Level(enum.IntEnum):
    """The most variable thing that a value depends on: the length of the step, parameters, time, the state of a run."""

    LENGTH = 0
    PARAMETERS = 1
    TIME = 2
    STATE = 3


class Node(NamedTuple):
    """One operation on the values of earlier nodes; `value` is that of a constant, `entry` that of an input.

    The nodes of loops and arrays are described in `GraphLoop`; the value of an array is its length.
    """

    op: str
    operands: tuple[int, ...] = ()
    value: float = 0.0
    entry: int = 0
    loop: GraphLoop | None = None


# Operations that give an array, and the sources of the body of a loop: see `GraphLoop`.
ARRAYS = ("array", "slice", "loop_end", "loop_rows")
LOOP_SOURCES = ("carried", "row", "shared")
Result = TypeVar("Result")
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


@dataclass(frozen=True, eq=False)
class GraphLoop:
    """A body that is passed `count` times; see `core.bounded_loop` for its values.

    The operands of its node are the parts of the first carried values, `entry` many; then an array for each of `rows`;
    then the shared values. Of the body, "carried" and "row" (of the array `entry`) are arrays, and "shared" is the
    value of the operand `entry` behind the rows, an array where the node has a length. The results of the body are the
    parts of the next carried values, and of each row that it makes: `parts` has their numbers. A part is a number or an
    array.

    `loop_end` is the array of the carried values at the end, and `loop_rows` that of all rows `entry` that were made.
    `array` puts parts together, `slice` is a part of an array from `entry` on, and `item` is its number at `entry`.
    """

    count: int
    backward: bool
    carry_size: int
    row_sizes: tuple[int, ...]
    result_sizes: tuple[int, ...]
    body: Graph
    parts: tuple[int, ...]

    def split(self, results: Sequence[Result]) -> list[Sequence[Result]]:
        """The parts that belong to the results of the body, by the carried values and each row that it makes."""
        ends = list(accumulate(self.parts))
        return [results[end - size : end] for end, size in zip(ends, self.parts, strict=True)]

    @property
    def carries_items(self) -> bool:
        """True if the body reads the carried values one by one, and nowhere as an array."""
        return not any(
            self.body.nodes[i].op == "carried" and node.op != "item" for node in self.body.nodes for i in node.operands
        )


def length(node: Node) -> int:
    """The number of entries of an array; 0 of a number."""
    return int(node.value) if node.op in ARRAYS or node.op in LOOP_SOURCES else 0


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
