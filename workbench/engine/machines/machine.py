"""Machine: the operations that a target has, all of them rounded by IEEE 754 in one way, and numbers that use them.

Elementary functions, noise and the nodes of a graph are written once, in Python's operators on these numbers. A machine
writes LLVM IR for an operator, computes it on NumPy's arrays, or notes it down for later, with the same bits.

    numbers     add sub mul div neg fabs sqrt floor trunc copysign, and fma where products are fused
    truths      lt le gt ge eq ne of numbers; and or not of truths; nonzero of a word
    words       of 64 bits, which wrap around: word_add word_mul word_and word_or word_xor shl lshr
    between     select by a truth; bits of a number, number of bits; signed: the number that a signed word is
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

Value = TypeVar("Value")  # what a machine has for a number, a truth or a word


class Machine(Protocol[Value]):
    """A target: its operations, and True if it rounds a product together with the sum that it is for."""

    @property
    def fused(self) -> bool: ...  # noqa: D102
    def do(self, operation: str, *operands: Value) -> Value: ...  # noqa: D102
    def constant(self, value: float) -> Value: ...  # noqa: D102
    def word(self, value: int) -> Value: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Truth(Generic[Value]):
    """A truth on a machine."""

    machine: Machine[Value]
    value: Value

    def __and__(self, other: Truth[Value]) -> Truth[Value]:
        return Truth(self.machine, self.machine.do("and", self.value, other.value))

    def __or__(self, other: Truth[Value]) -> Truth[Value]:
        return Truth(self.machine, self.machine.do("or", self.value, other.value))

    def __invert__(self) -> Truth[Value]:
        return Truth(self.machine, self.machine.do("not", self.value))


def _of_words(operation: str) -> Callable[[Word[Value], Word[Value] | int], Word[Value]]:
    """An operator of two words, the second of which may be a whole number."""

    def operator(word: Word[Value], other: Word[Value] | int) -> Word[Value]:
        operand = other.value if isinstance(other, Word) else word.machine.word(other)
        return Word(word.machine, word.machine.do(operation, word.value, operand))

    return operator


@dataclass(frozen=True, eq=False)
class Word(Generic[Value]):
    """A word of 64 bits on a machine."""

    machine: Machine[Value]
    value: Value

    __add__ = _of_words("word_add")
    __mul__ = _of_words("word_mul")
    __and__ = _of_words("word_and")
    __or__ = _of_words("word_or")
    __xor__ = _of_words("word_xor")
    __lshift__ = _of_words("shl")
    __rshift__ = _of_words("lshr")

    @property
    def nonzero(self) -> Truth[Value]:
        """True where a bit is set."""
        return Truth(self.machine, self.machine.do("nonzero", self.value))

    @property
    def number(self) -> Number[Value]:
        """The number that has these bits."""
        return Number(self.machine, self.machine.do("number", self.value))

    @property
    def signed(self) -> Number[Value]:
        """The word as a signed whole number."""
        return Number(self.machine, self.machine.do("signed", self.value))


def _of_numbers(operation: str) -> Callable[[Number[Value], Number[Value] | float], Number[Value]]:
    return lambda number, other: number.do(operation, other)


def _of_order(operation: str) -> Callable[[Number[Value], Number[Value] | float], Truth[Value]]:
    return lambda number, other: number.compare(operation, other)


@dataclass(frozen=True, eq=False)
class Number(Generic[Value]):
    """A double on a machine."""

    machine: Machine[Value]
    value: Value

    __add__ = _of_numbers("add")
    __sub__ = _of_numbers("sub")
    __mul__ = _of_numbers("mul")
    __truediv__ = _of_numbers("div")
    __lt__ = _of_order("lt")
    __le__ = _of_order("le")
    __gt__ = _of_order("gt")
    __ge__ = _of_order("ge")

    def __rsub__(self, other: float) -> Number[Value]:
        return number(self.machine, other) - self

    def __rtruediv__(self, other: float) -> Number[Value]:
        return number(self.machine, other) / self

    def __neg__(self) -> Number[Value]:
        return self.do("neg")

    def __abs__(self) -> Number[Value]:
        return self.do("fabs")

    @property
    def bits(self) -> Word[Value]:
        """The bits of the number as a word."""
        return Word(self.machine, self.machine.do("bits", self.value))

    def do(self, operation: str, *others: Number[Value] | float) -> Number[Value]:
        """The result of an operation on this number and others."""
        operands = (number(self.machine, other).value for other in others)
        return Number(self.machine, self.machine.do(operation, self.value, *operands))

    def compare(self, operation: str, other: Number[Value] | float) -> Truth[Value]:
        """A comparison with another one; NaN differs from all numbers, and is neither smaller nor larger."""
        return Truth(self.machine, self.machine.do(operation, self.value, number(self.machine, other).value))


def number(machine: Machine[Value], value: Number[Value] | float) -> Number[Value]:
    """A number as one of the machine's."""
    return value if isinstance(value, Number) else Number(machine, machine.constant(value))


def select(truth: Truth[Value], a: Number[Value] | float, b: Number[Value] | float) -> Number[Value]:
    """The first number where the truth holds, the second elsewhere."""
    machine = truth.machine
    return Number(machine, machine.do("select", truth.value, number(machine, a).value, number(machine, b).value))


def fma(a: Number[Value], b: Number[Value] | float, c: Number[Value] | float) -> Number[Value]:
    """a b + c, with one rounding where the machine fuses products."""
    return a.do("fma", b, c) if a.machine.fused else a * b + c
