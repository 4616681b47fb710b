"""Evaluation: the nodes of a graph on a machine, each of them once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from workbench.simulate.kernel import elementary_functions as f
from workbench.simulate.kernel.graph import Graph, Node
from workbench.simulate.kernel.machine import Machine, Number, Truth, Value, fma, select
from workbench.simulate.kernel.plan import PLAIN

COMPARISONS = {"lt", "le", "eq", "ne"}
FUNCTIONS: Mapping[str, Callable[..., Number]] = {
    **{op: lambda a, *others, op=op: a.do(op, *others) for op in ("add", "sub", "mul", "div", "sqrt", "fabs", "floor")},
    "fma": fma,
    "fnma": lambda a, b, c: fma(-a, b, c) if a.machine.fused else c - a * b,
    "fms": lambda a, b, c: fma(a, b, -c) if a.machine.fused else a * b - c,
    "neg": lambda a: -a,
    "inv": lambda a: 1.0 / a,
    "exp": f.exponential,
    "tanh": f.hyperbolic_tangent,
    "log": f.logarithm,
    "atan2": f.arc_tangent,
    "fmod": f.remainder,
    "fmin": f.smaller,
    "fmax": f.larger,
    "sign": f.sign,
}


class Evaluation:
    """The evaluation of nodes in their order; a value that is not made here is loaded when it is first needed."""

    def __init__(self, graph: Graph, machine: Machine, load: Callable[[int], Value]) -> None:
        self.graph = graph
        self.machine = machine
        self.load = load
        self.numbers: dict[int, Number] = {}
        self.truths: dict[int, Truth] = {}
        self.angles: dict[int, f.Angle] = {}

    def make(self, places: Iterable[int]) -> None:
        """The values of these nodes, whose operands are made before them or loaded."""
        for place in places:
            self._make(place, self.graph.nodes[place])

    def value(self, place: int) -> Value:
        """The machine's own object for a value."""
        return self.number(place).value

    def number(self, place: int) -> Number:
        """A value as a number: 1 or 0 for a truth."""
        node = self.graph.nodes[place]
        if node.op == "const" and node.value in PLAIN:
            return Number(self.machine, self.machine.constant(node.value))
        if place not in self.numbers:
            truth = self.truths.get(place)
            made = select(truth, 1.0, 0.0) if truth else Number(self.machine, self.load(place))
            self.numbers[place] = made
        return self.numbers[place]

    def truth(self, place: int) -> Truth:
        """A value as a truth: nonzero is true."""
        if place not in self.truths:
            self.truths[place] = self.number(place).compare("ne", 0.0)
        return self.truths[place]

    def _make(self, place: int, node: Node) -> None:
        op, operands = node.op, node.operands
        if not operands:
            self.number(place)
        elif op in COMPARISONS:
            a, b = map(self.number, operands)
            self.truths[place] = a.compare(op, b)
        elif op == "not":
            self.truths[place] = ~self.truth(operands[0])
        elif op in ("and", "or"):
            left, right = map(self.truth, operands)
            self.truths[place] = left & right if op == "and" else left | right
        elif op in ("sin", "cos"):
            if operands[0] not in self.angles:
                self.angles[operands[0]] = f.reduce_angle(self.number(operands[0]))
            self.numbers[place] = f.sine_or_cosine(self.angles[operands[0]], int(op == "cos"))
        elif op == "if_else":
            condition, *branches = operands
            self.numbers[place] = select(self.truth(condition), *map(self.number, branches))
        else:
            self.numbers[place] = FUNCTIONS[op](*map(self.number, operands))
