"""Loops and arrays in C: an array is a part of the room of a law, or a few variables that a loop carries."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from workbench.engine.kernel.graph import ARRAYS, Graph, GraphLoop, Node
from workbench.engine.kernel.loop_emission import MOST_REGISTERS

OF_ARRAYS = frozenset((*ARRAYS, "loop"))
COPIED_ONE_BY_ONE = 4  # entries; more are copied by a loop


class LoopNames:
    """The names that the loops of a function have taken, and the numbers of the room for their arrays."""

    def __init__(self) -> None:
        self.room, self.counts = 0, itertools.count(1)

    def reserve(self, size: int) -> int:
        """The place of so many numbers in the room."""
        self.room += size
        return self.room - size


@dataclass(frozen=True)
class PartText:
    """A number, of length 0, or an array with its length, as an expression in C."""

    text: str
    length: int = 0


def array_lines(type_: str, room: str, names: LoopNames, parts: Sequence[PartText]) -> tuple[str, list[str]]:
    """The name of a new array of some parts in the room, and the lines that make it."""
    number = next(names.counts)
    name, size = f"array_{number}", sum(part.length or 1 for part in parts)
    lines = [f"{type_} *const {name} = {_behind(room, names.reserve(size))};"]
    return name, [*lines, *store(name, parts, number)]


def store(name: str, parts: Sequence[PartText], number: int, first: str = "") -> list[str]:
    """The lines that put parts into an array, from an index `first` on."""
    lines, place = list[str](), 0
    for part in parts:
        if part.length > COPIED_ONE_BY_ONE:
            k, to = f"copy_{number}", _index(first, place)
            lines.append(f"for (int {k} = 0; {k} < {part.length}; ++{k}) {{")
            lines += [f"    {name}[{_index('' if to == '0' else to, k)}] = {_element(part.text)}[{k}];", "}"]
        elif part.length:
            lines += [f"{name}[{_index(first, place + i)}] = {_element(part.text)}[{i}];" for i in range(part.length)]
        elif (own := f"{name}[{_index(first, place)}]") != part.text:  # a branch may have written it already
            lines.append(f"{own} = {part.text};")
        place += part.length or 1
    return lines


@dataclass(frozen=True)
class LoopText:
    """The arrays of a loop at its end, and its lines."""

    carry: str
    rows: list[str]
    lines: list[str]


def loop_lines(
    scope: tuple[str, str],
    names: LoopNames,
    loop: GraphLoop,
    start: Sequence[PartText],
    rows: Sequence[str],
    body: Callable[[str, Sequence[str]], tuple[list[str], list[PartText]]],
) -> LoopText:
    """The lines of a loop, for the type of a number and the room.

    `body` has the lines of a pass and its results, for the arrays of the carried values and of the rows.
    """
    type_, room = scope
    number = next(names.counts)
    k, carried = f"pass_{number}", f"carried_{number}"
    own, made = (
        [f"{word}_{number}{'abcdefghijklmnopqrstuvwxyz'[i] if len(sizes) > 1 else ''}" for i in range(len(sizes))]
        for word, sizes in (("row", loop.row_sizes), ("made", loop.result_sizes))
    )
    lines = list[str]()
    if loop.carries_items and loop.carry_size <= MOST_REGISTERS:
        lines += [f"{type_} {carried}[{loop.carry_size}];"] if loop.carry_size else []
    else:
        lines.append(f"{type_} *const {carried} = {_behind(room, names.reserve(loop.carry_size))};")
    for array, size in zip(made, loop.result_sizes, strict=True):
        lines.append(f"{type_} *const {array} = {_behind(room, names.reserve(size * loop.count))};")
    lines += store(carried, start, number)
    inner, results = body(carried, own)
    ends, *made_rows = loop.split(results)
    last = loop.count - 1
    way = f"int {k} = {last}; {k} >= 0; --{k}" if loop.backward else f"int {k} = 0; {k} < {loop.count}; ++{k}"
    lines.append(f"for ({way}) {{")
    for name, array, size in zip(own, rows, loop.row_sizes, strict=True):
        lines.append(f"    const {type_} *const {name} = {array} + {_times(size, k)};")
    for array, size, row in zip(made, loop.result_sizes, made_rows, strict=True):
        inner += store(array, row, number, _times(size, k))
    inner += store(carried, ends, number)
    return LoopText(carried, made, [*lines, *(f"    {line}" for line in inner), "}"])


def slice_text(array: str, start: int) -> str:
    """A part of an array as an expression."""
    return f"{array} + {start}" if start else array


def item_text(array: str, place: int) -> str:
    """An entry of an array."""
    return f"{_element(array)}[{place}]"


def operations(graph: Graph, places: Sequence[int]) -> Iterator[tuple[str, int]]:
    """The operations at some places of a graph, and how often a call does each; in loops, of each pass."""
    for node in (graph.nodes[i] for i in places):
        if node.loop is not None:
            inside = operations(node.loop.body, range(len(node.loop.body.nodes)))
            yield from ((op, node.loop.count * times) for op, times in inside)
        elif node.operands and not _is_access(node):
            yield node.op, 1


def _is_access(node: Node) -> bool:
    return node.op in OF_ARRAYS or node.op == "item"


def _element(array: str) -> str:
    return f"({array})" if " " in array else array


def _behind(room: str, place: int) -> str:
    return f"{room} + {place}" if place else room


def _times(size: int, k: str) -> str:
    return k if size == 1 else f"{size} * {k}"


def _index(first: str, place: int | str) -> str:
    if not first or first == "0":
        return str(place)
    return first if place == 0 else f"{first} + {place}"
