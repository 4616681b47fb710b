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
    def fused_products(self) -> bool: ...  # noqa: D102
    def do(self, operation: str, *operands: Value) -> Value: ...  # noqa: D102
    def constant(self, value: float) -> Value: ...  # noqa: D102
    def word(self, value: int) -> Value: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class MachineTruth(Generic[Value]):
    """A truth on a machine."""

    machine: Machine[Value]
    value: Value

    def __and__(self, other: MachineTruth[Value]) -> MachineTruth[Value]:
        return MachineTruth(self.machine, self.machine.do("and", self.value, other.value))

    def __or__(self, other: MachineTruth[Value]) -> MachineTruth[Value]:
        return MachineTruth(self.machine, self.machine.do("or", self.value, other.value))

    def __invert__(self) -> MachineTruth[Value]:
        return MachineTruth(self.machine, self.machine.do("not", self.value))


def _of_words(operation: str) -> Callable[[MachineWord[Value], MachineWord[Value] | int], MachineWord[Value]]:
    """An operator of two words, the second of which may be a whole number."""

    def operator(word: MachineWord[Value], other: MachineWord[Value] | int) -> MachineWord[Value]:
        operand = other.value if isinstance(other, MachineWord) else word.machine.word(other)
        return MachineWord(word.machine, word.machine.do(operation, word.value, operand))

    return operator


@dataclass(frozen=True, eq=False)
class MachineWord(Generic[Value]):
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
    def nonzero(self) -> MachineTruth[Value]:
        """True where a bit is set."""
        return MachineTruth(self.machine, self.machine.do("nonzero", self.value))

    @property
    def number(self) -> MachineNumber[Value]:
        """The number that has these bits."""
        return MachineNumber(self.machine, self.machine.do("number", self.value))

    @property
    def as_signed(self) -> MachineNumber[Value]:
        """The word as a signed whole number."""
        return MachineNumber(self.machine, self.machine.do("signed", self.value))


def _of_numbers(operation: str) -> Callable[[MachineNumber[Value], MachineNumber[Value] | float], MachineNumber[Value]]:
    return lambda number, other: number.do(operation, other)


def _of_order(operation: str) -> Callable[[MachineNumber[Value], MachineNumber[Value] | float], MachineTruth[Value]]:
    return lambda number, other: number.compare(operation, other)


@dataclass(frozen=True, eq=False)
class MachineNumber(Generic[Value]):
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

    def __rsub__(self, other: float) -> MachineNumber[Value]:
        return number(self.machine, other) - self

    def __rtruediv__(self, other: float) -> MachineNumber[Value]:
        return number(self.machine, other) / self

    def __neg__(self) -> MachineNumber[Value]:
        return self.do("neg")

    def __abs__(self) -> MachineNumber[Value]:
        return self.do("fabs")

    @property
    def bits(self) -> MachineWord[Value]:
        """The bits of the number as a word."""
        return MachineWord(self.machine, self.machine.do("bits", self.value))

    def do(self, operation: str, *others: MachineNumber[Value] | float) -> MachineNumber[Value]:
        """The result of an operation on this number and others."""
        operands = (number(self.machine, other).value for other in others)
        return MachineNumber(self.machine, self.machine.do(operation, self.value, *operands))

    def compare(self, operation: str, other: MachineNumber[Value] | float) -> MachineTruth[Value]:
        """A comparison with another one; NaN differs from all numbers, and is neither smaller nor larger."""
        return MachineTruth(self.machine, self.machine.do(operation, self.value, number(self.machine, other).value))


def number(machine: Machine[Value], value: MachineNumber[Value] | float) -> MachineNumber[Value]:
    """A number as one of the machine's."""
    return value if isinstance(value, MachineNumber) else MachineNumber(machine, machine.constant(value))


def select(
    truth: MachineTruth[Value], a: MachineNumber[Value] | float, b: MachineNumber[Value] | float
) -> MachineNumber[Value]:
    """The first number where the truth holds, the second elsewhere."""
    machine = truth.machine
    return MachineNumber(machine, machine.do("select", truth.value, number(machine, a).value, number(machine, b).value))


def fma(
    a: MachineNumber[Value], b: MachineNumber[Value] | float, c: MachineNumber[Value] | float
) -> MachineNumber[Value]:
    """a b + c, with one rounding where the machine fuses products."""
    return a.do("fma", b, c) if a.machine.fused_products else a * b + c
