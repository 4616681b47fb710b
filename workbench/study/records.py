"""Records in an SQLite file, each with its own digest: what is not what was written counts as absent."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from workbench.study.chunk import Chunk

_COLUMNS = "id INTEGER PRIMARY KEY, name BLOB, head BLOB, data BLOB, digest BLOB"
SELECT = "SELECT id, name, head, data, digest FROM record"

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


def connect(name: str, uri: bool = False) -> sqlite3.Connection:
    """A connection to a file, or to a file with options as a URI; it waits for others that are writing."""
    return sqlite3.connect(name, uri=uri, timeout=30)


def make_table(connection: sqlite3.Connection) -> None:
    """Make the table of records in an empty file; one that has pages and no such table is damaged."""
    tables = [name for (name,) in connection.execute("SELECT name FROM sqlite_master")]
    if not tables and connection.execute("PRAGMA page_count").fetchone()[0] <= 1:
        with connection:
            connection.execute(f"CREATE TABLE record ({_COLUMNS})")
    elif tables != ["record"]:
        raise sqlite3.DatabaseError("it has no table of records")


def check_header(file: Path) -> None:
    """Refuse as damaged what SQLite would take for a file that it may only read, or must not open at all."""
    if not file.exists() or not file.stat().st_size:
        return
    with file.open("rb") as stream:
        header = stream.read(20)
    if header[:16] != b"SQLite format 3\x00" or not set(header[18:20]) <= {1, 2}:
        raise sqlite3.DatabaseError("file is not a database")


def scan(connection: sqlite3.Connection) -> Iterator[tuple[int, Chunk | None]]:
    """Every record by its row; None for one that is not what was written."""
    for row, *parts in connection.execute(SELECT):
        yield row, whole(parts)


def whole(parts: Iterable[Any]) -> Chunk | None:
    """The chunk of a row's name, head, data and digest; None if they do not belong together."""
    parts = tuple(parts)
    if not all(isinstance(part, bytes) for part in parts):
        return None
    name, head, data, digest = parts
    chunk = Chunk(name.decode(errors="replace"), head, data)
    return chunk if chunk.digest == digest else None


def insert(connection: sqlite3.Connection, chunk: Chunk) -> int:
    """Write a chunk within a transaction, and say in which row."""
    values = (chunk.name.encode(), chunk.head, chunk.data, chunk.digest)
    done = connection.execute("INSERT INTO record (name, head, data, digest) VALUES (?, ?, ?, ?)", values)
    assert done.lastrowid is not None
    return done.lastrowid


def remove(file: Path) -> None:
    """Remove a database with its log."""
    for end in ("", "-wal", "-shm"):
        file.with_name(file.name + end).unlink(missing_ok=True)


def is_damage(error: sqlite3.Error) -> bool:
    """Whether the file is the reason of an error, and not the machine."""
    code = getattr(error, "sqlite_errorcode", None)
    return code is None or code == sqlite3.SQLITE_IOERR_SHORT_READ or (code & 0xFF) not in _MACHINE
