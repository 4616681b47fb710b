"""The ledger of a study: what was computed, in one SQLite file, durable before it is acknowledged.

Every record carries its own digest, which is compared whenever the record is read: what does not match
is not there. So damage costs computing time and never a wrong number. A record is acknowledged only
after its transaction is on the disk (write-ahead log, synchronous FULL).

References
----------
SQLite documentation, "Write-Ahead Logging" and "PRAGMA synchronous".
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from workbench import __version__
from workbench.study.chunk import Chunk, written
from workbench.study.durable import alone, make_folder, sync_folder

FOLDER, DATABASE, LOCK = "ledger", "ledger.sqlite", "lock"  # below the study's output
RENEWED = "renewed.sqlite"  # what was saved from a damaged ledger, before it takes its place
ABOUT = "about"  # the record that says what the others are for
LATER = "The same command goes on from there."

# Of these the machine is the reason, not the file.
_MACHINE = {
    sqlite3.SQLITE_READONLY,
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_IOERR,
    sqlite3.SQLITE_CANTOPEN,
    sqlite3.SQLITE_BUSY,
    sqlite3.SQLITE_LOCKED,
    sqlite3.SQLITE_NOMEM,
    sqlite3.SQLITE_PERM,
}


class LedgerError(ValueError):
    """A ledger that cannot be read or written; nothing of it is lost."""


@dataclass(frozen=True, eq=False)
class Ledger:
    """The chunks of one study, open for writing by this process alone.

    Attributes
    ----------
    places
        The row of each whole record by its name.
    remarks
        What was found when it was opened, in sentences.
    """

    out: Path
    connection: sqlite3.Connection
    places: dict[str, int]
    remarks: tuple[str, ...] = ()

    def __contains__(self, name: object) -> bool:
        return name in self.places

    def add(self, chunk: Chunk) -> None:
        """Write a chunk; when this returns, it is on the disk."""
        try:
            with self.connection:
                self.places[chunk.name] = _insert(self.connection, chunk)
        except sqlite3.Error as error:
            raise _unwritable(self.out, error) from error

    def read(self, name: str) -> Chunk:
        """A chunk, as it was written.

        Raises
        ------
        LedgerError
            If it has been damaged since the ledger was opened.
        """
        row = None
        with suppress(sqlite3.Error):
            row = self.connection.execute(f"{_SELECT} WHERE id = ?", (self.places[name],)).fetchone()
        chunk = _whole(row[1:]) if row else None
        if chunk is None or chunk.name != name:
            raise LedgerError(
                f"The chunk '{name}' in '{self.out}' has been damaged: the same command computes it again."
            )
        return chunk

    def describe(self, about: dict[str, Any]) -> None:
        """Say what the chunks are for, in plain data, if it is not what is said already."""
        chunk = Chunk(ABOUT, written({"workbench": __version__, **about}))
        if ABOUT in self and self.read(ABOUT) == chunk:
            return
        try:
            with self.connection:
                self.connection.execute("DELETE FROM record WHERE id = ?", (self.places.get(ABOUT, -1),))
                self.places[ABOUT] = _insert(self.connection, chunk)
        except sqlite3.Error as error:
            raise _unwritable(self.out, error) from error


@contextmanager
def opened(out: Path, fresh: bool = False) -> Iterator[Ledger]:
    """The ledger in an output folder, made if there is none, emptied if `fresh`; nobody else writes it meanwhile.

    Damaged records are taken out. A database that is damaged itself is put aside, and what is whole in it
    is saved; `remarks` says both.

    Raises
    ------
    HeldError
        If another run is writing it; the message names its process.
    LedgerError
        If it is of another version, or the folder cannot be written.
    """
    folder = out.resolve() / FOLDER
    try:
        make_folder(folder)
        with alone(folder / LOCK):
            if fresh:
                _remove(folder / DATABASE)
            ledger = _sound(out, folder)
            with closing(ledger.connection):
                yield ledger
    except sqlite3.Error as error:
        raise _unwritable(out, error) from error
    except (PermissionError, NotADirectoryError, FileExistsError) as error:
        raise LedgerError(f"The ledger in '{out}' cannot be written: {error.strerror}. Name another folder.") from error


def chunks(out: Path) -> Iterator[Chunk]:
    """The whole records of a ledger, only read, `ABOUT` among them; none if there is no ledger."""
    file = out.resolve() / FOLDER / DATABASE
    if not file.is_file() or not file.stat().st_size:
        return
    writable = "" if _may_write(file.parent) else "&immutable=1"
    with suppress(sqlite3.Error), closing(_connect(f"file:{quote(str(file))}?mode=ro{writable}", uri=True)) as ledger:
        yield from (chunk for _, chunk in _scan(ledger) if chunk is not None)


_COLUMNS = "id INTEGER PRIMARY KEY, name BLOB, head BLOB, data BLOB, digest BLOB"
_SELECT = "SELECT id, name, head, data, digest FROM record"


def _may_write(folder: Path) -> bool:
    return os.access(folder, os.W_OK)


def _connect(name: str, uri: bool = False) -> sqlite3.Connection:
    return sqlite3.connect(name, uri=uri, timeout=30)


def _sound(out: Path, folder: Path) -> Ledger:
    """The ledger below a folder, repaired if need be."""
    file, renewed = folder / DATABASE, folder / RENEWED
    if not file.exists() and renewed.exists():  # a repair was cut off between its last two renames
        renewed.rename(file)
    try:
        return _writable(out, file)
    except sqlite3.Error as error:
        if not _is_damage(error):
            raise
        reason = str(error)
    aside = next(path for i in range(1, 10**6) if not (path := folder / f"damaged-{i}.sqlite").exists())
    saved = [chunk for chunk in chunks(out) if chunk.name != ABOUT]
    _exchange(file, renewed, aside, saved)
    ledger = _writable(out, file)
    remark = f"The ledger in '{out}' was damaged ({reason}): it is kept as '{aside.name}' beside a new one, "
    remark += f"{len(saved)} whole chunks of it were saved, and the rest is computed again."
    return Ledger(out, ledger.connection, ledger.places, (remark, *ledger.remarks))


def _writable(out: Path, file: Path) -> Ledger:
    """The ledger in a file, verified; an error of SQLite's if the file is damaged."""
    _check_header(file)
    connection = _connect(str(file))
    try:
        if connection.execute("PRAGMA journal_mode = WAL").fetchone() != ("wal",):
            raise LedgerError(f"The ledger in '{out}' needs a file system with shared memory; this one has none.")
        connection.execute("PRAGMA synchronous = FULL")
        if (found := connection.execute("PRAGMA quick_check(1)").fetchone()) != ("ok",):
            raise sqlite3.DatabaseError(" ".join(str(found[0]).split()))
        _make_table(connection)
        places, lost = {}, []
        for row, chunk in _scan(connection):
            if chunk is None or chunk.name in places:
                lost.append(row)
                continue
            places[chunk.name] = row
            if chunk.name == ABOUT:
                _check_version(out, chunk)
        if lost:
            with connection:
                connection.executemany("DELETE FROM record WHERE id = ?", [(row,) for row in lost])
    except BaseException:
        connection.close()
        raise
    remark = f"{len(lost)} damaged records were found in the ledger of '{out}'; what they held is computed again."
    return Ledger(out, connection, places, (remark,) if lost else ())


def _make_table(connection: sqlite3.Connection) -> None:
    """Only in an empty file: one that has pages and no such table is damaged."""
    tables = [name for (name,) in connection.execute("SELECT name FROM sqlite_master")]
    if not tables and connection.execute("PRAGMA page_count").fetchone()[0] <= 1:
        with connection:
            connection.execute(
                "CREATE TABLE record (id INTEGER PRIMARY KEY, name BLOB, head BLOB, data BLOB, digest BLOB)"
            )
    elif tables != ["record"]:
        raise sqlite3.DatabaseError("it has no table of records")


def _check_header(file: Path) -> None:
    """What SQLite would take for a file that it may only read, or must not open at all."""
    if not file.exists() or not file.stat().st_size:
        return
    with file.open("rb") as stream:
        header = stream.read(20)
    if header[:16] != b"SQLite format 3\x00" or not set(header[18:20]) <= {1, 2}:
        raise sqlite3.DatabaseError("file is not a database")


def _check_version(out: Path, about: Chunk) -> None:
    if (theirs := about.said.get("workbench")) != __version__:
        raise LedgerError(
            f"The ledger in '{out}' was written by workbench {theirs}, and this is {__version__}: chunks of two "
            "versions do not mix. Run it with that version, name another folder with `--out`, or begin anew with "
            "`--fresh`."
        )


def _scan(connection: sqlite3.Connection) -> Iterator[tuple[int, Chunk | None]]:
    """Every record by its row; None for one that is not what was written."""
    for row, *parts in connection.execute(_SELECT):
        yield row, _whole(parts)


def _whole(parts: Iterable[Any]) -> Chunk | None:
    parts = tuple(parts)
    if not all(isinstance(part, bytes) for part in parts):
        return None
    name, head, data, digest = parts
    chunk = Chunk(name.decode(errors="replace"), head, data)
    return chunk if chunk.digest == digest else None


def _insert(connection: sqlite3.Connection, chunk: Chunk) -> int:
    values = (chunk.name.encode(), chunk.head, chunk.data, chunk.digest)
    done = connection.execute("INSERT INTO record (name, head, data, digest) VALUES (?, ?, ?, ?)", values)
    assert done.lastrowid is not None
    return done.lastrowid


def _exchange(file: Path, renewed: Path, aside: Path, saved: list[Chunk]) -> None:
    """Put the chunks into a new file, the old one aside, and the new one in its place; at no time is there none."""
    _remove(renewed)
    with closing(_connect(str(renewed))) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        _make_table(connection)
        with connection:
            for chunk in saved:
                _insert(connection, chunk)
    for end in ("-wal", "-shm", ""):
        with suppress(FileNotFoundError):
            file.with_name(file.name + end).rename(aside.with_name(aside.name + end))
    renewed.rename(file)
    sync_folder(file.parent)


def _remove(file: Path) -> None:
    for end in ("", "-wal", "-shm"):
        file.with_name(file.name + end).unlink(missing_ok=True)


def _is_damage(error: sqlite3.Error) -> bool:
    code = getattr(error, "sqlite_errorcode", None)
    return code is None or code == sqlite3.SQLITE_IOERR_SHORT_READ or (code & 0xFF) not in _MACHINE


def _unwritable(out: Path, error: sqlite3.Error) -> LedgerError:
    return LedgerError(
        f"The ledger in '{out}' cannot be written: {error}. What it holds stays: make room or mend the folder, and the "
        "same command goes on."
    )
