"""Emission: the nodes of a graph as lines of LLVM IR, every value a vector of doubles."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from workbench.simulate.kernel import functions as f
from workbench.simulate.kernel.graph import Graph, Node
from workbench.simulate.kernel.plan import PLAIN

TRUTHS = {"lt": "olt", "le": "ole", "eq": "oeq", "ne": "une"}
BINARY = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
UNARY = {"sqrt": "sqrt", "fabs": "fabs", "floor": "floor"}
COMPOSED: Mapping[str, Callable[..., str]] = {
    "exp": f.exponential,
    "tanh": f.hyperbolic_tangent,
    "log": f.logarithm,
    "atan2": f.arc_tangent,
    "fmod": f.remainder,
    "fmin": f.smaller,
    "fmax": f.larger,
}


class Emission:
    """Writes one straight line of code, each value once, and loads what it does not make when it is first needed."""

    def __init__(self, graph: Graph, width: int, prefix: str, load: Callable[[Emission, int], str]) -> None:
        self.graph = graph
        self.width = width
        self.prefix = prefix
        self.load = load
        self.type = f"<{width} x double>"
        self.integers = f"<{width} x i64>"
        self.lines: list[str] = []
        self.values: dict[int, str] = {}
        self.truths: dict[int, str] = {}
        self.angles: dict[int, f.Angle] = {}

    # what `functions` needs of a writer

    def line(self, text: str) -> str:
        """One instruction; its name."""
        name = f"%{self.prefix}{len(self.lines)}"
        self.lines.append(f"  {name} = {text}")
        return name

    def vector(self, value: float) -> str:
        """A constant in every lane."""
        return f"<{', '.join([f'double {f.literal(value)}'] * self.width)}>"

    def whole(self, value: int) -> str:
        """A whole number in every lane."""
        return f"<{', '.join([f'i64 {value}'] * self.width)}>"

    # loads

    def lane(self, base: str, place: int) -> str:
        """The vector at a place of an array of vectors."""
        pointer = self.line(f"getelementptr {self.type}, ptr {base}, i64 {place}")
        return self.line(f"load {self.type}, ptr {pointer}")

    def spread(self, base: str, place: int) -> str:
        """The double at a place of an array, in every lane."""
        pointer = self.line(f"getelementptr double, ptr {base}, i64 {place}")
        return self.splat(self.line(f"load double, ptr {pointer}, align 8"))

    def splat(self, number: str, kind: str = "double") -> str:
        """One number in every lane."""
        vector = f"<{self.width} x {kind}>"
        first = self.line(f"insertelement {vector} poison, {kind} {number}, i64 0")
        return self.line(f"shufflevector {vector} {first}, {vector} poison, <{self.width} x i32> zeroinitializer")

    def store(self, base: str, names: Iterable[str]) -> None:
        """The given vectors into an array of vectors."""
        for place, name in enumerate(names):
            pointer = self.line(f"getelementptr {self.type}, ptr {base}, i64 {place}")
            self.lines.append(f"  store {self.type} {name}, ptr {pointer}")

    def __str__(self) -> str:
        return "\n".join(self.lines)

    # nodes

    def emit(self, places: Iterable[int]) -> None:
        """The values of these nodes, whose operands are made before them or loaded."""
        for place in places:
            self._node(place, self.graph.nodes[place])

    def value(self, place: int) -> str:
        """The name of a value, loaded if it was made elsewhere."""
        node = self.graph.nodes[place]
        if node.op == "const" and node.value in PLAIN:
            return self.vector(node.value)
        if place not in self.values:
            truth = self.truths.get(place)
            one, zero = self.vector(1.0), self.vector(0.0)
            self.values[place] = f.select(self, truth, one, zero) if truth else self.load(self, place)
        return self.values[place]

    def _truth(self, place: int) -> str:
        """A value as a vector of truths: what is not zero is true."""
        if place not in self.truths:
            self.truths[place] = f.compare(self, "une", self.value(place), self.vector(0.0))
        return self.truths[place]

    def _node(self, place: int, node: Node) -> None:
        op, operands = node.op, node.operands
        if not operands:
            self.value(place)
        elif op in TRUTHS:
            self.truths[place] = f.compare(self, TRUTHS[op], *map(self.value, operands))
        elif op in ("and", "or", "not"):
            self.truths[place] = self._logic(op, operands)
        elif op in ("sin", "cos"):
            if operands[0] not in self.angles:
                self.angles[operands[0]] = f.reduce_angle(self, self.value(operands[0]))
            self.values[place] = f.sine_or_cosine(self, self.angles[operands[0]], int(op == "cos"))
        elif op == "if_else":
            condition, *branches = operands
            self.values[place] = f.select(self, self._truth(condition), *map(self.value, branches))
        else:
            self.values[place] = self._arithmetic(op, [self.value(i) for i in operands])

    def _logic(self, op: str, operands: tuple[int, ...]) -> str:
        flags = f.flags(self)
        if op == "not":
            ones = f"<{', '.join(['i1 true'] * self.width)}>"
            return self.line(f"xor {flags} {self._truth(operands[0])}, {ones}")
        a, b = map(self._truth, operands)
        return self.line(f"{op} {flags} {a}, {b}")

    def _arithmetic(self, op: str, values: list[str]) -> str:
        if op in BINARY:
            return f.binary(self, BINARY[op], *values)
        if op in UNARY:
            return f.unary(self, UNARY[op], *values)
        if op in COMPOSED:
            return COMPOSED[op](self, *values)
        match op:
            case "fma":
                return f.fma(self, values[0], values[1], values[2])
            case "fnma":  # c - a b
                return f.fma(self, f.negative(self, values[0]), values[1], values[2])
            case "fms":  # a b - c
                return f.fma(self, values[0], values[1], f.negative(self, values[2]))
            case "neg":
                return f.negative(self, values[0])
            case "inv":
                return f.binary(self, "fdiv", self.vector(1.0), values[0])
            case "sign":
                return self._sign(values[0])
        raise ValueError(f"The operation '{op}' has no lowering in the batch engine.")

    def _sign(self, x: str) -> str:
        zero = self.vector(0.0)
        below = f.select(self, f.compare(self, "olt", x, zero), self.vector(-1.0), x)
        return f.select(self, f.compare(self, "ogt", x, zero), self.vector(1.0), below)
