"""The normal numbers of `noise.py` as straight lines of LLVM IR, for runs side by side in the lanes of a vector.

`pair` there is written in Python's operators. Here an operator writes the one instruction that does the same to
every lane, without fast-math flags: so both give the same bits, and there is one definition to trust.
"""

from __future__ import annotations

from dataclasses import dataclass

from workbench.simulate.kernel import functions as f
from workbench.simulate.kernel.functions import Writer
from workbench.simulate.kernel.noise import pair


def normals(w: Writer, seed: str, runs: str, step: str, entries: int) -> list[str]:
    """The names of `entries` vectors of standard normal numbers, one number for each run.

    Parameters
    ----------
    seed, runs, step
        Names of values of the type `w.integers`: in every lane the seed, the index of its run and of the step,
        in the ranges that `noise.normals` checks. A step from 2^32 on would repeat an earlier one.
    """
    arithmetic = _Lanes(w)
    key, run, k = (Whole(w, name) for name in (seed, runs, step))
    made: list[str] = []
    for index in range((entries + 1) // 2):
        made += (number.name for number in pair(arithmetic, key, run, k, Whole(w, w.whole(index))))
    return made[:entries]


@dataclass(frozen=True)
class Whole:
    """Words of 64 bits in the lanes of a vector; they wrap around."""

    w: Writer
    name: str

    def __add__(self, other: Whole | int) -> Whole:
        return self._made("add", other)

    def __mul__(self, other: Whole | int) -> Whole:
        return self._made("mul", other)

    def __and__(self, other: Whole | int) -> Whole:
        return self._made("and", other)

    def __or__(self, other: Whole | int) -> Whole:
        return self._made("or", other)

    def __xor__(self, other: Whole | int) -> Whole:
        return self._made("xor", other)

    def __lshift__(self, other: int) -> Whole:
        return self._made("shl", other)

    def __rshift__(self, other: int) -> Whole:
        return self._made("lshr", other)

    def _made(self, op: str, other: Whole | int) -> Whole:
        operand = other.name if isinstance(other, Whole) else self.w.whole(other)
        return Whole(self.w, self.w.line(f"{op} {self.w.integers} {self.name}, {operand}"))


@dataclass(frozen=True)
class Real:
    """Doubles in the lanes of a vector."""

    w: Writer
    name: str

    def __add__(self, other: Real | float) -> Real:
        return self._made("fadd", other)

    def __sub__(self, other: Real | float) -> Real:
        return self._made("fsub", other)

    def __mul__(self, other: Real | float) -> Real:
        return self._made("fmul", other)

    def __truediv__(self, other: Real | float) -> Real:
        return self._made("fdiv", other)

    def _made(self, op: str, other: Real | float) -> Real:
        operand = other.name if isinstance(other, Real) else self.w.vector(other)
        return Real(self.w, f.binary(self.w, op, self.name, operand))


@dataclass(frozen=True)
class _Lanes:
    """The arithmetic of vectors in IR."""

    w: Writer

    def number(self, bits: Whole) -> Real:
        return Real(self.w, self.w.line(f"bitcast {self.w.integers} {bits.name} to {self.w.type}"))

    def bits(self, number: Real) -> Whole:
        return Whole(self.w, self.w.line(f"bitcast {self.w.type} {number.name} to {self.w.integers}"))

    def sqrt(self, number: Real) -> Real:
        return Real(self.w, f.unary(self.w, "sqrt", number.name))

    def select(self, bits: Whole, a: Real, b: Real) -> Real:
        condition = self.w.line(f"icmp ne {self.w.integers} {bits.name}, {self.w.whole(0)}")
        return Real(self.w, f.select(self.w, condition, a.name, b.name))
