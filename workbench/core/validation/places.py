"""Places of files: what stands at a path before something is written there."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from workbench.core.validation.signatures import check_arguments

KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFLNK: "a symbolic link",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


@check_arguments
def other_kind(path: str | Path, *, follow: bool = True) -> str:
    """The kind of what stands at a path and is no file of a disk, as 'a named pipe'; empty for a file, or for nothing.

    The path is not opened: a named pipe would wait for its other end. Unless `follow`, a symbolic link is a kind.
    """
    try:
        mode = os.stat(path, follow_symlinks=follow).st_mode
    except (OSError, ValueError):  # the second for a path that no system has
        return ""
    return "" if stat.S_ISREG(mode) else KINDS.get(stat.S_IFMT(mode), "no file")
