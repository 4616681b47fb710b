"""Arrays and loops as lines of LLVM IR: an array is a place in memory, or a few registers that a loop carries."""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import cast

from workbench.engine.kernel.graph import Graph, GraphLoop, length
from workbench.engine.machines.loop_machine import Body, LoopingMachine, LoopShape, Part, Parts

MOST_REGISTERS = 24  # carried values that stay in registers; more are in memory, where the processor would put them
IN_REGISTERS = (
    "loop_end",
    "slice",
    "shared",
)  # arrays that may be registers, which a loop puts into memory as its rows
UNROLLED = 8  # entries that are copied one by one; more are copied by a loop


def room_of(graph: Graph) -> int:
    """The numbers that the arrays of a graph and of its loops have in memory."""
    total = 0
    for node in graph.nodes:
        total += length(node) if node.op == "array" else 0
        if node.loop is not None:
            total += node.loop.carry_size + sum(node.loop.result_sizes) * node.loop.count + room_of(node.loop.body)
            rows = node.operands[node.entry : node.entry + len(node.loop.row_sizes)]
            total += sum(length(graph.nodes[i]) for i in rows if graph.nodes[i].op in IN_REGISTERS)
    return total


@lru_cache(maxsize=128)
def waits_in_loops(graph: Graph) -> bool:
    """True if a graph has loops, and the numbers that each of them carries fit into the registers for two blocks."""
    loops = list(_loops(graph))
    return bool(loops) and all(2 * one.carry_size <= MOST_REGISTERS or not one.carries_items for one in loops)


def _loops(graph: Graph) -> Iterator[GraphLoop]:
    """All loops of a graph, and those within their bodies."""
    for loop in (node.loop for node in graph.nodes if node.loop is not None):
        yield loop
        yield from _loops(loop.body)


class Room:
    """The memory of the arrays of a function: `base` is a pointer to vectors, of which the first `start` are taken.

    `tables` are the arrays of doubles, which are the same in all lanes.
    """

    def __init__(self, base: str, start: int) -> None:
        self.base, self.used = base, start
        self.tables: set[str] = set()

    def reserve(self, size: int) -> int:
        """The place of so many vectors."""
        self.used += size
        return self.used - size


class AbstractLoopEmission(ABC):
    """The arrays and loops of a machine that writes lines; `block` is the label of the block that it writes.

    Attributes
    ----------
    registers
        The numbers of the arrays that are registers.
    homes
        The arrays and places of numbers that a branch has left or put where they are.
    labels
        The numbers of the next labels.
    """

    width: int
    type: str
    flags: str
    prefix: str
    lines: list[str]
    block: str
    room: Room
    registers: dict[str, list[str]]
    homes: dict[str, tuple[str, int]]
    labels: Iterator[int]

    @abstractmethod
    def do(self, operation: str, *operands: str) -> str:
        """One operation; its name."""

    @abstractmethod
    def line(self, text: str) -> str:
        """One instruction; its name."""

    @abstractmethod
    def lane(self, base: str, place: int) -> str:
        """The vector at a place of an array of vectors."""

    @abstractmethod
    def broadcast(self, base: str, place: int) -> str:
        """The double at a place of an array of doubles, in every lane."""

    # of arrays

    def array(self, parts: Parts[str]) -> str:
        """The array of some parts, in memory."""
        place = self._reserve(sum(part.size for part in parts))
        self._write(place, parts)
        return place

    def slice(self, array: str, start: int, length: int) -> str:
        """A part of an array, where it is."""
        if array in self.registers:
            return self._of_registers(self.registers[array][start : start + length])
        return self.part(array, start)

    def item(self, array: str, place: int) -> str:
        """A number of an array."""
        if array in self.room.tables:
            return self.broadcast(array, place)
        return self.registers[array][place] if array in self.registers else self.lane(array, place)

    def table(self, base: str, places: Sequence[int]) -> str:
        """The array of the numbers at some places of an array of vectors, which are the same in all lanes."""
        table = self._reserve(-(-len(places) // self.width))
        self.room.tables.add(table)
        for _, group in itertools.groupby(enumerate(places), lambda one: one[1] - one[0]):
            (to, first), *others = group
            source, target = self.line(f"getelementptr {self.type}, ptr {base}, i64 {first}"), self.part(table, to)

            def entry(k: str, source: str = source, target: str = target) -> None:
                pointer = self.line(f"getelementptr {self.type}, ptr {source}, i64 {k}")
                number = self.line(f"load double, ptr {pointer}, align 8")
                self.lines.append(f"  store double {number}, ptr {self.part(target, k)}")

            self._repeat(1 + len(others), entry)
        return table

    def part(self, array: str, start: int | str, size: int = 1) -> str:
        """The part of an array in memory from a multiple of a size on."""
        is_table = array in self.room.tables
        part = self.line(f"getelementptr [{size} x {'double' if is_table else self.type}], ptr {array}, i64 {start}")
        if is_table:
            self.room.tables.add(part)
        return part

    def _of_registers(self, names: Sequence[str]) -> str:
        """An array of some registers."""
        array = f"registers {len(self.registers)}"
        self.registers[array] = list(names)
        return array

    def _reserve(self, size: int) -> str:
        return self.line(f"getelementptr {self.type}, ptr {self.room.base}, i64 {self.room.reserve(size)}")

    def _numbers(self, parts: Parts[str]) -> list[str]:
        """The numbers of some parts."""
        items = ([self.item(p.value, i) for i in range(p.length)] if p.length else [p.value] for p in parts)
        return list(itertools.chain.from_iterable(items))

    def _write(self, place: str, parts: Parts[str]) -> None:
        """Put some parts into memory, one behind the other."""
        first = 0
        for part in parts:
            if part.length > UNROLLED and part.value not in self.registers and part.value not in self.room.tables:
                self._copy(self.line(f"getelementptr {self.type}, ptr {place}, i64 {first}"), part.value, part.length)
            else:
                for i, name in enumerate(self._numbers([part])):
                    if self.homes.get(name) == (place, first + i):
                        continue
                    pointer = self.line(f"getelementptr {self.type}, ptr {place}, i64 {first + i}")
                    self.lines.append(f"  store {self.type} {name}, ptr {pointer}")
            first += part.size

    def _copy(self, place: str, source: str, size: int) -> None:
        """Copy an array from one place in memory to another."""

        def entry(k: str) -> None:
            value = self.line(f"load {self.type}, ptr {self.line(f'getelementptr {self.type}, ptr {source}, i64 {k}')}")
            pointer = self.line(f"getelementptr {self.type}, ptr {place}, i64 {k}")
            self.lines.append(f"  store {self.type} {value}, ptr {pointer}")

        self._repeat(size, entry)

    # of branches

    def branch(
        self, condition: str, old: Sequence[str], in_place: Sequence[tuple[str, int]], new: Callable[[], Iterator[str]]
    ) -> Sequence[str]:
        """The new values where a condition holds, whose lines are run if it holds in some lane; elsewhere old ones."""
        label, before = f"{self.prefix}_branch_{next(self.labels)}", self.block
        old = [*old, *(self.item(*one) for one in in_place if one[0] in self.registers)]
        in_place = [one for one in in_place if one[0] not in self.registers]
        some = self.line(f"call i1 @llvm.vector.reduce.or.v{self.width}i1({self.flags} {condition})")
        self.lines += [f"  br i1 {some}, label %{label}, label %{label}_end", f"{label}:"]
        self.block = label
        values = new()
        chosen = [self.do("select", condition, next(values), value) for value in old]
        for array, place in in_place:
            value = self.do("select", condition, next(values), self.item(array, place))
            pointer = self.line(f"getelementptr {self.type}, ptr {array}, i64 {place}")
            self.lines.append(f"  store {self.type} {value}, ptr {pointer}")
        after = self.block
        self.lines += [f"  br label %{label}_end", f"{label}_end:"]
        self.block = f"{label}_end"
        pairs = zip(old, chosen, strict=True)
        joined = [self.line(f"phi {self.type} [ {a}, %{before} ], [ {b}, %{after} ]") for a, b in pairs]
        ends = [self.item(*one) for one in in_place]
        self.homes.update(zip(ends, in_place, strict=True))
        return [*joined, *ends]

    # of loops

    def loop(self, shape: LoopShape, start: Parts[str], rows: Sequence[str], body: Body[str]) -> Sequence[str]:
        """The arrays at the end of a loop: its carried values, and the rows that it made."""
        made = [self._reserve(size * shape.count) for size in shape.result_sizes]
        kept = shape.carries_items and shape.carry_size <= MOST_REGISTERS
        first = self._numbers(start) if kept else []
        memory = "" if kept else self.array(start)
        rows = [
            self.array([Part(part, size * shape.count)]) if part in self.registers else part
            for part, size in zip(rows, shape.row_sizes, strict=True)
        ]
        ends = list[str]()

        def one_pass(k: str) -> None:
            index = self.line(f"sub i64 {shape.count - 1}, {k}") if shape.backward else k
            own = [self._row(part, index, size) for part, size in zip(rows, shape.row_sizes, strict=True)]
            label = k.removesuffix("_k")
            carried = self._of_registers([f"{label}_c{i}" for i in range(shape.carry_size)]) if kept else memory
            following, *made_rows = body(cast(LoopingMachine[str], self), [carried, *own], _outside)
            for array, size, row in zip(made, shape.result_sizes, made_rows, strict=True):
                self._write(self._row(array, index, size), row)
            if kept:
                ends.extend(self._numbers(following))
            else:
                self._write(memory, following)

        self._repeat(shape.count, one_pass, lambda: list(zip(first, ends, strict=True)))
        return [self._of_registers(ends) if kept else memory, *made]

    def _row(self, array: str, index: str, size: int) -> str:
        """The place of a row in an array of rows."""
        return self.part(array, index, size)

    def _repeat(
        self, count: int, body: Callable[[str], None], carried: Callable[[], list[tuple[str, str]]] = list
    ) -> None:
        """A loop of so many passes over `body`, which gets the number of the pass; the first and next `carried`."""
        label = f"{self.prefix}_loop_{next(self.labels)}"
        before = self.block
        self.lines += [f"  br label %{label}", f"{label}:"]
        self.block, top = label, len(self.lines)
        k = f"%{label}_k"
        body(k)
        self.lines += [f"  {k}_1 = add i64 {k}, 1", f"  {k}_more = icmp slt i64 {k}_1, {count}"]
        self.lines += [f"  br i1 {k}_more, label %{label}, label %{label}_end", f"{label}_end:"]
        phis = [f"  {k} = phi i64 [ 0, %{before} ], [ {k}_1, %{self.block} ]"]
        for i, (first, after) in enumerate(carried()):
            phis.append(f"  %{label}_c{i} = phi {self.type} [ {first}, %{before} ], [ {after}, %{self.block} ]")
        self.lines[top:top] = phis
        self.block = f"{label}_end"


def _outside(part: Part[str]) -> str:
    """A value from before a loop, which a line of its body can name."""
    return part.value
