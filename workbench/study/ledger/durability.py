"""Durability: files that are on the disk when a call returns, and a lock that ends with its process."""

from __future__ import annotations

import json
import os
import secrets
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PART = ".part"  # the end of the name of a file that is not yet whole
FAR = 2**30  # where the lock lies in its file: behind what is written there, which others may read


class LockedFolderError(ValueError):
    """The error of a folder that another run is writing."""


def sync(handle: int) -> None:
    """Have on the disk what was written to a file; the `fsync` of macOS ends at the drive's own cache."""
    if sys.platform == "darwin":
        import fcntl

        with suppress(OSError):  # a disk that cannot, as one on a network
            fcntl.fcntl(handle, fcntl.F_FULLFSYNC)
            return
    os.fsync(handle)


def sync_folder(folder: Path) -> None:
    """Make renames and new names last, where the system can open folders."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def make_folder(folder: Path) -> None:
    """Make a folder with all above it, and have their names on the disk."""
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    for path in missing:
        sync_folder(path.parent)


def write_durably(file: Path, content: bytes) -> None:
    """Write a file that is there whole or not at all, and on the disk when this returns."""
    part = file.with_name(f"{file.name}.{secrets.token_hex(4)}{PART}")
    try:
        with part.open("xb") as stream:  # never through a link that stands there
            stream.write(content)
            stream.flush()
            sync(stream.fileno())
        part.replace(file)
        sync_folder(file.parent)
    finally:
        part.unlink(missing_ok=True)


def identity(file: Path) -> tuple[int, int] | None:
    """The device and inode of a file, which stay when it is renamed; None if there is none."""
    try:
        status = file.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino


@contextmanager
def alone(file: Path) -> Iterator[None]:
    """Hold the lock of a file, which is no link, until the process ends; a `LockedFolderError` names another holder."""
    handle = os.open(file, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o644)
    try:
        try:
            _lock(handle)
        except OSError:
            raise LockedFolderError(_holder(file)) from None
        with suppress(OSError):  # on a full disk the lock holds all the same: only its holder goes without a name
            os.ftruncate(handle, 0)
            began = time.strftime("%Y-%m-%d %H:%M:%S %z")
            os.write(handle, json.dumps({"process": os.getpid(), "began": began}).encode())
        yield
    finally:
        os.close(handle)


def _lock(handle: int) -> None:
    if sys.platform == "win32":
        import msvcrt

        os.lseek(handle, FAR, os.SEEK_SET)
        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        os.lseek(handle, 0, os.SEEK_SET)
    else:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _holder(file: Path) -> str:
    try:
        holder = json.loads(file.read_bytes())
        who = f"process {int(holder['process'])}, which began at {str(holder['began'])[:40]}"
    except (OSError, ValueError, LookupError, TypeError):  # it has only just begun
        who = "another process, which has just begun"
    folder = file.parent.parent
    return f"'{folder}' is being written by {who}: wait until it has ended, or name another folder with `--out`."
