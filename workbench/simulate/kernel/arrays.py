"""NumPy's arrays as a machine: at once, or as a tape that is played again and again in buffers of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from workbench.simulate.kernel.exact import fma
from workbench.simulate.kernel.machine import Value


def _in(make: Callable[..., Any]) -> Callable[..., Any]:
    """The function that puts what it makes into `out`, if there is one, as NumPy's own do."""

    def made(*operands: Any, out: Any = None) -> Any:
        result = make(*operands)
        if out is None:
            return result
        out[...] = result
        return out

    return made


# A result may be written over no operand.
FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "fma": _in(fma),
    "neg": np.negative,
    "fabs": np.fabs,
    "sqrt": np.sqrt,
    "floor": np.floor,
    "trunc": np.trunc,
    "copysign": np.copysign,
    "lt": np.less,
    "le": np.less_equal,
    "gt": np.greater,
    "ge": np.greater_equal,
    "eq": np.equal,
    "ne": np.not_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "nonzero": _in(lambda word: word != np.uint64(0)),
    "word_add": np.add,
    "word_mul": np.multiply,
    "word_and": np.bitwise_and,
    "word_or": np.bitwise_or,
    "word_xor": np.bitwise_xor,
    "shl": np.left_shift,
    "lshr": np.right_shift,
    "select": _in(np.where),
    "bits": _in(lambda number: np.asarray(number).view(np.uint64)),
    "number": _in(lambda word: np.asarray(word).view(np.float64)),
    "signed": _in(lambda word: np.asarray(word).view(np.int64).astype(np.float64)),
}
TRUTHS = {"lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not", "nonzero"}
WORDS = {"bits", "shl", "lshr"}


@dataclass(frozen=True)
class Arrays:
    """Does what it is asked for at once."""

    fused: bool

    def do(self, operation: str, *operands: Value) -> Value:
        """The result."""
        return FUNCTIONS[operation](*operands)

    def constant(self, value: float) -> Value:
        """A double."""
        return np.float64(value)

    def word(self, value: int) -> Value:
        """64 bits."""
        return np.uint64(value % 2**64)


class Note(NamedTuple):
    """An operation on the results of earlier notes."""

    operation: str
    operands: tuple[int, ...]

    @property
    def kind(self) -> type[Any]:
        """Of its result."""
        if self.operation in TRUTHS:
            return np.bool_
        return np.uint64 if self.operation in WORDS or self.operation.startswith("word_") else np.float64


class Tape:
    """Notes what is to be done, each thing once; a value is its place among notes, constants and what comes in."""

    def __init__(self, fused: bool) -> None:
        self.fused = fused
        self.notes: dict[int, Note] = {}
        self.constants: dict[int, Any] = {}
        self.known: dict[object, int] = {}

    def do(self, operation: str, *operands: int) -> int:
        """The place of a result."""
        note = Note(operation, operands)
        place = self.place(note)
        self.notes.setdefault(place, note)
        return place

    def constant(self, value: float) -> int:
        """The place of a double."""
        return self._constant(np.float64(value))

    def word(self, value: int) -> int:
        """The place of 64 bits."""
        return self._constant(np.uint64(value % 2**64))

    def before(self, places: Iterable[int]) -> dict[int, Note]:
        """The notes that these values need, in their order."""
        needed = set(places)
        for place, note in reversed(self.notes.items()):
            if place in needed:
                needed.update(note.operands)
        return {place: note for place, note in self.notes.items() if place in needed}

    def place(self, of: object) -> int:
        """The place of what comes in under a name of its own."""
        return self.known.setdefault(of, len(self.known))

    def _constant(self, value: Any) -> int:
        place = self.place((type(value), value.tobytes()))  # 0 and -0 are two, and NaN is one
        self.constants[place] = value
        return place
