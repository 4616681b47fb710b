"""Graph: a block of operations, each of them once, with the inputs on which it depends."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple


class Level(enum.IntEnum):
    """The most variable thing that a value depends on: the length of the step, parameters, time, the state of a run."""

    LENGTH = 0
    PARAMETERS = 1
    TIME = 2
    STATE = 3


class Node(NamedTuple):
    """One operation on the values of earlier nodes; `value` is that of a constant, `entry` that of an input."""

    op: str
    operands: tuple[int, ...] = ()
    value: float = 0.0
    entry: int = 0


SOURCES = ("h", "k", "t", "x", "p", "w")
LEVELS = {
    "const": Level.LENGTH,
    "h": Level.LENGTH,
    "p": Level.PARAMETERS,
    "k": Level.TIME,
    "t": Level.TIME,
    "x": Level.STATE,
    "w": Level.STATE,
}
COMMUTATIVE = {"add", "mul", "eq", "ne", "and", "or"}
FOLDED: Mapping[str, Callable[..., float]] = {
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
    """The nodes of x+ = F(h, k, x, p, w) in the order of evaluation, and which of them are the entries of x+."""

    nodes: tuple[Node, ...]
    results: tuple[int, ...]

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """The level of each node; constants that Python cannot fold have the level of the parameters."""
        found: list[Level] = []
        length, parameters = Level.LENGTH, Level.PARAMETERS
        for op, operands, *_ in self.nodes:
            level = LEVELS.get(op, length if op in FOLDED else parameters)
            for i in operands:
                level = max(level, found[i])
            found.append(level)
        return tuple(found)

    def numbers(self, h: float) -> dict[int, float]:
        """The values of the nodes that change with the length of the step alone, for one of h [s]."""
        values: dict[int, float] = {}
        for place in (i for i, level in enumerate(self.levels) if level is Level.LENGTH):
            op, operands, value, _ = self.nodes[place]
            values[place] = FOLDED[op](*(values[i] for i in operands)) if operands else h if op == "h" else value
        return values

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

    def part(self, places: Iterable[int], changed: Mapping[int, Node]) -> Graph:
        """The graph of some of its places in order, with other nodes at some of them."""
        new: dict[int, int] = {}
        nodes: list[Node] = []
        for place in places:
            node = changed.get(place) or self.nodes[place]
            if node.operands:
                node = Node(node.op, tuple([new[i] for i in node.operands]), node.value, node.entry)
            new[place] = len(nodes)
            nodes.append(node)
        return Graph(tuple(nodes), tuple(new[i] for i in self.results))


class Nodes:
    """The nodes of a graph while it is built, each one once, with constants folded."""

    def __init__(self) -> None:
        self.held: list[Node] = []
        self.places: dict[Node, int] = {}

    def __getitem__(self, place: int) -> Node:
        return self.held[place]

    def constant(self, value: float) -> int:
        """A number; minus zero is zero, as the two are one key."""
        return self.add("const", value=float(value) + 0.0)

    def add(self, op: str, operands: tuple[int, ...] = (), value: float = 0.0, entry: int = 0) -> int:
        """The place of an operation on the values at earlier places."""
        if op in FOLDED and self.held[operands[0]].op == "const":
            given = [self.held[i] for i in operands]
            if all(node.op == "const" for node in given):
                return self.constant(FOLDED[op](*[node.value for node in given]))
        if op in COMMUTATIVE and operands[0] > operands[1]:
            operands = operands[::-1]
        node = Node(op, operands, value, entry)
        place = self.places.setdefault(node, len(self.held))
        if place == len(self.held):
            self.held.append(node)
        return place
