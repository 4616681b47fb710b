"""NumPy's spelling: an operation as a function of arrays of doubles and words of 64 bits, or of floats and 32 bits.

References
----------
Boldo and Melquiond (2008), Emulation of a FMA and correctly rounded sums: proved algorithms using rounding to odd,
IEEE Transactions on Computers 57, section 4.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import cast

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array
from workbench.engine.machines.elementary_functions import halves
from workbench.engine.machines.loop_machine import Body, LoopingMachine, LoopShape, Parts

Lanes = NDArray[np.generic] | np.generic  # numbers, truths or words of NumPy
Reals = Array | np.float64

# Within these sizes no part of a product is lost below the range of a double, and none beyond it.
LEAST_PRODUCT, MOST_FACTOR, MOST_TERM = 2.0**-960, 2.0**990, 2.0**1000


def fma(a: Reals, b: Reals, c: Reals) -> Array:
    """a b + c with one rounding, elementwise."""
    with np.errstate(all="ignore"):
        product = np.multiply(a, b)
        result = np.asarray(_by_parts(a, b, c, product))
        size = np.abs(product)
        amid = (size >= LEAST_PRODUCT) & (size <= MOST_TERM) & (np.abs(c) <= MOST_TERM)
        amid &= (np.abs(a) <= MOST_FACTOR) & (np.abs(b) <= MOST_FACTOR)
        if not amid.all():
            finite = np.isfinite(a) & np.isfinite(b)
            plain = np.where(finite & ~np.isfinite(c), c, product + c)  # exact products: of zero, of what is not finite
            known = amid | ~finite | ~np.isfinite(c) | (a == 0) | (b == 0)
            result = np.where(amid, result, plain)
            if not known.all():
                rare = np.flatnonzero(~known)
                operands = (np.broadcast_to(part, result.shape).flat[rare].tolist() for part in (a, b, c))
                result.flat[rare] = [_one(*each) for each in zip(*operands, strict=True)]
    return result


def _by_parts(a: Reals, b: Reals, c: Reals, product: Reals) -> Reals:
    """a b + c from an exact product and two exact sums, the smaller parts added with rounding to odd."""
    (ah, al), (bh, bl) = halves(a), halves(b)
    lacking = al * bl - (((product - ah * bh) - al * bh) - ah * bl)
    middle, low = _sum(c, lacking)
    high, rest = _sum(product, middle)
    return high + _odd(rest, low)


def _sum(a: Reals, b: Reals) -> tuple[Reals, Reals]:
    """The rounded sum and its error (Knuth)."""
    total = a + b
    other = total - a
    return total, (a - (total - other)) + (b - other)


def _odd(a: Reals, b: Reals) -> Array:
    """A sum that is exact or, of the two doubles beside it, the one with an odd last bit."""
    total, lacking = _sum(a, b)
    bits = np.asarray(total).view(np.int64)
    outward = np.where((lacking > 0) == (total > 0), 1, -1)
    return np.where((lacking != 0) & (bits & 1 == 0), bits + outward, bits).view(np.float64)


def _one(a: float, b: float, c: float) -> float:
    """a b + c from fractions, for finite numbers whose product is not zero."""
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    try:
        return float(exact)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def _zeros_in_order(larger: np.ufunc, of_zeros: Callable[[Reals, Reals], Reals]) -> Callable[[Reals, Reals], Lanes]:
    """The larger or the smaller of two numbers, where NaN passes on, and -0 is below 0, which NumPy leaves open."""
    return lambda a, b: np.where((a == 0) & (b == 0), of_zeros(a, b), larger(a, b))


SPELLING: Mapping[str, Callable[..., Lanes]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "fma": fma,
    "neg": np.negative,
    "fabs": np.fabs,
    "sqrt": np.sqrt,
    "floor": np.floor,
    "trunc": np.trunc,
    "copysign": np.copysign,
    "max": _zeros_in_order(np.maximum, lambda a, b: a + b),
    "min": _zeros_in_order(np.minimum, lambda a, b: -(-a - b)),
    "isnan": np.isnan,
    "lt": np.less,
    "le": np.less_equal,
    "gt": np.greater,
    "ge": np.greater_equal,
    "eq": np.equal,
    "ne": np.not_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "nonzero": lambda word: word != np.uint64(0),
    "word_add": np.add,
    "word_mul": np.multiply,
    "word_and": np.bitwise_and,
    "word_or": np.bitwise_or,
    "word_xor": np.bitwise_xor,
    "shl": np.left_shift,
    "lshr": np.right_shift,
    "select": np.where,
    "bits": lambda number: np.asarray(number).view(np.uint64),
    "number": lambda word: np.asarray(word).view(np.float64),
    "signed": lambda word: np.asarray(word).view(np.int64).astype(np.float64),
}
IN_SINGLE: Mapping[str, Callable[..., Lanes]] = {
    **{name: function for name, function in SPELLING.items() if name != "fma"},
    "nonzero": lambda word: word != np.uint32(0),
    "bits": lambda number: np.asarray(number).view(np.uint32),
    "number": lambda word: np.asarray(word).view(np.float32),
    "signed": lambda word: np.asarray(word).view(np.int32).astype(np.float32),
}


class AbstractLanes(ABC):
    """The arrays and loops of a machine that computes each operation at once; an array has its entries in front."""

    @abstractmethod
    def do(self, operation: str, *operands: Lanes) -> Lanes:
        """The result."""

    def array(self, parts: Parts[Lanes]) -> Lanes:
        """The array of some parts."""
        return join_lanes([(part.value, part.length) for part in parts])

    def slice(self, array: Lanes, start: int, length: int) -> Lanes:
        """A part of an array."""
        return np.asarray(array)[start : start + length]

    def item(self, array: Lanes, place: int) -> Lanes:
        """A number of an array."""
        lanes: Lanes = np.asarray(array)[place]
        return lanes

    def loop(self, shape: LoopShape, start: Parts[Lanes], rows: Sequence[Lanes], body: Body[Lanes]) -> Sequence[Lanes]:
        """The arrays at the end of a loop."""

        def one_pass(arrays: Sequence[Lanes]) -> Sequence[Lanes]:
            made = body(cast(LoopingMachine[Lanes], self), arrays, lambda part: part.value)
            return [self.array(parts) for parts in made]

        return pass_rows(shape, self.array(start), rows, one_pass)


def join_lanes(parts: Sequence[tuple[Lanes, int]]) -> Lanes:
    """The array (n, ...) of numbers, and of arrays with a length, one behind the other."""
    pieces = [np.asarray(value) if length else np.asarray(value)[np.newaxis] for value, length in parts]
    if not pieces:
        return np.zeros(0)
    lanes = np.broadcast_shapes(*(piece.shape[1:] for piece in pieces))
    return np.concatenate([np.broadcast_to(piece, (len(piece), *lanes)) for piece in pieces])


def pass_rows(
    shape: LoopShape,
    carry: Lanes,
    rows: Sequence[Lanes],
    one_pass: Callable[[Sequence[Lanes]], Sequence[Lanes]],
) -> Sequence[Lanes]:
    """The carried values at the end of a loop, and the rows that it made, one behind the other in their order."""
    passes = list[Sequence[Lanes]]()
    for k in range(shape.count):
        place = shape.count - 1 - k if shape.backward else k
        own = [np.asarray(part)[place * n : (place + 1) * n] for part, n in zip(rows, shape.row_sizes, strict=True)]
        carry, *made = one_pass([carry, *own])
        passes.append(made)
    in_order = passes[::-1] if shape.backward else passes
    sizes = enumerate(shape.result_sizes)
    return [carry, *(join_lanes([(made[i], size) for made in in_order]) for i, size in sizes)]


@dataclass(frozen=True)
class Arrays(AbstractLanes):
    """A machine that computes each operation at once."""

    fused_products: bool

    def do(self, operation: str, *operands: Lanes) -> Lanes:
        """The result."""
        return SPELLING[operation](*operands)

    def constant(self, value: float) -> Lanes:
        """A double."""
        return np.float64(value)

    def word(self, value: int) -> Lanes:
        """64 bits."""
        return np.uint64(value % 2**64)


@dataclass(frozen=True)
class Singles(AbstractLanes):
    """A machine that computes each operation at once, on arrays of floats and of words of 32 bits."""

    fused_products: bool = False

    def do(self, operation: str, *operands: Lanes) -> Lanes:
        """The result."""
        return IN_SINGLE[operation](*operands)

    def constant(self, value: float) -> Lanes:
        """A float."""
        return np.float32(value)

    def word(self, value: int) -> Lanes:
        """32 bits."""
        return np.uint32(value % 2**32)
