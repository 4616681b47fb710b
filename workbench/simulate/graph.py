"""Graph: a `Step` as one hash-consed block of operations, each known by what it depends on.

A division becomes a product with a reciprocal, which is shared and moves out of the loop wherever its
operand does. A product that is used once, in a sum, becomes one operation with it. What no result
needs is not there.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from workbench.core import Step


class Level(enum.IntEnum):
    """What a value changes with at most: constants and parameters only, time too, or the state of a run."""

    PARAMETERS = 0
    TIME = 1
    STATE = 2


@dataclass(frozen=True)
class Node:
    """One operation on the values of earlier nodes; `value` is that of a constant, `index` that of an input."""

    op: str
    operands: tuple[int, ...] = ()
    value: float = 0.0
    index: int = 0


# Operations of CasADi by their names here; what is missing is built of these, or refused by name.
OPERATIONS: Mapping[int, str] = {
    ca.OP_ADD: "add",
    ca.OP_SUB: "sub",
    ca.OP_MUL: "mul",
    ca.OP_NEG: "neg",
    ca.OP_INV: "inv",
    ca.OP_SQRT: "sqrt",
    ca.OP_SIN: "sin",
    ca.OP_COS: "cos",
    ca.OP_EXP: "exp",
    ca.OP_LOG: "log",
    ca.OP_TANH: "tanh",
    ca.OP_ATAN2: "atan2",
    ca.OP_FABS: "fabs",
    ca.OP_SIGN: "sign",
    ca.OP_FLOOR: "floor",
    ca.OP_FMOD: "fmod",
    ca.OP_FMIN: "fmin",
    ca.OP_FMAX: "fmax",
    ca.OP_LT: "lt",
    ca.OP_LE: "le",
    ca.OP_EQ: "eq",
    ca.OP_NE: "ne",
    ca.OP_AND: "and",
    ca.OP_OR: "or",
    ca.OP_NOT: "not",
}
COMMUTATIVE = {"add", "mul", "eq", "ne", "and", "or"}
UNKNOWN = "unknown "
SOURCES = ("k", "x", "p", "w")
LEVELS = {"k": Level.TIME, "x": Level.STATE, "w": Level.STATE}
FOLDED: Mapping[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "neg": lambda a: -a,
    "inv": lambda a: 1.0 / a,
    "sqrt": math.sqrt,
}
NAMES = {getattr(ca, name): name.removeprefix("OP_") for name in dir(ca) if name.startswith("OP_")}


@dataclass(frozen=True, eq=False)
class Graph:
    """The nodes of x+ = F(k, x, p, w) in the order of evaluation, and which of them are the entries of x+."""

    nodes: tuple[Node, ...]
    results: tuple[int, ...]

    @staticmethod
    def of(step: Step) -> Graph:
        """The graph of a step.

        Raises
        ------
        ValueError
            If the step has an operation that no kernel knows; the message names it and the state it is for.
        """
        return _fused(_Builder(step).graph())

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """What each node changes with at most."""
        found: list[Level] = []
        for node in self.nodes:
            found.append(max((found[i] for i in node.operands), default=LEVELS.get(node.op, Level.PARAMETERS)))
        return tuple(found)

    @cached_property
    def users(self) -> tuple[tuple[int, ...], ...]:
        """The nodes that use each node."""
        users: list[list[int]] = [[] for _ in self.nodes]
        for place, node in enumerate(self.nodes):
            for operand in set(node.operands):
                users[operand].append(place)
        return tuple(map(tuple, users))

    def after(self, op: str, indices: Collection[int]) -> frozenset[int]:
        """The nodes that depend on the sources `op` of the given indices."""
        found: set[int] = set()
        for place, node in enumerate(self.nodes):
            if (node.op == op and node.index in indices) or not found.isdisjoint(node.operands):
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

    def part(self, places: Sequence[int], nodes: Mapping[int, Node]) -> Graph:
        """The graph of some of its places in order, with other nodes at some of them."""
        new = {old: place for place, old in enumerate(places)}
        held = (nodes.get(place, self.nodes[place]) for place in places)
        renamed = tuple(Node(n.op, tuple(new[i] for i in n.operands), n.value, n.index) for n in held)
        return Graph(renamed, tuple(new[i] for i in self.results))


def _fused(graph: Graph) -> Graph:
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


class _Builder:
    """Collects nodes, each one once."""

    def __init__(self, step: Step) -> None:
        self.step = step
        self.nodes: list[Node] = []
        self.places: dict[Node, int] = {}

    def graph(self) -> Graph:
        """All nodes that a result needs, in order."""
        results = tuple(self._read(self.step.F))
        whole = Graph(tuple(self.nodes), results)
        graph = whole.part(whole.before(results), {})
        self._check(graph)
        return graph

    def _read(self, function: ca.Function) -> list[int]:
        registers: dict[int, int] = {}
        results: dict[int, int] = {}
        for line in range(function.n_instructions()):
            code = function.instruction_id(line)
            reads, writes = function.instruction_input(line), function.instruction_output(line)
            if code == ca.OP_OUTPUT:
                results[writes[1]] = registers[reads[0]]
            elif code == ca.OP_INPUT:
                registers[writes[0]] = self._node(SOURCES[reads[0]], index=reads[1])
            elif code == ca.OP_CONST:
                registers[writes[0]] = self.constant(function.instruction_constant(line))
            else:
                registers[writes[0]] = self._operation(code, *(registers[read] for read in reads))
        return [results[i] if i in results else self.constant(0.0) for i in range(self.step.states.size)]

    def constant(self, value: float) -> int:
        """A number; minus zero is zero, as the two are one key."""
        return self._node("const", value=float(value) + 0.0)

    def _operation(self, code: int, *operands: int) -> int:
        """An operation of CasADi in terms of ours."""
        match code:
            case ca.OP_ASSIGN:
                return operands[0]
            case ca.OP_SQ:
                return self._node("mul", (operands[0], operands[0]))
            case ca.OP_TWICE:
                return self._node("add", (operands[0], operands[0]))
            case ca.OP_DIV:
                return self._node("mul", (operands[0], self._node("inv", (operands[1],))))
            case ca.OP_CONSTPOW | ca.OP_POW:
                return self._power(*operands)
            case ca.OP_IF_ELSE_ZERO:
                return self._node("if_else", (*operands, self.constant(0.0)))
            case ca.OP_ADD:
                return self._sum(*operands)
            case ca.OP_TAN:
                cosine = self._node("inv", (self._node("cos", operands),))
                return self._node("mul", (self._node("sin", operands), cosine))
        return self._node(OPERATIONS.get(code, f"{UNKNOWN}{NAMES.get(code, code)}"), operands)

    def _check(self, graph: Graph) -> None:
        """Refuse an operation that no kernel knows, with the first state that needs it."""
        for place, node in enumerate(graph.nodes):
            if node.op.startswith(UNKNOWN):
                needs = [
                    label
                    for label, i in zip(self.step.states.labels, graph.results, strict=True)
                    if place in graph.before([i])
                ]
                known = ", ".join(sorted(OPERATIONS.values()))
                raise ValueError(
                    f"The step of '{self.step.flow.name}' has the operation {node.op.removeprefix(UNKNOWN)}, which "
                    f"the batch engine does not know; '{needs[0]}' needs it. It knows {known}, and what is made of "
                    "them."
                )

    def _sum(self, a: int, b: int) -> int:
        """A sum; of (c ? u : 0) and (not c ? v : 0), as CasADi writes it, (c ? u : v)."""
        first, second = self.nodes[a], self.nodes[b]
        if first.op == second.op == "if_else":
            zero = self.constant(0.0)
            (c, u, rest), (d, v, more) = first.operands, second.operands
            if rest == more == zero and self.nodes[d] == Node("not", (c,)):
                return self._node("if_else", (c, u, v))
            if rest == more == zero and self.nodes[c] == Node("not", (d,)):
                return self._node("if_else", (d, v, u))
        return self._node("add", (a, b))

    def _power(self, base: int, exponent: int) -> int:
        """A whole power as products, any other as exp(b log a)."""
        number = self.nodes[exponent]
        if number.op == "const" and number.value == int(number.value) and 0 < abs(number.value) <= 16:
            size, result, square = int(abs(number.value)), None, base
            while size:
                if size & 1:
                    result = square if result is None else self._node("mul", (result, square))
                size >>= 1
                square = self._node("mul", (square, square)) if size else square
            assert result is not None
            return result if number.value > 0 else self._node("inv", (result,))
        return self._node("exp", (self._node("mul", (exponent, self._node("log", (base,)))),))

    def _node(self, op: str, operands: tuple[int, ...] = (), value: float = 0.0, index: int = 0) -> int:
        values = [self.nodes[i].value for i in operands if self.nodes[i].op == "const"]
        if op in FOLDED and operands and len(values) == len(operands):
            return self.constant(FOLDED[op](*values))
        node = Node(op, tuple(sorted(operands)) if op in COMMUTATIVE else operands, value, index)
        if node not in self.places:
            self.places[node] = len(self.nodes)
            self.nodes.append(node)
        return self.places[node]
