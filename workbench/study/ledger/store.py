"""The ledger of a study: a folder of records, each a file of its own, durable before it is acknowledged.

A record whose digest does not match when it is read is computed again.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.study.ledger.answers import has_answer
from workbench.study.ledger.chunk import Chunk, parse_chunk
from workbench.study.ledger.durability import alone, identity, make_folder, write_durably
from workbench.study.ledger.ownership import DAMAGED, END, FOLDER, LOCK, LedgerError, check_owned, parts, records
from workbench.study.ledger.study_record import ABOUT, StudyRecord, SweepRecord, WorkRecord, about_of, is_chunk

# With the names of what a ledger holds and refuses, which stand in files of their own.
__all__ = [
    "ABOUT",
    "FOLDER",
    "LATER",
    "STEP",
    "TABLE",
    "StudyRecord",
    "RunCounter",
    "Ledger",
    "LedgerError",
    "SweepRecord",
    "Task",
    "Tell",
    "WorkRecord",
    "about_in",
    "about_of",
    "chunks",
    "complete",
    "contents",
    "file_of",
    "is_chunk",
    "diverged_count",
    "open_ledger",
    "runs_of",
    "steps_in",
]

TABLE = "table"  # begins the names of tables, which `results` hands on and no run ever reads
STEP = "step"  # begins the names of the steps that pilot runs chose
LATER = "The same command goes on from there."

# Told the runs that are done, those among them that diverged, and all of them.
Tell = Callable[[int, int, int], None]


@dataclass(frozen=True, eq=False)
class Ledger:
    """The records of one study, open for writing by this process alone."""

    out: Path
    names: set[str]  # of all whole records
    lock: tuple[int, int] | None  # the file that was locked, whatever its name is by now
    remarks: tuple[str, ...] = ()  # the faults found when it was opened, in sentences

    @property
    def folder(self) -> Path:
        """The place of the records."""
        return self.out.resolve() / FOLDER

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def write_durably(self, chunk: Chunk) -> None:
        """Write a record, which is on the disk when this returns, if the folder is still the one that was opened."""
        failed = None
        try:
            write_durably(self.folder / file_of(chunk.name), bytes(chunk))
        except OSError as error:
            failed = error
        if identity(self.folder / LOCK) != self.lock:
            raise LedgerError(
                f"The ledger in '{self.out}' was removed, moved or replaced while it was being written: chunks have "
                "nowhere to go. Put the folder back, or let the same command begin anew."
            ) from failed
        if failed is not None:
            raise _unwritable(self.out, failed) from failed
        self.names.add(chunk.name)

    def read(self, name: str) -> Chunk:
        """A record, as it was written, if it has not been damaged since."""
        chunk = _read(self.folder / file_of(name))
        if chunk is None:
            raise LedgerError(
                f"The chunk '{name}' in '{self.out}' has been damaged: the same command computes it again."
            )
        return chunk

    def add(self, chunks: Iterable[Chunk]) -> None:
        """Write the records that are not there yet."""
        for chunk in chunks:
            if chunk.name not in self:
                self.write_durably(chunk)

    def describe(self, about: StudyRecord) -> None:
        """Record how far the study is, if that is not recorded already."""
        if about_in(self.out) != about:
            self.write_durably(about.chunk)

    def drop(self, start: str, exceptions: Container[str] = ()) -> None:
        """Remove the records whose names begin so, but those that are to be kept."""
        for name in [name for name in self.names if name.startswith(f"{start}/") and name not in exceptions]:
            (self.folder / file_of(name)).unlink(missing_ok=True)
            self.names.remove(name)


@contextmanager
def open_ledger(out: Path, fresh: bool = False) -> Iterator[Ledger]:
    """The ledger in an output folder, made if there is none, emptied if `fresh`, and locked against other writers.

    A damaged record is put aside under another name, and counts as absent.

    Raises
    ------
    HeldError
        If another run is writing it.
    LedgerError
        If the folder cannot be written, is a link, or holds files of others.
    """
    folder = out.resolve() / FOLDER
    check_owned(out.resolve())
    with ExitStack() as stack:
        try:
            make_folder(folder)
            stack.enter_context(alone(folder / LOCK))
            for file in (*parts(folder), *((*records(folder), *folder.glob(f"*{DAMAGED}")) if fresh else ())):
                file.unlink()
            names, damaged = set(), 0
            for file in records(folder):
                if (chunk := _read(file)) is not None:
                    names.add(chunk.name)
                    continue
                file.replace(file.with_suffix(DAMAGED))
                damaged += 1
        except OSError as error:
            raise _unwritable(out, error) from error
        remark = (
            f"{damaged} damaged records in the ledger of '{out}' are put aside, and computed again where needed: a "
            "disk has harmed them, or another version of the workbench has written them."
        )
        yield Ledger(out, names, identity(folder / LOCK), (remark,) if damaged else ())


def about_in(out: Path) -> StudyRecord | None:
    """The state of the study in an output folder, as its last run has left it; None if there is none."""
    chunk = _read(out.resolve() / FOLDER / file_of(ABOUT))
    return None if chunk is None else about_of(chunk)


def chunks(out: Path) -> Iterator[Chunk]:
    """The whole records of a ledger, only read; none if there is no ledger."""
    try:
        yield from filter(None, map(_read, records(out.resolve() / FOLDER)))
    except OSError as error:
        raise LedgerError(f"The ledger in '{out}' cannot be read: {error.strerror}.") from error


def steps_in(out: Path) -> Iterator[Chunk]:
    """The records of chosen steps in an output folder; none if there are none."""
    yield from filter(None, map(_read, sorted((out.resolve() / FOLDER).glob(f"{STEP}.*{END}"))))


def contents(out: Path) -> tuple[dict[str, Chunk], StudyRecord]:
    """The whole records of a ledger by name, only read, and the state of the study; a `LookupError` without one."""
    if not out.is_dir():
        raise LookupError(f"There is no folder '{out}': name the one that `workbench run` has written.")
    held = {chunk.name: chunk for chunk in chunks(out)}
    about = about_of(held[ABOUT]) if ABOUT in held else None
    if about is None:
        raise LookupError(
            f"There is no ledger in '{out}', or its head is damaged or of another version: a study has one as soon as "
            "it runs, and `workbench run STUDY --out DIR` mends it."
        )
    return held, about


def file_of(name: str) -> str:
    """The name of a record's file."""
    return f"{name.replace('/', '.')}{END}"


def _read(file: Path) -> Chunk | None:
    """The record of a file; None if there is none that is whole, and the file's own."""
    with suppress(FileNotFoundError):  # another process may just have removed it
        if file.is_file():  # to open a pipe would wait for its writer
            chunk = parse_chunk(file.read_bytes())
            if chunk is not None and file_of(chunk.name) == file.name:
                return chunk
    return None


def _unwritable(out: Path, error: OSError) -> LedgerError:
    return LedgerError(
        f"The ledger in '{out}' cannot be written: {error.strerror}. What it holds stays: make room or mend the "
        "folder, and the same command goes on."
    )


class Task(NamedTuple):
    """A chunk to be computed: the number of its sweep, its first run and that behind its last, and its name."""

    sweep: int
    first: int
    last: int
    name: str


class RunCounter:
    """The counter of runs done, of those that diverged, and of all; `begin` makes the function that is told."""

    def __init__(self, total: int = 0, begin: Callable[[], Tell] = lambda: lambda done, failed, total: None) -> None:
        self.done, self.failed, self.total = 0, 0, total
        self._begin = begin
        self._tell: Tell | None = None

    def add(self, chunk: Chunk) -> None:
        """Count the runs of a chunk."""
        self.done, self.failed = self.done + runs_of(chunk), self.failed + diverged_count(chunk)

    def tell(self) -> None:
        """Tell how far the runs are."""
        self._tell = self._tell or self._begin()
        self._tell(self.done, self.failed, self.total)


def complete(
    tasks: Sequence[Task],
    ledger: Ledger,
    execute: Callable[[Sequence[Task]], Iterator[Chunk]],
    counter: RunCounter | None = None,
    acknowledge: Callable[[Chunk], None] = lambda chunk: None,
) -> None:
    """Compute the tasks that the ledger lacks, in any order; a chunk is acknowledged once it is on the disk."""
    counter = counter or RunCounter()
    missing = {task.name: task for task in tasks if task.name not in ledger}
    for task in tasks:
        if task.name in ledger:
            counter.add(ledger.read(task.name))
    if not missing:
        return
    counter.tell()
    for chunk in execute(tuple(missing.values())):
        if missing.pop(chunk.name, None) is None:  # computed twice: the first is kept, as both have the same bits
            continue
        ledger.write_durably(chunk)
        acknowledge(chunk)
        counter.add(chunk)
        counter.tell()
    if missing:
        raise ValueError(f"{len(missing)} chunks were asked for and never came, such as '{next(iter(missing))}'.")


def runs_of(chunk: Chunk) -> int:
    """The number of runs in a chunk; the answer of a work counts for one."""
    return 1 if has_answer(chunk) else int(np.size(chunk.arrays().get("diverged_at", ())))


def diverged_count(chunk: Chunk) -> int:
    """The number of runs in a chunk that diverged."""
    return int(np.isfinite(chunk.arrays().get("diverged_at", np.nan)).sum())
