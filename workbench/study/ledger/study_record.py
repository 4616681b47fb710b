"""The record that says which study a ledger is of, how far it is, and which chunks its sweeps and works have."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

from workbench.core.validation.refusals import whole
from workbench.core.validation.signatures import check_arguments
from workbench.study.ledger.chunk import Chunk, plain

ABOUT = "about"  # the name of the record
UNUSED_CHUNKS = (
    "{count} chunks in '{out}' are of other samples or equations than the study has now: they are kept, and not used; "
    "`--fresh` removes them."
)


@dataclass(frozen=True)
@check_arguments
class SweepRecord:
    """The runs, at most so many where a search may end before, the arithmetic and the chunks of one sweep."""

    name: str
    runs: int
    arithmetic: str
    chunks: tuple[str, ...]
    at_most: bool = False

    def __post_init__(self) -> None:
        whole("SweepRecord(runs=...)", self.runs, 0)


@dataclass(frozen=True)
@check_arguments
class WorkRecord:
    """The name of a work, and the record of each of its items."""

    name: str
    chunks: tuple[str, ...]


@dataclass(frozen=True)
@check_arguments
class StudyRecord:
    """The name and script of a study, the samples asked for, its sweeps, works and cases, and its script's digest.

    There are `more` if its works follow from results that are not there yet.
    """

    study: str
    script: str
    samples: int | None = None
    sweeps: tuple[SweepRecord, ...] = ()
    digest: str = ""  # an earlier version did not write it
    works: tuple[WorkRecord, ...] = ()
    more: bool = False
    cases: SweepRecord | None = None  # each is a sweep of one run

    def __post_init__(self) -> None:
        if self.samples is not None:
            whole("StudyRecord(samples=...)", self.samples, 0)

    @property
    def runs(self) -> tuple[SweepRecord, ...]:
        """Its sweeps, and its cases as one more."""
        return self.sweeps if self.cases is None else (*self.sweeps, self.cases)

    @property
    def chunks(self) -> tuple[str, ...]:
        """The names of the chunks of its sweeps, cases and works."""
        held = [part.chunks for part in self.runs] + [part.chunks for part in self.works]
        return tuple(name for names in held for name in names)

    @property
    def chunk(self) -> Chunk:
        """The record."""
        return Chunk(ABOUT, plain(asdict(self)))

    @staticmethod
    def of(study: str, script: Path, out: Path, samples: int | None = None) -> StudyRecord:
        """The state of a study that has nothing yet, by its script and its output folder."""
        digest = hashlib.sha256(script.read_bytes()).hexdigest()
        return StudyRecord(study, os.path.relpath(script.resolve(), out.resolve()), samples, (), digest)

    def script_from(self, out: Path) -> str:
        """The script of the study in an output folder, as seen from the working directory."""
        return os.path.relpath((out / self.script).absolute())

    def has_changed(self, out: Path) -> bool:
        """True if the script is there and is not the one that was run."""
        file = out / self.script
        return bool(self.digest) and file.is_file() and hashlib.sha256(file.read_bytes()).hexdigest() != self.digest

    def count_unused(self, names: Iterable[str]) -> int:
        """The number of chunks, among records by their names, that belong to nothing; 0 while there are more works."""
        if self.more:
            return 0
        wanted = set(self.chunks)
        return sum(is_chunk(name) and name not in wanted for name in names)


def about_of(chunk: Chunk) -> StudyRecord | None:
    """The state of a study read from its record; None if the record holds something else."""
    try:
        content = chunk.content
        sweeps = tuple(SweepRecord(**sweep) for sweep in content["sweeps"])
        works = tuple(WorkRecord(**work) for work in content.get("works", ()))
        digest, more, cases = content.get("digest", ""), content.get("more", False), content.get("cases")
        held = None if cases is None else SweepRecord(**cases)
        return StudyRecord(content["study"], content["script"], content["samples"], sweeps, digest, works, more, held)
    except (LookupError, TypeError, ValueError):
        return None


def is_chunk(name: str) -> bool:
    """True if a record of that name holds runs of a sweep, from a first to a last, or the answer of a work."""
    return name.count("/") == 2
