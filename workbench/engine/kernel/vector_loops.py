"""Loops over arrays of vectors, written once for two machines: lines of LLVM IR, or NumPy at once.

A program for them takes a machine and arrays. In IR a value is the name of a vector and an array a pointer; in NumPy
a value is an array of lanes and an array has one more axis in front. Both do the same operations in the same order.

References
----------
Dekker (1971), A floating-point technique for extending the available precision, Numer. Math. 18 (exact products).
Knuth (1997), The Art of Computer Programming 2, section 4.2.2 (exact sums).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from workbench.engine.machines.elementary_functions import halves
from workbench.engine.machines.llvm_spelling import declarations, instructions, literal
from workbench.engine.machines.numpy_spelling import SPELLING, Lanes

# A vector of doubles, an array of them, and a whole number: names or texts in IR, else of NumPy and Python.
Vector = TypeVar("Vector")
Pointer = TypeVar("Pointer")
Index = TypeVar("Index")
Place: TypeAlias = Index | int  # one that is known while the program is written is itself on all machines
Room = NDArray[np.number]


class LoopMachine(Protocol[Vector, Pointer, Index]):
    """The operations from which a program is made."""

    def do(self, operation: str, *operands: Vector) -> Vector:
        """An operation of `numpy_spelling.SPELLING` on vectors."""

    def number(self, value: float) -> Vector:
        """A double in every lane."""

    def product(self, a: Vector, b: Vector) -> tuple[Vector, Vector]:
        """The rounded product, and its exact error."""

    def load(self, array: Pointer, index: Place[Index]) -> Vector:
        """An entry of an array."""

    def store(self, array: Pointer, index: Place[Index], value: Vector) -> None:
        """Put a vector into an array."""

    def part(self, array: Pointer, index: Place[Index], length: Place[Index]) -> Pointer:
        """The part of an array of that length that has this place among such parts."""

    def fold(
        self, start: Place[Index], stop: Place[Index], initial: Sequence[Vector], body: Callable[..., Sequence[Vector]]
    ) -> Sequence[Vector]:
        """The vectors that a body makes of some, at each index from `start` to before `stop` in turn."""

    def index(self, operation: str, a: Place[Index], b: Place[Index]) -> Index:
        """The sum (add), difference (sub) or product (mul) of whole numbers."""

    def whole(self, array: Pointer, index: Place[Index]) -> Index:
        """An entry of an array of whole numbers, which has no lanes."""


class ArrayLoops:
    """The machine that computes with NumPy's arrays at once."""

    def do(self, operation: str, *operands: Lanes) -> Lanes:
        """An operation on vectors."""
        return SPELLING[operation](*operands)

    def number(self, value: float) -> Lanes:
        """A double."""
        return np.float64(value)

    def product(self, a: Lanes, b: Lanes) -> tuple[Lanes, Lanes]:
        """The rounded product and its error, from halves whose products are exact."""
        x, y = np.asarray(a, float), np.asarray(b, float)
        (ah, al), (bh, bl), p = halves(x), halves(y), x * y
        return p, al * bl - (((p - ah * bh) - al * bh) - ah * bl)

    def load(self, array: Room, index: int) -> Lanes:
        """An entry of an array."""
        lanes: Lanes = array[index]
        return lanes

    def store(self, array: Room, index: int, value: Lanes) -> None:
        """Put a vector into an array."""
        array[index] = value

    def part(self, array: Room, index: int, length: int) -> Room:
        """A part of an array."""
        return array[index * length : (index + 1) * length]

    def fold(
        self, start: int, stop: int, initial: Sequence[Lanes], body: Callable[..., Sequence[Lanes]]
    ) -> Sequence[Lanes]:
        """A loop."""
        carried = tuple(initial)
        for i in range(start, stop):
            carried = tuple(body(i, *carried))
        return carried

    def index(self, operation: str, a: int, b: int) -> int:
        """A whole number."""
        return {"add": a + b, "sub": a - b, "mul": a * b}[operation]

    def whole(self, array: Room, index: int) -> int:
        """A whole number."""
        return int(array[index])


class LoopCode:
    """The machine that writes LLVM IR for vectors of `width` doubles, for a processor with fused products."""

    def __init__(self, width: int) -> None:
        self.width = width
        self.vector = f"<{width} x double>"
        self.lines: list[str] = []
        self.block = "start"

    def function(self, name: str, numbers: Sequence[str], arrays: Sequence[str]) -> str:
        """The module whose one function has these lines, and takes whole numbers and then pointers by these names."""
        arguments = [*(f"i64 %{n}" for n in numbers), *(f"ptr %{n}" for n in arrays)]
        head = [*declarations(self.width), f"define void @{name}({', '.join(arguments)}) {{", "start:"]
        return "\n".join([*head, *self.lines, "  ret void", "}"])

    def do(self, operation: str, *operands: str) -> str:
        """One instruction on vectors; its name."""
        return self.line(instructions(self.width)[operation].format(*operands))

    def number(self, value: float) -> str:
        """A constant in every lane."""
        return f"<{', '.join([f'double {literal(value)}'] * self.width)}>"

    def product(self, a: str, b: str) -> tuple[str, str]:
        """The rounded product and its error, by a fused one."""
        p = self.do("mul", a, b)
        return p, self.do("fma", a, b, self.do("neg", p))

    def load(self, array: str, index: Place[str]) -> str:
        """The vector at a place."""
        place = self.line(f"getelementptr {self.vector}, ptr {array}, i64 {index}")
        return self.line(f"load {self.vector}, ptr {place}, align 8")

    def store(self, array: str, index: Place[str], value: str) -> None:
        """Put a vector into an array of vectors."""
        place = self.line(f"getelementptr {self.vector}, ptr {array}, i64 {index}")
        self.lines.append(f"  store {self.vector} {value}, ptr {place}, align 8")

    def part(self, array: str, index: Place[str], length: Place[str]) -> str:
        """The pointer to a part of an array."""
        return self.line(f"getelementptr {self.vector}, ptr {array}, i64 {self.index('mul', index, length)}")

    def fold(
        self, start: Place[str], stop: Place[str], initial: Sequence[str], body: Callable[..., Sequence[str]]
    ) -> Sequence[str]:
        """A loop; its blocks end where the next lines begin."""
        tag, before = len(self.lines), self.block
        head, inside, behind, i = f"head{tag}", f"inside{tag}", f"behind{tag}", f"%i{tag}"
        names = [f"%c{tag}_{j}" for j in range(len(initial))]
        self.lines += [f"  br label %{head}", f"{head}:"]
        place = len(self.lines)
        self.lines += [""] * (1 + len(names))  # the phis, whose last operands are not known yet
        more = self.line(f"icmp slt i64 {i}, {stop}")
        self.lines += [f"  br i1 {more}, label %{inside}, label %{behind}", f"{inside}:"]
        self.block = inside
        ends = [*body(i, *names), self.line(f"add i64 {i}, 1")]
        kinds = [*[self.vector] * len(names), "i64"]
        for k, (name, kind, begin, end) in enumerate(
            zip([*names, i], kinds, [*initial, start], ends, strict=True), start=place
        ):
            self.lines[k] = f"  {name} = phi {kind} [ {begin}, %{before} ], [ {end}, %{self.block} ]"
        self.lines += [f"  br label %{head}", f"{behind}:"]
        self.block = behind
        return names

    def index(self, operation: str, a: Place[str], b: Place[str]) -> str:
        """A whole number."""
        return self.line(f"{operation} i64 {a}, {b}")

    def whole(self, array: str, index: Place[str]) -> str:
        """A whole number."""
        return self.line(f"load i64, ptr {self.line(f'getelementptr i64, ptr {array}, i64 {index}')}, align 8")

    # what a program needs beside the machine

    def broadcast(self, array: str, index: Place[str]) -> str:
        """The double at a place of an array of doubles, in every lane."""
        place = self.line(f"getelementptr double, ptr {array}, i64 {index}")
        number = self.line(f"load double, ptr {place}, align 8")
        first = self.line(f"insertelement {self.vector} poison, double {number}, i64 0")
        lanes = f"<{self.width} x i32> zeroinitializer"
        return self.line(f"shufflevector {self.vector} {first}, {self.vector} poison, {lanes}")

    def scatter(self, array: str, index: Place[str], apart: Place[str], value: str) -> None:
        """Put the doubles of a vector into an array of doubles, each as far `apart` from the one before."""
        for lane in range(self.width):
            number = self.line(f"extractelement {self.vector} {value}, i64 {lane}")
            at = self.index("add", index, self.index("mul", apart, lane))
            place = self.line(f"getelementptr double, ptr {array}, i64 {at}")
            self.lines.append(f"  store double {number}, ptr {place}, align 8")

    def line(self, text: str) -> str:
        """One instruction; its name."""
        name = f"%v{len(self.lines)}"
        self.lines.append(f"  {name} = {text}")
        return name
