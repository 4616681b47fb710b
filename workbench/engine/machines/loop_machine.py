"""Looping machine: a machine that has arrays, and passes a body a fixed number of times over their rows.

All machines pass a loop in the same order, so a loop has the bits of the operations of its passes, one after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeAlias, runtime_checkable

from workbench.engine.machines.machine import Machine, Value


@dataclass(frozen=True)
class Part(Generic[Value]):
    """A part of an array: one number, of length 0, or an array with its length."""

    value: Value
    length: int = 0

    @property
    def size(self) -> int:
        """The number of entries."""
        return self.length or 1


@dataclass(frozen=True)
class LoopShape:
    """The passes of a loop, their direction, and the lengths of the arrays.

    Attributes
    ----------
    carry_size, row_sizes, result_sizes
        The number of carried values, and the lengths of the rows that a pass reads and makes.
    carries_items
        True if the body reads the carried values one by one.
    """

    count: int
    backward: bool
    carry_size: int
    row_sizes: tuple[int, ...]
    result_sizes: tuple[int, ...]
    carries_items: bool


Parts: TypeAlias = Sequence[Part[Value]]
Pass: TypeAlias = Sequence[Sequence[Part[Value]]]  # the parts of the next carried values, and of each row
Adopt: TypeAlias = Callable[[Part[Value]], Value]  # gives a value from outside a loop as one of the machine of its body
# A pass on a machine, from the arrays of the carried values and of each row.
Body: TypeAlias = Callable[["LoopingMachine[Value]", Sequence[Value], Adopt[Value]], Pass[Value]]


class LoopingMachine(Machine[Value], Protocol[Value]):
    """A machine with arrays and loops."""

    def array(self, parts: Parts[Value]) -> Value:
        """The array of some parts, one behind the other."""

    def slice(self, array: Value, start: int, length: int) -> Value:
        """A part of an array."""

    def item(self, array: Value, place: int) -> Value:
        """A number of an array."""

    def loop(self, shape: LoopShape, start: Parts[Value], rows: Sequence[Value], body: Body[Value]) -> Sequence[Value]:
        """The arrays of the carried values at the end, and of all rows that the passes made."""


@runtime_checkable
class BranchingMachine(Protocol[Value]):
    """A machine that leaves out lines which no run needs."""

    def branch(
        self,
        condition: Value,
        old: Sequence[Value],
        in_place: Sequence[tuple[Value, int]],
        new: Callable[[], Iterator[Value]],
    ) -> Sequence[Value]:
        """The values that `new` makes where a truth holds, and elsewhere those of `old` and `in_place`.

        The lines of `new` are run only if the truth holds in some lane. An entry in place, by its array and
        number, may be written as soon as its new value is made.
        """
