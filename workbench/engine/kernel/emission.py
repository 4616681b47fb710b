"""Emission: the operations of a machine as lines of LLVM IR, every value a vector of doubles, words or truths."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable

from workbench.engine.kernel.graph import Graph
from workbench.engine.kernel.loop_emission import AbstractLoopEmission, Room
from workbench.engine.kernel.plan import Evaluation
from workbench.engine.machines.llvm_spelling import instructions, literal

NO_ROOM = Room("", 0)  # of lines that have no loops


class Emission(AbstractLoopEmission):
    """The machine that writes each operation as a line of LLVM IR, from a block of some label on.

    The arrays of its loops are in a `room`.
    """

    def __init__(
        self,
        graph: Graph,
        width: int,
        fused_products: bool,
        prefix: str,
        load: Callable[[Emission, int], str],
        block: str = "",
        room: Room = NO_ROOM,
    ) -> None:
        self.block, self.room, self.labels = block, room, itertools.count(1)
        self.registers: dict[str, list[str]] = {}
        self.homes: dict[str, tuple[str, int]] = {}
        self.width = width
        self.fused_products = fused_products
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

    def broadcast(self, base: str, place: int) -> str:
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
