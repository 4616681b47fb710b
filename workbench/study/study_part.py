"""The contract of a part of a study, its works, tunings, sweeps or cases, and the place where it is completed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TypedDict

from workbench.study.ledger.store import Ledger, about_in
from workbench.study.ledger.study_record import UNUSED_CHUNKS, StudyRecord, SweepRecord, WorkRecord
from workbench.study.run_options import StudyOptions
from workbench.study.study_results import Results


class PartRecord(TypedDict, total=False):
    """The description that a part gives of itself: fields of `StudyRecord`, and `tunings` for the sweeps of tunings."""

    tunings: tuple[SweepRecord, ...]
    sweeps: tuple[SweepRecord, ...]
    works: tuple[WorkRecord, ...]
    more: bool
    cases: SweepRecord | None


class AbstractPart(ABC):
    """One kind of what a study declares, compiled."""

    @property
    @abstractmethod
    def share(self) -> PartRecord:
        """The description of the part in the ledger, as far as it is known before it is completed."""

    @abstractmethod
    def complete(self, site: RunContext, results: Results) -> Results:
        """The results of the parts before, with those of this part, computed where the ledger lacks them.

        Raises
        ------
        LookupError
            If nothing shall be computed, and something is missing.
        """


class Description:
    """The description of a study in its ledger, made of the shares of its parts."""

    def __init__(self, ledger: Ledger, about: StudyRecord) -> None:
        self._ledger, self._about = ledger, about
        self._tunings: tuple[SweepRecord, ...] = ()
        self._sweeps: tuple[SweepRecord, ...] = ()

    @property
    def about(self) -> StudyRecord:
        """The record."""
        return replace(self._about, sweeps=(*self._tunings, *self._sweeps))

    def update(self, *shares: PartRecord) -> None:
        """Let shares replace what is described in their fields."""
        for share in shares:
            self._tunings = share.get("tunings", self._tunings)
            self._sweeps = share.get("sweeps", self._sweeps)
            about = self._about
            works, more = share.get("works", about.works), share.get("more", about.more)
            self._about = replace(about, works=works, more=more, cases=share.get("cases", about.cases))

    def write(self) -> None:
        """Write the record, if the ledger holds another one."""
        self._ledger.describe(self.about)

    @property
    def is_newest(self) -> bool:
        """False while works are still to be made from results, and an earlier run may have described these too."""
        return not self._about.more or about_in(self._ledger.out) is None

    @property
    def chunks(self) -> tuple[str, ...]:
        """The names of the chunks of tunings and works."""
        return replace(self._about, sweeps=self._tunings, cases=None).chunks


@dataclass(frozen=True, eq=False)
class RunContext:
    """The ledger in which the parts of a study are completed, the order that asks for them, and the description."""

    ledger: Ledger
    order: StudyOptions
    description: Description

    @property
    def name(self) -> str:
        """The name of the study."""
        return self.description.about.study

    def say_unused(self) -> None:
        """Say how many chunks of the ledger belong to no part of the study."""
        if unused := self.description.about.count_unused(self.ledger.names):
            self.order.say(UNUSED_CHUNKS.format(count=unused, out=self.ledger.out))
