"""Ownership: the files of a ledger by their names, and refusals of folders of others and of links."""

from __future__ import annotations

import json
import os
import re
from contextlib import suppress
from pathlib import Path

from workbench.study.ledger.durability import PART

FOLDER, LOCK, END, DAMAGED = "ledger", "lock", ".record", ".damaged"  # below the study's output
_RECORD = re.compile(rf"(about|(?:table|step)\.\w+|\w+\.(?:\d+-\d+|item)\.\w+){END}")
_PART = re.compile(rf".+{END}\.[0-9a-f]+{PART}")
_OURS = re.compile(rf"{LOCK}|{_RECORD.pattern}|{_PART.pattern}|(about|.+\.\w+){DAMAGED}")
LOCK_SIZE = 1000  # bytes of a lock's file that are looked at


class LedgerError(ValueError):
    """The error of a ledger that cannot be read or written; nothing of it is lost."""


def records(folder: Path) -> list[Path]:
    """The files of a folder with the names of records."""
    return sorted(file for file in folder.glob(f"*{END}") if _RECORD.fullmatch(file.name))


def parts(folder: Path) -> list[Path]:
    """The files of a folder that a writer of records has left half written."""
    return [file for file in folder.glob(f"*{PART}") if _PART.fullmatch(file.name)]


def stranger_in(folder: Path) -> str | None:
    """The name of a file from elsewhere in a folder that no ledger was written to; None if there is none."""
    if _is_lock(folder / LOCK):
        return None
    names = sorted(os.listdir(folder)) if folder.is_dir() else []
    return next((name for name in names if not _OURS.fullmatch(name)), None)


def check_owned(out: Path) -> None:
    """Refuse to write a ledger below an output folder through a link, or into a folder that holds something else.

    Raises
    ------
    LedgerError
        If the ledger or its lock is a link, or no ledger was written to the folder and it holds other files.
    """
    refuse_links(out, f"{FOLDER}/{LOCK}")
    if (stranger := stranger_in(out / FOLDER)) is not None:
        raise LedgerError(
            f"The folder '{out / FOLDER}' is no ledger of the workbench: it holds {stranger!r}. Nothing there was "
            "touched: move it, or name another folder with `--out`."
        )


def refuse_links(out: Path, name: str) -> None:
    """Refuse to write to a path below an output folder where a part of the path is a link to another place."""
    path = out
    for part in Path(name).parts:
        path = path / part
        if path.is_symlink():
            raise LedgerError(
                f"'{path}' is a link to another place, and nothing is written or removed through a link: move what "
                "it leads to here, or name another folder."
            )


def _is_lock(file: Path) -> bool:
    with suppress(OSError, ValueError):
        if file.is_file() and not file.is_symlink():
            with file.open("rb") as stream:
                holder = json.loads(stream.read(LOCK_SIZE))
            return isinstance(holder, dict) and {"process", "began"} <= holder.keys()
    return False
