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
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

from workbench import __version__
from workbench.study.chunk import Chunk, written
from workbench.study.durable import alone, identity, make_folder, sync_folder
from workbench.study.records import SELECT, check_header, connect, insert, is_damage, make_table, remove, scan, whole

FOLDER, DATABASE, LOCK = "ledger", "ledger.sqlite", "lock"  # below the study's output
RENEWED = "renewed.sqlite"  # what was saved from a damaged ledger, before it takes its place
ABOUT = "about"  # the record that says what the others are for
LATER = "The same command goes on from there."


class LedgerError(ValueError):
    """A ledger that cannot be read or written; nothing of it is lost."""


@dataclass(frozen=True, eq=False)
class Ledger:
    """The chunks of one study, open for writing by this process alone.

    Attributes
    ----------
    places
        The row of each whole record by its name.
    identity
        Which file it is, whatever its name.
    remarks
        What was found when it was opened, in sentences.
    """

    out: Path
    connection: sqlite3.Connection
    places: dict[str, int]
    identity: tuple[int, int] | None
    remarks: tuple[str, ...] = ()

    def __contains__(self, name: object) -> bool:
        return name in self.places

    def add(self, chunk: Chunk) -> None:
        """Write a chunk; when this returns, it is on the disk, and in the folder.

        Raises
        ------
        LedgerError
            If it cannot be written, or the file is no longer where it was opened.
        """
        try:
            with self.connection:
                place = insert(self.connection, chunk)
        except sqlite3.Error as error:
            raise _unwritable(self.out, error) from error
        if identity(self.out.resolve() / FOLDER / DATABASE) != self.identity:  # SQLite writes on into what has no name
            raise LedgerError(
                f"The ledger in '{self.out}' was removed, moved or replaced while it was being written: chunks have "
                "nowhere to go. Put the folder back, or let the same command begin anew."
            )
        self.places[chunk.name] = place

    def read(self, name: str) -> Chunk:
        """A chunk, as it was written.

        Raises
        ------
        LedgerError
            If it has been damaged since the ledger was opened.
        """
        row = None
        with suppress(sqlite3.Error):
            row = self.connection.execute(f"{SELECT} WHERE id = ?", (self.places[name],)).fetchone()
        chunk = whole(row[1:]) if row else None
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
                place = insert(self.connection, chunk)
        except sqlite3.Error as error:
            raise _unwritable(self.out, error) from error
        self.places[ABOUT] = place


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
    with ExitStack() as held:
        try:
            make_folder(folder)
            held.enter_context(alone(folder / LOCK))
            if fresh:
                remove(folder / RENEWED)  # first, as it would take the place of the other
                remove(folder / DATABASE)
            ledger = _sound(out, folder)
            held.enter_context(closing(ledger.connection))
        except (sqlite3.Error, OSError) as error:
            raise _unwritable(out, error) from error
        yield ledger


def chunks(out: Path) -> Iterator[Chunk]:
    """The whole records of a ledger, only read, `ABOUT` among them; none if there is no ledger.

    Raises
    ------
    LedgerError
        If the machine, and no damage, keeps it from being read.
    """
    file = out.resolve() / FOLDER / DATABASE
    if not file.is_file() or not file.stat().st_size:
        return
    log = file.with_name(f"{DATABASE}-wal")
    # In a folder that may not be written SQLite makes no index of a log; it reads one that a killed run has left.
    shared = os.access(file.parent, os.W_OK) or (log.exists() and log.stat().st_size > 0)
    options = "mode=ro" if shared else "immutable=1"
    try:
        check_header(file)
        with closing(connect(f"file:{quote(str(file))}?{options}", uri=True)) as ledger:
            yield from (chunk for _, chunk in scan(ledger) if chunk is not None)
    except sqlite3.Error as error:
        if not is_damage(error):
            raise LedgerError(
                f"The ledger in '{out}' cannot be read: {error}. If its folder may not be written, read a copy of it."
            ) from error


def _sound(out: Path, folder: Path) -> Ledger:
    """The ledger below a folder, repaired if need be."""
    file, renewed = folder / DATABASE, folder / RENEWED
    if not file.exists() and renewed.exists():  # a repair was cut off between its last two renames
        _take_place(renewed, file)
    try:
        return _writable(out, file)
    except sqlite3.Error as error:
        if not is_damage(error):
            raise
        reason = str(error)
    aside = next(path for i in range(1, 10**6) if not (path := folder / f"damaged-{i}.sqlite").exists())
    saved = [chunk for chunk in chunks(out) if chunk.name != ABOUT]
    _exchange(file, renewed, aside, saved)
    ledger = _writable(out, file)
    remark = f"The ledger in '{out}' was damaged ({reason}): it is kept as '{aside.name}' beside a new one, "
    remark += f"{len(saved)} whole chunks of it were saved, and the rest is computed again."
    return replace(ledger, remarks=(remark, *ledger.remarks))


def _writable(out: Path, file: Path) -> Ledger:
    """The ledger in a file, verified; an error of SQLite's if the file is damaged."""
    check_header(file)
    connection = connect(str(file))
    try:
        if connection.execute("PRAGMA journal_mode = WAL").fetchone() != ("wal",):
            raise LedgerError(f"The ledger in '{out}' needs a file system with shared memory; this one has none.")
        connection.execute("PRAGMA synchronous = FULL")
        if (found := connection.execute("PRAGMA quick_check(1)").fetchone()) != ("ok",):
            raise sqlite3.DatabaseError(" ".join(str(found[0]).split()))
        make_table(connection)
        places, lost = {}, []
        for row, chunk in scan(connection):
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
    remark = f"Damaged records were found in the ledger of '{out}', {len(lost)} of them; they are computed again."
    return Ledger(out, connection, places, identity(file), (remark,) if lost else ())


def _check_version(out: Path, about: Chunk) -> None:
    if (theirs := about.said.get("workbench")) != __version__:
        raise LedgerError(
            f"The ledger in '{out}' was written by workbench {theirs}, and this is {__version__}: chunks of two "
            "versions do not mix. Run it with that version, name another folder with `--out`, or begin anew with "
            "`--fresh`."
        )


def _exchange(file: Path, renewed: Path, aside: Path, saved: list[Chunk]) -> None:
    """Put the chunks into a new file, the old one aside, and the new one in its place: one of them is always there."""
    remove(renewed)
    with closing(connect(str(renewed))) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        make_table(connection)
        with connection:
            for chunk in saved:
                insert(connection, chunk)
    for end in ("", "-wal"):
        with suppress(FileNotFoundError):
            file.with_name(file.name + end).rename(aside.with_name(aside.name + end))
    _take_place(renewed, file)


def _take_place(renewed: Path, file: Path) -> None:
    """Let a new file be the ledger; a log that is left of the old one would be played into it."""
    remove(file)
    renewed.rename(file)
    sync_folder(file.parent)


def _unwritable(out: Path, error: sqlite3.Error | OSError) -> LedgerError:
    said = error.strerror if isinstance(error, OSError) else str(error)
    return LedgerError(
        f"The ledger in '{out}' cannot be written: {said}. What it holds stays: make room or mend the folder, and the "
        "same command goes on."
    )
