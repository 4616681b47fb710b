"""A tape of NumPy's operations: recorded once, and played again and again."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable

import numpy as np

from workbench.engine.machines.numpy_spelling import SPELLING, Lanes

# A place, a function, the places of its operands, and those that nothing behind it needs.
Line = tuple[int, Callable[..., Lanes], tuple[int, ...], tuple[int, ...]]


class Tape:
    """A machine that records operations, each one once; a value is its place among those of a play."""

    def __init__(self, fused_products: bool) -> None:
        self.fused_products = fused_products
        self.places: dict[object, int] = {}
        self.notes: dict[int, tuple[Callable[..., Lanes], tuple[int, ...]]] = {}
        self.constants: dict[int, Lanes] = {}

    def do(self, operation: str, *operands: int) -> int:
        """The place of a result."""
        place = self.place((operation, operands))
        self.notes.setdefault(place, (SPELLING[operation], operands))
        return place

    def constant(self, value: float) -> int:
        """The place of a double; 0 and -0 are two."""
        place = self.place(("number", np.float64(value).tobytes()))
        self.constants[place] = np.float64(value)
        return place

    def word(self, value: int) -> int:
        """The place of 64 bits."""
        place = self.place(("word", value))
        self.constants[place] = np.uint64(value % 2**64)
        return place

    def place(self, of: object) -> int:
        """The place of a named input."""
        return self.places.setdefault(of, len(self.places))

    def lines(self, results: Collection[int]) -> list[Line]:
        """The operations that some results need, each with the values that are not used after it."""
        needed, kept = set(results), list[Line]()
        for place, (function, operands) in reversed(self.notes.items()):
            if place in needed:
                last = tuple({i for i in operands if i in self.notes and i not in needed})
                needed.update(operands)
                kept.append((place, function, operands, last))
        return kept[::-1]


def play(lines: Iterable[Line], values: dict[int, Lanes]) -> None:
    """Compute the lines of a tape, add their results to the values, and delete each value after its last use."""
    for place, function, operands, last in lines:
        values[place] = function(*[values[i] for i in operands])
        for i in last:
            del values[i]
