"""Emission: the operations of a machine as lines of LLVM IR, every value a vector of doubles, words or truths."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache

from workbench.engine.kernel.graph import Graph
from workbench.engine.kernel.plan import Evaluation

INTRINSICS = {"sqrt": 1, "fabs": 1, "floor": 1, "trunc": 1, "copysign": 2, "fma": 3}  # of so many operands
INSTRUCTIONS = {
    **{op: f"f{op} DOUBLES {{0}}, {{1}}" for op in ("add", "sub", "mul", "div")},
    **{op: f"fcmp o{op} DOUBLES {{0}}, {{1}}" for op in ("lt", "le", "gt", "ge", "eq")},
    **{f"word_{op}": f"{op} WORDS {{0}}, {{1}}" for op in ("add", "mul", "and", "or", "xor")},
    **{op: f"{op} WORDS {{0}}, {{1}}" for op in ("shl", "lshr")},
    **{op: f"{op} TRUTHS {{0}}, {{1}}" for op in ("and", "or")},
    "ne": "fcmp une DOUBLES {0}, {1}",
    "neg": "fneg DOUBLES {0}",
    "not": "xor TRUTHS {0}, TRUE",
    "nonzero": "icmp ne WORDS {0}, zeroinitializer",
    "select": "select TRUTHS {0}, DOUBLES {1}, DOUBLES {2}",
    "bits": "bitcast DOUBLES {0} to WORDS",
    "number": "bitcast WORDS {0} to DOUBLES",
    "signed": "sitofp WORDS {0} to DOUBLES",
}


class Emission:
    """The machine that writes each operation as a line of LLVM IR."""

    def __init__(
        self, graph: Graph, width: int, fused: bool, prefix: str, load: Callable[[Emission, int], str]
    ) -> None:
        self.width = width
        self.fused = fused
        self.prefix = prefix
        self.type, self.integers, self.flags = (f"<{width} x {kind}>" for kind in ("double", "i64", "i1"))
        self.lines: list[str] = []
        self.evaluation = Evaluation(graph, self, lambda place: load(self, place))

    def __str__(self) -> str:
        return "\n".join(self.lines)

    # the machine

    def do(self, operation: str, *operands: str) -> str:
        """One instruction; its name."""
        return self.line(instructions(self.width)[operation].format(*operands))

    def constant(self, value: float) -> str:
        """A constant in every lane."""
        return f"<{', '.join([f'double {literal(value)}'] * self.width)}>"

    def word(self, value: int) -> str:
        """A whole number in every lane."""
        return f"<{', '.join([f'i64 {value - (value >> 63 << 64)}'] * self.width)}>"

    # its lines

    def line(self, text: str) -> str:
        """One instruction; its name."""
        name = f"%{self.prefix}{len(self.lines)}"
        self.lines.append(f"  {name} = {text}")
        return name

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


@lru_cache
def instructions(width: int) -> Mapping[str, str]:
    """The instruction of each operation for vectors of a width, with places for its operands."""
    doubles = f"<{width} x double>"
    kinds = {"DOUBLES": doubles, "WORDS": f"<{width} x i64>", "TRUTHS": f"<{width} x i1>"}
    kinds["TRUE"] = f"<{', '.join(['i1 true'] * width)}>"
    found = dict(INSTRUCTIONS)
    for name, count in INTRINSICS.items():
        operands = ", ".join(f"DOUBLES {{{i}}}" for i in range(count))
        found[name] = f"call DOUBLES @llvm.{name}.v{width}f64({operands})"
    for kind, text in kinds.items():
        found = {operation: line.replace(kind, text) for operation, line in found.items()}
    return found


def declarations(width: int) -> list[str]:
    """The declarations of the intrinsics."""
    vector = f"<{width} x double>"
    return [
        f"declare {vector} @llvm.{name}.v{width}f64({', '.join([vector] * count)})"
        for name, count in INTRINSICS.items()
    ]


def literal(value: float) -> str:
    """A double as LLVM reads it to the last bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"
