"""Reading: the operations of a rule, as CasADi holds them, as the nodes of a graph.

A division becomes a product with a reciprocal, which is shared and moves out of the loop wherever its
operand does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial

import casadi as ca

from workbench.core import StepMap, StepRule
from workbench.core.bounded_loop import LoopBody, called_loop
from workbench.core.expressions import evaluate_sx
from workbench.core.notation.program import NAMES
from workbench.engine.kernel.graph import CONSTANT_FOLDS, LEVELS, SOURCES, Graph, Level, Node, Nodes
from workbench.engine.kernel.graph_rewriting import BARRIER, join_parts
from workbench.engine.kernel.loop_reading import ReadLoop, add_loop, body_source, read_loop
from workbench.engine.machines.operations import Role, with_role

# Operations of CasADi by their names here; what is missing is built of these, or refused by name.
COMPOSITE_OPERATIONS = (
    "div",
    "fma",
    "fms",
    "fnma",
    "if_else",
    BARRIER,
)  # operations of a graph for which CasADi has another form
OPERATIONS: Mapping[int, str] = {
    getattr(ca, f"OP_{name.upper()}"): name for name in with_role(Role.NODE) if name not in COMPOSITE_OPERATIONS
}
UNKNOWN_PREFIX = "unknown "


def read(step: StepMap) -> Graph:
    """The graph of a step's rates and updates; a ValueError names an operation that no kernel knows, and its state."""
    graph = _graph(step.rule)
    if (unknown := _unknown_operation(graph)) is not None:
        operation, state = unknown
        raise ValueError(
            f"The step of '{step.flow.name}' has the operation {operation}, which the batch engine does not know; "
            f"'{step.states.labels[state]}' needs it. It knows {', '.join(sorted(OPERATIONS.values()))}, and what is "
            "made of them."
        )
    return graph


@lru_cache(maxsize=128)
def _graph(rule: StepRule) -> Graph:
    earlier = []
    for crossing in rule.crossings:
        reader = _Reader(_source)
        results = reader.read(_function(rule, crossing.values))
        earlier.append(Graph(tuple(reader.nodes.nodes), tuple(results)))
    reader = _Reader(_source)
    results = reader.read(_function(rule, rule.rate, rule.update))
    return Graph(tuple(reader.nodes.nodes), tuple(results), tuple(earlier))


def _function(rule: StepRule, *values: ca.SX) -> ca.Function:
    """Values as a function of the symbols of a rule; each part of a graph is read from one of its own."""
    return ca.Function("workbench_part", rule.symbols, [ca.densify(value) for value in values])


def read_segments(step: StepMap) -> Graph | None:
    """The graph of the parts of a step's segments; None where no switch is known."""
    return _segments(step.rule)


@lru_cache(maxsize=128)
def _segments(rule: StepRule) -> Graph | None:
    if rule.segment_parts is None:
        return None
    reader = _Reader(_source)
    results = tuple(reader.read(rule.segment_parts))
    return Graph(tuple(reader.nodes.nodes), results, _graph(rule).earlier)


@lru_cache(maxsize=128)
def _unknown_operation(graph: Graph) -> tuple[str, int] | None:
    """The first operation that no kernel has, and the first result that needs it."""
    graph = join_parts(graph)
    for place in (i for i, node in enumerate(graph.nodes) if node.op.startswith(UNKNOWN_PREFIX)):
        for i, result in enumerate(graph.results):
            if place in graph.before([result]):
                return graph.nodes[place].op.removeprefix(UNKNOWN_PREFIX), i
    return None


def read_with(step: StepMap, values: Sequence[ca.SX]) -> tuple[Graph, list[int | None]]:
    """The graph of a step, as `read` has it, whose last results are those of the values (1, 1) that it makes anyway.

    Beside it, for each value its place among the results, or None where the step has no use of it.
    """
    reader, rule, earlier = _Reader(_source), step.rule, read(step).earlier
    results = reader.read(_function(rule, rule.rate, rule.update))
    found = reader.read(_function(rule, ca.vertcat(ca.SX(0, 1), *values)))
    both = join_parts(Graph(tuple(reader.nodes.nodes), (*results, *found), earlier))
    needed = set(both.before(both.results[: len(results)]))
    ends = dict(zip(found, both.results[len(results) :], strict=True))
    inner = {place: both.nodes[i].operands[0] if both.nodes[i].op == BARRIER else i for place, i in ends.items()}
    kept = [place for place, i in inner.items() if i in needed]
    places = {place: len(results) + i for i, place in enumerate(kept)}
    nodes = tuple(reader.nodes.nodes)
    return Graph(nodes, (*results, *kept), earlier), [places.get(place) for place in found]


def _source(nodes: Nodes, part: int, entry: int) -> int:
    """The place of an entry of a step's symbols."""
    return nodes.add(SOURCES[part], entry=entry)


class _Reader:
    """The nodes of a function while it is read; `source` adds that of an entry of an argument."""

    def __init__(self, source: Callable[[Nodes, int, int], int]) -> None:
        self.nodes, self.source = Nodes(), source
        self.loops: dict[str, ReadLoop] = {}  # by the names of their functions, which are digests of their bodies
        self.quotients: dict[int, tuple[int, ...]] = {}  # what a product with a reciprocal was a quotient of

    def read(self, function: ca.Function) -> list[int]:
        """The places of the results of the function."""
        results = evaluate_sx(
            function, partial(self.source, self.nodes), self.nodes.constant, self._operation, self._call
        )
        zero = self.nodes.constant(0.0)
        return [part.get(i, zero) for k, part in enumerate(results) for i in range(function.size1_out(k))]

    def _call(self, function: ca.Function, operands: Sequence[int]) -> Sequence[int]:
        """The places of the results of a bounded loop; any other call is an operation that no kernel knows."""
        loop = called_loop(function)
        if loop is None:
            return [self._operation(ca.OP_CALL, *operands)] * function.nnz_out()
        return add_loop(self.nodes, self._loop(loop), operands)

    def _loop(self, loop: LoopBody) -> ReadLoop:
        """A loop as this graph holds it: one object by its name, so that equal loops on equal values are one node."""
        if loop.name not in self.loops:
            reader = _Reader(partial(body_source, loop))
            self.loops[loop.name] = read_loop(loop, reader.nodes, reader.read(loop.function))
        return self.loops[loop.name]

    def _operation(self, code: int, *operands: int) -> int:
        match code:
            case ca.OP_ASSIGN:
                return operands[0]
            case ca.OP_SQ:
                return self.nodes.add("mul", (operands[0], operands[0]))
            case ca.OP_TWICE:
                return self.nodes.add("add", (operands[0], operands[0]))
            case ca.OP_DIV:
                if all(map(self._is_number, operands)):
                    return self.nodes.add("div", operands)
                product = self.nodes.add("mul", (operands[0], self.nodes.add("inv", (operands[1],))))
                self.quotients[product] = operands
                return product
            case ca.OP_CONSTPOW | ca.OP_POW:
                return self._power(*operands)
            case ca.OP_IF_ELSE_ZERO:
                return self.nodes.add("if_else", (*operands, self.nodes.constant(0.0)))
            case ca.OP_ADD:
                return self._sum(*operands)
            case ca.OP_FLOOR:
                return self.nodes.add("floor", (self._whole(*operands),))
            case ca.OP_CEIL:
                down = self.nodes.add("neg", (self._whole(*operands),))
                return self.nodes.add("neg", (self.nodes.add("floor", (down,)),))
            case ca.OP_ATAN:
                return self.nodes.add("atan2", (*operands, self.nodes.constant(1.0)))
            case ca.OP_ASIN:
                return self.nodes.add("atan2", (*operands, self._other_side(*operands)))
            case ca.OP_ACOS:
                return self.nodes.add("atan2", (self._other_side(*operands), *operands))
            case ca.OP_TAN:
                cosine = self.nodes.add("inv", (self.nodes.add("cos", operands),))
                return self.nodes.add("mul", (self.nodes.add("sin", operands), cosine))
        return self.nodes.add(OPERATIONS.get(code, f"{UNKNOWN_PREFIX}{NAMES.get(code, code)}"), operands)

    def _is_number(self, place: int) -> bool:
        """True if a value changes with the length of the step alone, and is so computed once for all."""
        op, operands, *_ = self.nodes[place]
        return LEVELS.get(op) is Level.LENGTH or (op in CONSTANT_FOLDS and all(map(self._is_number, operands)))

    def _sum(self, a: int, b: int) -> int:
        """A sum; of (c ? u : 0) and (not c ? v : 0), as CasADi writes it, (c ? u : v)."""
        first, second = self.nodes[a], self.nodes[b]
        if first.op == second.op == "if_else":
            zero = self.nodes.constant(0.0)
            (c, u, rest), (d, v, more) = first.operands, second.operands
            if rest == more == zero and self.nodes[d] == Node("not", (c,)):
                return self.nodes.add("if_else", (c, u, v))
            if rest == more == zero and self.nodes[c] == Node("not", (d,)):
                return self.nodes.add("if_else", (d, v, u))
        return self.nodes.add("add", (a, b))

    def _other_side(self, side: int) -> int:
        """sqrt((1 - x) (1 + x)): the other side at the right angle of a triangle with the hypotenuse 1; NaN beyond."""
        one = self.nodes.constant(1.0)
        square = self.nodes.add("mul", (self.nodes.add("sub", (one, side)), self.nodes.add("add", (one, side))))
        return self.nodes.add("sqrt", (square,))

    def _whole(self, place: int) -> int:
        """x / y or x / y + c from a quotient that is rounded once, so that a whole one stays whole."""
        node = self.nodes[place]
        if node.op in ("add", "sub"):
            place = self.nodes.add(node.op, tuple(map(self._quotient, node.operands)))
        return self._quotient(place)

    def _quotient(self, place: int) -> int:
        """A product with a reciprocal as the division it was; any other value as it is."""
        return self.nodes.add("div", self.quotients[place]) if place in self.quotients else place

    def _power(self, base: int, exponent: int) -> int:
        """A small whole power as products, any other as exp(b log |a|) with the sign that a whole b gives."""
        number, add, constant = self.nodes[exponent], self.nodes.add, self.nodes.constant
        known = number.op == "const" and math.isfinite(number.value)
        if known and number.value == int(number.value) and 0 < abs(number.value) <= 16:
            size, result, square = int(abs(number.value)), None, base
            while size:
                if size & 1:
                    result = square if result is None else add("mul", (result, square))
                size >>= 1
                square = add("mul", (square, square)) if size else square
            assert result is not None
            return result if number.value > 0 else add("inv", (result,))
        zero, one, half = constant(0.0), constant(1.0), constant(0.5)
        size = add("exp", (add("mul", (exponent, add("log", (add("fabs", (base,)),)))),))
        whole = add("eq", (add("floor", (exponent,)), exponent))
        halved = add("mul", (exponent, half))
        even = add("eq", (add("floor", (halved,)), halved))
        signed = add("if_else", (even, size, add("neg", (size,))))
        below = add("if_else", (whole, signed, add("log", (base,))))  # of a negative number: there is none
        result = add("if_else", (add("lt", (base, zero)), below, size))
        return add("if_else", (add("eq", (exponent, zero)), one, result))
