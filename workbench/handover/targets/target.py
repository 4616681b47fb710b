"""The contract of a target: a machine that runs a law over recorded readings and references."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.handover.c99.c_files import CCode
from workbench.handover.memory_digest import Reals, Words
from workbench.handover.recording import Recording
from workbench.handover.targets.harness import TargetAnswers


@dataclass(frozen=True)
class TargetCost:
    """The cost of a law on a target; None for a figure that is not known there.

    Attributes
    ----------
    instructions, most
        The mean count of a period, and the largest of any one.
    stack
        Bytes along the deepest chain of calls from the step.
    touched
        Bytes of stack that calls were seen to change, those of the compiler's own routines among them.
    code, data
        Bytes of code with constants, and of data that changes, beside the state, which its owner holds.
    smallest
        Bytes of code at -Os.
    doubt
        The sentence that says which of them are lacking and why.
    """

    instructions: float | None = None
    most: int | None = None
    stack: int | None = None
    touched: int | None = None
    code: int | None = None
    data: int | None = None
    smallest: int | None = None
    doubt: str = ""


class AbstractTarget(ABC):
    """A machine by its name, with the programs that it needs here."""

    name: str

    @property
    @abstractmethod
    def programs(self) -> tuple[str, ...]:
        """The programs without which it does not run."""

    @abstractmethod
    def answers(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetAnswers:
        """Commands and memories for the inputs of a recording, in a folder of its own; a TargetError if none."""

    @abstractmethod
    def figures(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetCost:
        """The cost of the law, after `answers`; a TargetError if it cannot be measured."""


@dataclass(frozen=True)
class CalledTarget(AbstractTarget):
    """A function from readings (N, ny) and references (N, nr) to commands (N, nu) and digests of the memory (N,).

    It begins with the memory at its start, goes on from its own, and may give None for digests that it cannot know.
    """

    name: str
    call: Callable[[Reals, Reals], tuple[Reals, Words | None]]
    needs: tuple[str, ...] = ()

    @property
    def programs(self) -> tuple[str, ...]:
        """Those that the function needs."""
        return self.needs

    def answers(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetAnswers:
        """The function's own."""
        u, digests = self.call(recording.y, recording.r)
        return TargetAnswers(u, np.zeros(len(u), dtype=np.uint64), digests, None)

    def figures(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetCost:
        """None of them."""
        return TargetCost()
