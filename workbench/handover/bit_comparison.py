"""A target against a recording: the bits that differ, the first of them, and the share of a period that a law takes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from workbench.core.validation import refusals
from workbench.core.validation.notebook_display import show
from workbench.core.validation.signatures import check_arguments
from workbench.handover.c99.c_files import CCode
from workbench.handover.memory_digest import Reals, Words
from workbench.handover.recording import Recording
from workbench.handover.targets import TARGETS, AbstractTarget, TargetCost
from workbench.handover.targets.external_programs import TargetError, missing_programs
from workbench.handover.targets.harness import TargetAnswers

ANOTHER = "leaves another memory"
LIMIT = 600.0  # s that one program of a target may take
CLOCKS: Mapping[str, float] = {  # Hz, of common parts with these processors
    "cortex-m4f": 168e6,
    "cortex-m4f-libgcc": 168e6,
    "cortex-m7": 480e6,
}


@dataclass(frozen=True)
class PeriodShare:
    """The share of a `period` [s] that `count` instructions take at a `clock` [Hz], one instruction per cycle."""

    count: float
    period: float  # s
    clock: float  # Hz

    @property
    def share(self) -> float:
        """The share of the period, 1 for the whole period."""
        return self.count / (self.period * self.clock)

    @property
    def fits(self) -> bool:
        """True if the share is at most 1."""
        return self.share <= 1.0

    def __str__(self) -> str:
        return (
            f"{self.count:,.0f} instructions are {100 * self.share:.3g} % of {self.period:g} s at "
            f"{self.clock / 1e6:g} MHz, at one instruction a cycle"
        )


@check_arguments
def fits(count: float, period: float, clock: float) -> PeriodShare:
    """The share of a `period` [s] that `count` instructions take at a `clock` [Hz], one instruction per cycle.

    A processor may take more cycles than instructions, or fewer: the share follows from the count, not from a measured
    time.

    Raises
    ------
    ValueError
        If a number is not positive and finite.
    """
    for name, value in {"count": count, "period": period, "clock": clock}.items():
        if not 0 < value < np.inf:
            raise refusals.refusal(f"fits({name}=...)", "be a positive finite number", value)
    return PeriodShare(count, period, clock)


@dataclass(frozen=True)
@show
class TargetResult:
    """The comparison of the commands and memories of a target with a recording, bit by bit.

    Attributes
    ----------
    target, periods
        The name of the target, and the number of periods that it ran.
    bits
        The number of bits compared: all commands, and one digest of the memory after each period.
    differing_bits
        The number of bits of commands that differ.
    memories
        Periods whose memory differs.
    flags
        Periods that raised a flag.
    first
        The first difference: period, signal and both values; empty if there is none.
    reason
        The sentence that says why the target did not run; empty if it did.
    figures, fit
        The cost that was measured, such as instructions and bytes, and the share of the period that it takes.
    """

    target: str
    periods: int = 0
    bits: int = 0
    differing_bits: int = 0
    memories: int = 0
    flags: int = 0
    first: str = ""
    figures: TargetCost = TargetCost()  # noqa: RUF009
    fit: PeriodShare | None = None
    reason: str = ""

    @property
    def ran(self) -> bool:
        """True if the target gave answers."""
        return not self.reason

    @property
    def equal(self) -> bool:
        """True if the target gave answers and none of them differs."""
        return self.ran and not self.first


@check_arguments
def compare(target: AbstractTarget, code: CCode, recording: Recording, timeout: float = LIMIT) -> TargetResult:
    """Run a target in a temporary folder and compare it with a recording; a program may take `timeout` seconds."""
    lacks = missing_programs(target.programs)
    if lacks:
        return TargetResult(target.name, reason=lacks)
    with TemporaryDirectory(prefix="workbench-") as place:
        folder = Path(place)
        try:
            answers = target.answers(code, recording, folder, timeout)
        except TargetError as error:
            return TargetResult(target.name, reason=str(error))
        result = _judged(target, recording, answers)
        try:
            result = replace(result, figures=target.figures(code, recording, folder, timeout))
        except TargetError as error:
            result = replace(result, figures=TargetCost(doubt=f"figures are lacking: {error}"))
        if result.first.endswith(ANOTHER):
            result = replace(result, first=_first_of_memory(target, code, recording, folder, result.first, timeout))
    clock = next((CLOCKS[key] for key in CLOCKS if TARGETS[key].name == target.name), None)
    count = result.figures.instructions
    return replace(result, fit=fits(count, recording.law.period, clock)) if clock and count else result


def _judged(target: AbstractTarget, recording: Recording, answers: TargetAnswers) -> TargetResult:
    """The differences of answers."""
    n, nu = recording.u.shape
    other = _differ(answers.u, recording.u)
    memories = np.zeros(n, dtype=bool) if answers.digests is None else answers.digests != recording.digests
    flagged = answers.flags != 0
    wrong = (other != 0).any(axis=1) | memories | flagged
    width = 8 * recording.u.dtype.itemsize
    kept = 0 if answers.digests is None else recording.law.memory.size
    first = _first(recording, answers, other, int(np.argmax(wrong))) if wrong.any() else ""
    counts = (int(np.bitwise_count(other).sum()), int(memories.sum()), int(flagged.sum()))
    return TargetResult(target.name, n, width * n * (nu + kept), *counts, first)


def _differ(answers: Reals, wanted: Reals) -> Words:
    """The bits in which numbers differ; a NaN is like any other."""
    kind = np.dtype(f"u{wanted.dtype.itemsize}")
    bits = np.ascontiguousarray(answers, dtype=wanted.dtype).view(kind) ^ np.ascontiguousarray(wanted).view(kind)
    return np.asarray(np.where(np.isnan(answers) & np.isnan(wanted), kind.type(0), bits))


def _first(recording: Recording, answers: TargetAnswers, other: Words, k: int) -> str:
    """The first difference in words."""
    if answers.flags[k]:
        return f"period {k} raises the flags {int(answers.flags[k])}"
    if other[k].any():
        i = int(np.argmax(other[k] != 0))
        return _words(k, recording.law.commands.labels[i], answers.u[k, i], recording.u[k, i])
    return f"period {k} {ANOTHER}"


def _words(k: int, signal: str, number: np.floating, wanted: np.floating) -> str:
    def bits(value: np.floating) -> str:
        return f"{value!s} (0x{np.asarray(value).tobytes()[::-1].hex()})"

    return f"period {k}, '{signal}': {bits(number)} for {bits(wanted)}"


def _first_of_memory(
    target: AbstractTarget, code: CCode, recording: Recording, folder: Path, first: str, timeout: float
) -> str:
    """The first difference of a memory in words, from a replay that ends there."""
    k = int(first.split()[1])
    try:
        memory = target.answers(code, recording.until(k + 1), folder, timeout).memory
    except TargetError:
        return first
    wanted = recording.memory(k + 1, k + 1)[0]
    if memory is None or not (other := _differ(memory, wanted)).any():
        return first
    i = int(np.argmax(other != 0))
    return _words(k, recording.law.memory.labels[i], memory[i], wanted[i])
