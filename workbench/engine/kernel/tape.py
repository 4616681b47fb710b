"""A tape of NumPy's operations: recorded once, and played again and again."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from operator import itemgetter
from typing import cast

import numpy as np

from workbench.engine.machines.loop_machine import Body, LoopShape, Part, Parts
from workbench.engine.machines.numpy_spelling import SPELLING, Lanes, join_lanes, pass_rows

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
        return self._note(operation, SPELLING[operation], operands)

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

    def array(self, parts: Parts[int]) -> int:
        """The place of an array."""
        lengths = tuple(part.length for part in parts)

        def join(*values: Lanes) -> Lanes:
            return join_lanes(list(zip(values, lengths, strict=True)))

        return self._note(("array", lengths), join, tuple(part.value for part in parts))

    def slice(self, array: int, start: int, length: int) -> int:
        """The place of a part of an array."""
        return self._note(("slice", start, length), lambda all_: np.asarray(all_)[start : start + length], (array,))

    def item(self, array: int, place: int) -> int:
        """The place of a number of an array."""
        return self._note(("item", place), lambda all_: np.asarray(all_)[place], (array,))

    def loop(self, shape: LoopShape, start: Parts[int], rows: Sequence[int], body: Body[int]) -> Sequence[int]:
        """The places of the arrays at the end of a loop, whose body has a tape of its own."""
        inner, adopted = Tape(self.fused_products), dict[int, int]()
        own = [inner.place(("own", i)) for i in range(1 + len(rows))]

        def adopt(part: Part[int]) -> int:
            return adopted.setdefault(part.value, inner.place(("outside", part.value)))

        results = [inner.array(parts) for parts in body(inner, own, adopt)]
        lines, held = inner.lines(results), tuple(adopted.values())

        def run(first: Lanes, *others: Lanes) -> Sequence[Lanes]:
            known = inner.constants | dict(zip(held, others[len(rows) :], strict=True))

            def one_pass(arrays: Sequence[Lanes]) -> Sequence[Lanes]:
                values = known | dict(zip(own, arrays, strict=True))
                play(lines, values)
                return [values[place] for place in results]

            return pass_rows(shape, first, others[: len(rows)], one_pass)

        arrays = cast(Callable[..., Lanes], run)  # of which the next lines take one each
        whole = self._note(("loop", id(run)), arrays, (self.array(start), *rows, *adopted))
        return [self._note(("of", i), itemgetter(i), (whole,)) for i in range(len(results))]

    def _note(self, operation: object, function: Callable[..., Lanes], operands: tuple[int, ...]) -> int:
        """The place of the result of a function, noted once for each operation on the same operands."""
        place = self.place((operation, operands))
        self.notes.setdefault(place, (function, operands))
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
