"""The ledger of a study: a folder of records, each a file of its own, durable before it is acknowledged.

A record holds its own digest, which is compared whenever it is read: a file that does not match is not
there. So damage costs the computing time of the records that it hit, and never a wrong number.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from workbench.study.ledger import about
from workbench.study.ledger.about import About, about_of
from workbench.study.ledger.chunk import Chunk, parsed
from workbench.study.ledger.durable import PART, alone, identity, make_folder, write_whole

FOLDER, LOCK, END, DAMAGED = "ledger", "lock", ".record", ".damaged"  # below the study's output
TABLE = "table"  # begins the names of tables, which `results` hands on and no run ever reads
LATER = "The same command goes on from there."


class LedgerError(ValueError):
    """A ledger that cannot be read or written; nothing of it is lost."""


@dataclass(frozen=True, eq=False)
class Ledger:
    """The records of one study, open for writing by this process alone.

    Attributes
    ----------
    names
        Those of all whole records.
    lock
        The file that was locked, whatever its name is by now.
    remarks
        What was found when it was opened, in sentences.
    """

    out: Path
    names: set[str]
    lock: tuple[int, int] | None
    remarks: tuple[str, ...] = ()

    @property
    def folder(self) -> Path:
        """The place of the records."""
        return self.out.resolve() / FOLDER

    def __contains__(self, name: object) -> bool:
        return name in self.names

    @property
    def about(self) -> About | None:
        """The state of the study, as the last run has left it."""
        chunk = _read(self.folder / file_of(about.NAME))
        return None if chunk is None else about_of(chunk)

    def add(self, chunk: Chunk) -> None:
        """Write a record; when this returns, it is on the disk, and in the folder.

        Raises
        ------
        LedgerError
            If it cannot be written, or the folder is no longer the one that was opened.
        """
        failed = None
        try:
            write_whole(self.folder / file_of(chunk.name), bytes(chunk))
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
        """A record, as it was written.

        Raises
        ------
        LedgerError
            If it has been damaged since the ledger was opened.
        """
        chunk = _read(self.folder / file_of(name))
        if chunk is None:
            raise LedgerError(
                f"The chunk '{name}' in '{self.out}' has been damaged: the same command computes it again."
            )
        return chunk

    def describe(self, said: About) -> None:
        """Say how far the study is, if that is not what is said already."""
        if self.about != said:
            self.add(said.chunk)

    def drop_tables(self) -> None:
        """Remove the tables of an earlier run."""
        for name in [name for name in self.names if name.startswith(f"{TABLE}/")]:
            (self.folder / file_of(name)).unlink(missing_ok=True)
            self.names.remove(name)


@contextmanager
def opened(out: Path, fresh: bool = False) -> Iterator[Ledger]:
    """The ledger in an output folder, made if there is none, emptied if `fresh`; nobody else writes it meanwhile.

    A damaged record is put aside under another name, and counts as absent.

    Raises
    ------
    HeldError
        If another run is writing it; the message names its process.
    LedgerError
        If the folder cannot be written.
    """
    folder = out.resolve() / FOLDER
    with ExitStack() as held:
        try:
            make_folder(folder)
            held.enter_context(alone(folder / LOCK))
            for pattern in (f"*{PART}", *((f"*{END}", f"*{DAMAGED}") if fresh else ())):
                for file in folder.glob(pattern):
                    file.unlink()
            names, damaged = set(), 0
            for file in _files(folder):
                if (chunk := _read(file)) is not None:
                    names.add(chunk.name)
                    continue
                file.replace(file.with_suffix(DAMAGED))
                damaged += 1
        except OSError as error:
            raise _unwritable(out, error) from error
        remark = f"{damaged} damaged records in the ledger of '{out}' are put aside, and computed again where needed."
        yield Ledger(out, names, identity(folder / LOCK), (remark,) if damaged else ())


def chunks(out: Path) -> Iterator[Chunk]:
    """The whole records of a ledger, only read; none if there is no ledger.

    Raises
    ------
    LedgerError
        If the machine, and no damage, keeps it from being read.
    """
    folder = out.resolve() / FOLDER
    try:
        yield from filter(None, map(_read, _files(folder)))
    except OSError as error:
        raise LedgerError(f"The ledger in '{out}' cannot be read: {error.strerror}.") from error


def is_chunk(name: str) -> bool:
    """Whether a record of that name holds runs: of a sweep, from a first to a last, under a digest."""
    return name.count("/") == 2


def file_of(name: str) -> str:
    """The name of a record's file."""
    return f"{name.replace('/', '.')}{END}"


def _files(folder: Path) -> list[Path]:
    return sorted(folder.glob(f"*{END}"))


def _read(file: Path) -> Chunk | None:
    """The record of a file; None if there is none that is whole, and the file's own."""
    with suppress(FileNotFoundError):  # another process may just have removed it
        if file.is_file():  # to open a pipe would wait for its writer
            chunk = parsed(file.read_bytes())
            if chunk is not None and file_of(chunk.name) == file.name:
                return chunk
    return None


def _unwritable(out: Path, error: OSError) -> LedgerError:
    return LedgerError(
        f"The ledger in '{out}' cannot be written: {error.strerror}. What it holds stays: make room or mend the "
        "folder, and the same command goes on."
    )
