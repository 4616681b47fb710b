"""The lines of Python for a graph, and for the elementary functions that it calls, each of which is traced once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import partial

from workbench.engine.kernel import elementary_functions as f
from workbench.engine.kernel.further_functions import ARGUMENTS, DOUBLE
from workbench.engine.kernel.graph import Graph, Level
from workbench.engine.kernel.target_operations import Number, Truth, Word

WORD = 2**64

# Python raises an error where IEEE 754 has an infinity or NaN, and its floor and trunc are whole numbers without -0.
HELPERS: Mapping[str, str] = {
    "divided": """
    try:
        return x / y
    except ZeroDivisionError:
        return math.copysign(math.inf, x) * math.copysign(1.0, y) if x > 0.0 or x < 0.0 else math.nan""",
    "root": """
    return math.sqrt(x) if x >= 0.0 else math.nan""",
    "floored": """
    return math.copysign(float(math.floor(x)), x) if abs(x) < 2.0**52 else x""",
    "truncated": """
    return math.copysign(float(int(x)), x) if abs(x) < 2.0**52 else x""",
    "bits": """
    return struct.unpack("<Q", struct.pack("<d", x))[0]""",
    "number": """
    return struct.unpack("<d", struct.pack("<Q", x))[0]""",
}
OF_TWO = {"divided"}

TEXTS: Mapping[str, str] = {
    "add": "{} + {}",
    "sub": "{} - {}",
    "mul": "{} * {}",
    "div": "divided({}, {})",
    "neg": "-{}",
    "fabs": "abs({})",
    "sqrt": "root({})",
    "floor": "floored({})",
    "trunc": "truncated({})",
    "copysign": "math.copysign({}, {})",
    "lt": "{} < {}",
    "le": "{} <= {}",
    "gt": "{} > {}",
    "ge": "{} >= {}",
    "eq": "{} == {}",
    "ne": "{} != {}",
    "and": "{} and {}",
    "or": "{} or {}",
    "not": "not {}",
    "nonzero": "{} != 0",
    "word_add": "({} + {}) % 2**64",
    "word_mul": "({} * {}) % 2**64",
    "word_and": "{} & {}",
    "word_or": "{} | {}",
    "word_xor": "{} ^ {}",
    "shl": "({} << {}) % 2**64",
    "lshr": "{} >> {}",
    "select": "{1} if {0} else {2}",
    "bits": "bits({})",
    "number": "number({})",
    "signed": "float(({} + 2**63) % 2**64 - 2**63)",
    # of a graph alone
    "fma": "{} * {} + {}",
    "fms": "{} * {} - {}",
    "fnma": "{2} - {0} * {1}",
    "inv": "divided(1.0, {})",
    "if_else": "{1} if {0} else {2}",
    "barrier": "{}",
}
COMPARISONS = ("lt", "le", "eq", "ne")
TRUTHS = {"not": (0,), "and": (0, 1), "or": (0, 1), "if_else": (0,)}  # the operands that are truths

FUNCTIONS: Mapping[str, tuple[str, Callable[..., Number], Iterable[str]]] = {  # of an operation: name, trace, arguments
    "exp": ("exponential", f.exponential, "x"),
    "tanh": ("hyperbolic_tangent", f.hyperbolic_tangent, "x"),
    "log": ("logarithm", f.logarithm, "x"),
    "atan2": ("arc_tangent", f.arc_tangent, "yx"),
    "fmod": ("remainder", f.remainder, "xy"),
    "fmin": ("smaller", f.smaller, "ab"),
    "fmax": ("larger", f.larger, "ab"),
    "sign": ("sign", f.sign, "x"),
    **{op: (f"real_{op}", trace, ARGUMENTS.get(op, "x")) for op, trace in DOUBLE.functions.items()},
}


def literal(value: float) -> str:
    """A double as Python reads it to the last bit."""
    if math.isfinite(value):
        return repr(float(value)) if math.copysign(1.0, value) > 0 else f"({value!r})"
    return "math.nan" if math.isnan(value) else "math.inf" if value > 0 else "(-math.inf)"


class PythonLines:
    """The machine that writes each operation as a line of Python, of floats, truths and whole numbers below 2^64."""

    fused = False

    def __init__(self) -> None:
        self.lines: list[str] = []

    def do(self, operation: str, *operands: str) -> str:
        """One assignment; its variable."""
        return self.line(TEXTS[operation].format(*operands))

    def constant(self, value: float) -> str:
        """A float."""
        return literal(value)

    def word(self, value: int) -> str:
        """A whole number below 2^64."""
        return str(value % WORD)

    def line(self, text: str) -> str:
        """One assignment; its variable."""
        name = f"v{len(self.lines) + 1}"
        self.lines.append(f"{name} = {text}")
        return name


def traced(name: str, trace: Callable[..., Number], arguments: Iterable[str]) -> list[str]:
    """An elementary function as Python."""
    machine, names = PythonLines(), list(arguments)
    result = trace(*(Number(machine, argument) for argument in names))
    return _function(name, names, machine.lines, result.value)


def _angle() -> list[str]:
    machine = PythonLines()
    angle = f.reduce_angle(Number(machine, "x"))
    parts = (angle.quadrant.value, angle.odd.value, angle.sine.value, angle.cosine.value)
    return _function("reduced", ["x"], machine.lines, ", ".join(parts))


def _turned(name: str, quarter: int) -> list[str]:
    machine = PythonLines()
    word, odd = Word(machine, "quadrant"), Truth(machine, "odd")
    angle = f.Angle(word, odd, Number(machine, "sine_part"), Number(machine, "cosine_part"))
    result = f.sine_or_cosine(angle, quarter)
    return _function(name, ["quadrant", "odd", "sine_part", "cosine_part"], machine.lines, result.value)


def _function(name: str, arguments: Iterable[str], lines: Iterable[str], result: str) -> list[str]:
    return [f"def {name}({', '.join(arguments)}):", *(f"    {line}" for line in lines), f"    return {result}"]


TRACED: Mapping[str, Callable[[], list[str]]] = {
    "reduced": _angle,
    "sine": lambda: _turned("sine", 0),
    "cosine": lambda: _turned("cosine", 1),
    **{name: partial(traced, name, trace, arguments) for name, trace, arguments in FUNCTIONS.values()},
}


def definitions(lines: Iterable[str]) -> list[str]:
    """The functions that some lines call, and those that these call, each before its first use."""
    text = "\n".join(lines)
    functions = ["\n".join(make()) for name, make in TRACED.items() if f"{name}(" in text]
    text = "\n".join([text, *functions])
    helpers = [
        f"def {name}({'x, y' if name in OF_TWO else 'x'}):{body}"
        for name, body in HELPERS.items()
        if f"{name}(" in text
    ]
    return [line for each in (*helpers, *functions) for line in (*each.splitlines(), "", "")]


def lines_of(graph: Graph, h: float, source: Callable[[str, int], str]) -> tuple[list[str], list[str]]:
    """The assignments that make the values of a graph for steps of h [s], and the texts of its results.

    `source` has the variable of an entry of k, x or p.
    """
    writer = _Graph(graph, h, source)
    for place in range(len(graph.nodes)):
        writer.write(place)
    return writer.machine.lines, [writer.number_of(place) for place in graph.results]


class _Graph:
    def __init__(self, graph: Graph, h: float, source: Callable[[str, int], str]) -> None:
        self.graph, self.source = graph, source
        self.machine = PythonLines()
        self.constants = graph.numbers(h)
        self.numbers: dict[int, str] = {}
        self.truths: dict[int, str] = {}
        self.angles: dict[int, str] = {}

    def number_of(self, place: int) -> str:
        if place not in self.numbers:
            self.numbers[place] = self.machine.do("select", self.truths[place], "1.0", "0.0")
        return self.numbers[place]

    def truth_of(self, place: int) -> str:
        if place not in self.truths:
            self.truths[place] = self.machine.do("ne", self.numbers[place], "0.0")
        return self.truths[place]

    def write(self, place: int) -> None:
        node = self.graph.nodes[place]
        if self.graph.levels[place] is Level.LENGTH:
            self.numbers[place] = literal(self.constants[place])
        elif not node.operands:
            self.numbers[place] = self.source(node.op, node.entry)
        elif node.op in ("sin", "cos"):
            self.numbers[place] = self._turn(node.op, node.operands[0])
        elif node.op in FUNCTIONS:
            arguments = ", ".join(map(self.number_of, node.operands))
            self.numbers[place] = self.machine.line(f"{FUNCTIONS[node.op][0]}({arguments})")
        else:
            wants = TRUTHS.get(node.op, ())
            pairs = enumerate(node.operands)
            operands = [self.truth_of(each) if i in wants else self.number_of(each) for i, each in pairs]
            kind = self.truths if node.op in (*COMPARISONS, "not", "and", "or") else self.numbers
            kind[place] = self.machine.do(node.op, *operands)

    def _turn(self, op: str, angle: int) -> str:
        if angle not in self.angles:
            self.angles[angle] = self.machine.line(f"reduced({self.number_of(angle)})")
        return self.machine.line(f"{'sine' if op == 'sin' else 'cosine'}(*{self.angles[angle]})")
