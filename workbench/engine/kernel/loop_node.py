"""The loop of a graph: a body that is passed a fixed number of times, and the arrays that loops read and make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from workbench.engine.kernel.graph import Graph, Node

# Operations that give an array, and the sources of the body of a loop: see `GraphLoop`.
ARRAYS = ("array", "slice", "loop_end", "loop_rows")
LOOP_SOURCES = ("carried", "row", "shared")
Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class GraphLoop:
    """A body that is passed `count` times; see `core.bounded_loop` for its values.

    The operands of its node are the parts of the first carried values, `entry` many; then an array for each of `rows`;
    then the shared values. Of the body, "carried" and "row" (of the array `entry`) are arrays, and "shared" is the
    value of the operand `entry` behind the rows, an array where the node has a length. The results of the body are the
    parts of the next carried values, and of each row that it makes: `parts` has their numbers. A part is a number or an
    array.

    `loop_end` is the array of the carried values at the end, and `loop_rows` that of all rows `entry` that were made.
    `array` puts parts together, `slice` is a part of an array from `entry` on, and `item` is its number at `entry`.
    """

    count: int
    backward: bool
    carry_size: int
    row_sizes: tuple[int, ...]
    result_sizes: tuple[int, ...]
    body: Graph
    parts: tuple[int, ...]

    def split(self, results: Sequence[Result]) -> list[Sequence[Result]]:
        """The parts that belong to the results of the body, by the carried values and each row that it makes."""
        ends = list(accumulate(self.parts))
        return [results[end - size : end] for end, size in zip(ends, self.parts, strict=True)]

    @property
    def carries_items(self) -> bool:
        """True if the body reads the carried values one by one, and nowhere as an array."""
        return not any(
            self.body.nodes[i].op == "carried" and node.op != "item" for node in self.body.nodes for i in node.operands
        )


def length(node: Node) -> int:
    """The number of entries of an array; 0 of a number."""
    return int(node.value) if node.op in ARRAYS or node.op in LOOP_SOURCES else 0
