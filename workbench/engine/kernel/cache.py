"""The disk cache: the machine code of kernels, each under a key that names all it depends on.

A file is a header, with the key and the code's hash, and the code. One that is damaged, cut off or not our own is
compiled anew, and no fault of the disk is an error. As the code is executed, the folder must belong to the user and be
writable for nobody else. `WORKBENCH_CACHE` names another folder, or is "off".
"""

from __future__ import annotations

import hashlib
import os
import re
import stat
import struct
import sys
import time
from contextlib import suppress
from pathlib import Path

LARGEST = 256 * 2**20  # bytes of all kernels; beyond, those that were not used for longest go
ABANDONED_AGE = 24 * 3600.0  # seconds after which a file that is still being written has lost its writer

FORMAT = b"workbench kernel 1\n"  # counts up when the header or the meaning of a key changes
HEADER = struct.Struct(f"<{len(FORMAT)}s32sQ32s")  # format, key, length and hash of the code
KERNEL = re.compile(r"[0-9a-f]{64}\.kernel")
PART = re.compile(r"[0-9a-f]{64}\.[0-9a-f]{16}\.part")


def key(*parts: str) -> str:
    """The SHA-256 of the format and of some texts, each with its length."""
    digest = hashlib.sha256(FORMAT)
    for part in parts:
        text = part.encode()
        digest.update(len(text).to_bytes(8, "little") + text)
    return digest.hexdigest()


def folder() -> Path | None:
    """The folder of the kernels, made if there is none; None if none may be used."""
    named = os.environ.get("WORKBENCH_CACHE", "")
    if named.lower() == "off":
        return None
    try:
        place = Path(named).expanduser() if named else _of_the_user() / "control-workbench" / "kernels"
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        return place if _private(place.stat()) else None
    except (OSError, RuntimeError):  # a RuntimeError is a home that nobody can name
        return None


def load(key: str) -> bytes | None:
    """The code under a key, or None if the cache has no complete file of this user for it."""
    place = folder()
    if place is None:
        return None
    file = place / f"{key}.kernel"
    try:
        with open(file, "rb", opener=_at_once) as stream:
            # the file itself is asked too, as the folder could have been exchanged since it was looked at
            status = os.fstat(stream.fileno())
            usable = stat.S_ISREG(status.st_mode) and _private(status) and status.st_size <= LARGEST
            content = stream.read() if usable else b""
    except OSError:
        return None
    code = content[HEADER.size :]
    if content[: HEADER.size] != _header(key, code):
        return None
    with suppress(OSError):  # a folder that is only read
        os.utime(file)
    return code


def store(key: str, code: bytes) -> None:
    """Store the code under a key, so that a concurrent reader finds all of it or nothing."""
    place = folder()
    if place is None:
        return
    part = place / f"{key}.{os.urandom(8).hex()}.part"
    with suppress(OSError):
        try:
            # not forced to the disk: a file that a power failure cut off does not match its header
            with open(part, "xb", opener=lambda path, flags: os.open(path, flags, 0o600)) as stream:
                stream.write(_header(key, code) + code)
            os.replace(part, place / f"{key}.kernel")
        finally:
            part.unlink(missing_ok=True)
        if key.startswith("0"):  # one store in sixteen: a look at thousands of files takes as long as a small kernel
            _tidy(place)


def _of_the_user() -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    named = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return named if named.is_absolute() else Path.home() / ".cache"


def _private(status: os.stat_result) -> bool:
    """True if only this user can have written the file; always on Windows, which has access lists of its own."""
    return os.name != "posix" or (status.st_uid == os.geteuid() and not status.st_mode & 0o022)


def _at_once(path: str, flags: int) -> int:
    """Open a file for reading without waiting, as for a named pipe without a writer."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _header(key: str, code: bytes) -> bytes:
    return HEADER.pack(FORMAT, bytes.fromhex(key), len(code), hashlib.sha256(code).digest())


def _tidy(place: Path) -> None:
    """Remove half-written files, and the least recently used kernels until the rest fits."""
    now, kernels = time.time(), []
    with os.scandir(place) as entries:
        for entry in entries:
            with suppress(OSError):  # another process may have removed it
                if KERNEL.fullmatch(entry.name):
                    status = entry.stat()
                    kernels.append((status.st_mtime, status.st_size, entry.path))
                elif PART.fullmatch(entry.name) and now - entry.stat().st_mtime > ABANDONED_AGE:
                    os.unlink(entry.path)
    excess = sum(size for _, size, _ in kernels) - LARGEST
    for _, size, path in sorted(kernels):
        if excess <= 0:
            break
        with suppress(OSError):
            os.unlink(path)
            excess -= size
