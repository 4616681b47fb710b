"""Files of an export: all of them or none, and never over a file of somebody else's."""

from __future__ import annotations

import os
import secrets
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from workbench.validation.refusals import described, refusal

MARK = "control-workbench"  # in every file that an export writes


def write_files(folder: str | Path, files: Mapping[str, str | bytes]) -> Path:
    """Write files by their paths below a folder, which is made; earlier exports are replaced.

    Raises
    ------
    ValueError
        If a file is there that no export has written, or one cannot be written; then nothing is changed.
    """
    if not isinstance(folder, str | Path) or "\0" in str(folder) or os.path.isfile(folder):
        raise refusal("export(folder=...)", "the path of a folder, or of none yet", str(folder))
    target = Path(folder)
    contents = {name: text.encode() if isinstance(text, str) else text for name, text in files.items()}
    drafts: dict[Path, Path] = {}
    try:
        for name in contents:
            _refuse_other(target / name)
        for name, content in contents.items():
            path = target / name
            path.parent.mkdir(parents=True, exist_ok=True)
            drafts[path] = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
            drafts[path].write_bytes(content)
        for path, draft in drafts.items():
            os.replace(draft, path)
    except OSError as error:
        raise ValueError(
            f"The export cannot go to {described(str(folder))}: {error.strerror or error}. Name one that you may write."
        ) from error
    finally:
        for draft in drafts.values():
            with suppress(OSError):
                draft.unlink()
    return target


def _refuse_other(path: Path) -> None:
    """Refuse to replace a file that has no mark of an export."""
    if path.is_dir():
        raise ValueError(f"The export would write '{path}', which is a folder. Name another place.")
    if path.exists() and MARK.encode() not in path.read_bytes():
        raise ValueError(
            f"'{path}' was not written by an export, and is left as it is. Name another folder, or another name for "
            "the law."
        )
