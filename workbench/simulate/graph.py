"""Graph: a `Step` as one hash-consed block of operations, each known by what it depends on.

A division becomes a product with a reciprocal, which is shared and moves out of the loop wherever its
operand does. What no result needs is not there.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import or_

import casadi as ca

from workbench.core import Step


class Depends(enum.IntFlag):
    """What a value changes with, besides nothing at all."""

    NOTHING = 0
    UNIFORM = 1  # parameters that are equal in all runs
    VARIED = 2  # parameters that differ from run to run
    TIME = 4
    STATE = 8


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
    ca.OP_IF_ELSE_ZERO: "if_else_zero",
}
COMMUTATIVE = {"add", "mul", "eq", "ne", "and", "or"}
FOLDED: Mapping[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "neg": lambda a: -a,
    "inv": lambda a: 1.0 / a,
    "sqrt": math.sqrt,
}
NAMES = {getattr(ca, name): name.removeprefix("OP_") for name in dir(ca) if name.startswith("OP_")}
SOURCES = ("k", "x", "p", "w")


@dataclass(frozen=True, eq=False)
class Graph:
    """The nodes of x+ = F(k, x, p) in the order of evaluation, and which of them are the entries of x+."""

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
        return _Builder(step).graph()

    def depends(self, varied: Iterable[int]) -> tuple[Depends, ...]:
        """What each node changes with, where the parameters `varied` differ from run to run."""
        varied = set(varied)
        found: list[Depends] = []
        for node in self.nodes:
            if node.op == "p":
                found.append(Depends.VARIED if node.index in varied else Depends.UNIFORM)
            elif node.op in SOURCES:
                found.append(Depends.TIME if node.op == "k" else Depends.STATE)
            else:
                found.append(reduce(or_, (found[i] for i in node.operands), Depends.NOTHING))
        return tuple(found)

    @cached_property
    def users(self) -> tuple[tuple[int, ...], ...]:
        """The nodes that use each node."""
        users: list[list[int]] = [[] for _ in self.nodes]
        for place, node in enumerate(self.nodes):
            for operand in set(node.operands):
                users[operand].append(place)
        return tuple(map(tuple, users))


class _Builder:
    """Collects nodes, each one once."""

    def __init__(self, step: Step) -> None:
        self.step = step
        self.nodes: list[Node] = []
        self.places: dict[Node, int] = {}

    def graph(self) -> Graph:
        """All nodes that a result needs, in order."""
        results = self._read(self.step.F)
        needed: set[int] = set()
        stack = list(results)
        while stack:
            place = stack.pop()
            if place not in needed:
                needed.add(place)
                stack.extend(self.nodes[place].operands)
        order = sorted(needed)
        new = {old: place for place, old in enumerate(order)}
        nodes = tuple(
            Node(n.op, tuple(new[i] for i in n.operands), n.value, n.index) for n in (self.nodes[i] for i in order)
        )
        return Graph(nodes, tuple(new[i] for i in results))

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
            case ca.OP_TAN:
                cosine = self._node("inv", (self._node("cos", operands),))
                return self._node("mul", (self._node("sin", operands), cosine))
        if code not in OPERATIONS:
            known = ", ".join(sorted(OPERATIONS.values()))
            raise ValueError(
                f"The step of '{self.step.flow.name}' has the operation {NAMES.get(code, code)}, which the batch "
                f"engine does not know. It knows {known}, and what is made of them."
            )
        return self._node(OPERATIONS[code], operands)

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
