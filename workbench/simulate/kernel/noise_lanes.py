"""The normal numbers of `noise.py` on a machine, for runs side by side in the lanes of a vector.

`pair` there is written in Python's operators, which here are those of the machine: so both give the same bits, and
there is one definition to trust.
"""

from __future__ import annotations

from workbench.simulate.kernel.machine import Machine, Number, Value, Word, select
from workbench.simulate.kernel.noise import pair


def normals(machine: Machine, seed: Value, runs: Value, step: Value, entries: int) -> list[Value]:
    """`entries` standard normal numbers of the machine.

    Parameters
    ----------
    seed, runs, step
        Words of the machine: the seed, the index of the run and of the step, in the ranges that `noise.normals`
        checks. A step from 2^32 on would repeat an earlier one.
    """
    key, run, k = (Word(machine, word) for word in (seed, runs, step))
    made: list[Value] = []
    for index in range((entries + 1) // 2):
        made += (number.value for number in pair(_Lanes(), key, run, k, Word(machine, machine.word(index))))
    return made[:entries]


class _Lanes:
    """What `pair` needs beyond operators."""

    def number(self, bits: Word) -> Number:
        return bits.number

    def bits(self, number: Number) -> Word:
        return number.bits

    def sqrt(self, number: Number) -> Number:
        return number.do("sqrt")

    def select(self, bits: Word, a: Number, b: Number) -> Number:
        return select(bits.nonzero, a, b)
