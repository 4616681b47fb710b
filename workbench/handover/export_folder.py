"""Files of an export: all of them or none, and never over a file of somebody else's, or one that was edited."""

from __future__ import annotations

import os
import secrets
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from workbench.core.validation.places import other_kind
from workbench.core.validation.refusals import describe, refusal, require
from workbench.handover.export_seal import MARK, is_unchanged, sealed_text

LARGEST = 2**28  # bytes of a file that is looked at before it is replaced: no export is so large


def write_files(folder: str | Path, files: Mapping[str, str | bytes], overwrite: bool = False) -> Path:
    """Write files by their paths below a folder, which is made; earlier exports are replaced while nobody edited them.

    A text gets a seal as its last line; bytes have one already.

    Parameters
    ----------
    overwrite
        True to replace any file of a disk that has the name of one of these.

    Raises
    ------
    ValueError
        If a file is there that no export has written or that was edited since, or what is there is no file; or if one
        cannot be written. Then nothing is changed.
    """
    require("export(overwrite=...)", overwrite, bool)
    if (
        not isinstance(folder, str | Path)
        or "\0" in str(folder)
        or (os.path.exists(folder) and not os.path.isdir(folder))
    ):
        raise refusal("export(folder=...)", "the path of a folder, or of a folder to be made", str(folder))
    target = Path(folder)
    contents = {name: sealed_text(name, text) if isinstance(text, str) else text for name, text in files.items()}
    drafts: dict[Path, Path] = {}
    try:
        for name in contents:
            _refuse_other(target / name, overwrite)
        for name, content in contents.items():
            path = target / name
            path.parent.mkdir(parents=True, exist_ok=True)
            drafts[path] = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
            drafts[path].write_bytes(content)
        for path, draft in drafts.items():
            os.replace(draft, path)
    except OSError as error:
        raise ValueError(
            f"The export cannot go to {describe(str(folder))}: {error.strerror or error}. Name one that you may write."
        ) from error
    finally:
        for draft in drafts.values():
            with suppress(OSError):
                draft.unlink()
    return target


def _refuse_other(path: Path, overwrite: bool) -> None:
    """Refuse to replace what is no file, and a file whose seal is missing or broken unless it may be overwritten."""
    if kind := other_kind(path, follow=False):
        raise ValueError(f"The export would write '{path}', which is {kind}. Name another place.")
    if overwrite or not path.exists():
        return
    content = path.read_bytes() if path.stat().st_size <= LARGEST else b""
    if is_unchanged(content):
        return
    ours = "was changed since an export wrote it" if MARK.encode() in content else "was not written by an export"
    raise ValueError(
        f"'{path}' {ours}; it stays unchanged. Name another folder or another name for the law, or say "
        "`overwrite=True` (`--overwrite`) to replace it."
    )
