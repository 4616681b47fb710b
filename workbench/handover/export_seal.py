"""Seals: a line in each file of an export, with the checksum of all else, so that an edit by hand is seen.

The checksum is the SHA-256 of the file with 64 zeros in its place. So a seal can lie anywhere: in the last line of a
text, in the comment of a ZIP archive, in the head of a MAT file.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import PurePosixPath

MARK = "control-workbench"  # in every file that an export writes
SEAL = f"{MARK} sha256:"
OPEN_SEAL = SEAL + "0" * 64
PATTERN = re.compile(re.escape(SEAL.encode()) + rb"([0-9a-f]{64})")
COMMENTS = {
    **dict.fromkeys((".c", ".h", ".cpp", ".hpp"), "/* {} */"),
    **dict.fromkeys((".py", ".txt", ".yaml"), "# {}"),
    **dict.fromkeys((".xml", ".md"), "<!-- {} -->"),
    ".m": "% {}",
}


def seal(content: bytes) -> bytes:
    """The content with its checksum in the place of the last open seal."""
    at = content.rindex(OPEN_SEAL.encode()) + len(SEAL)
    digest = hashlib.sha256(content).hexdigest().encode()
    return content[:at] + digest + content[at + len(digest) :]


def sealed_text(name: str, text: str) -> bytes:
    """A text file by its name, with a seal in a comment of its language as the last line; in a table in the first."""
    if name.endswith(".csv"):  # whose first line is a comment
        head, *rows = text.split("\n")
        return seal("\n".join([f"{head}; {OPEN_SEAL}", *rows]).encode())
    comment = COMMENTS[PurePosixPath(name).suffix].format(OPEN_SEAL)
    return seal(f"{text.rstrip()}\n{comment}\n".encode())


def is_unchanged(content: bytes) -> bool:
    """True if the content has a seal that holds: an export has written it, and nobody has edited it since."""
    found = [match.start(1) for match in PATTERN.finditer(content)]
    if not found:
        return False
    at = found[-1]
    opened = content[:at] + b"0" * 64 + content[at + 64 :]
    return hashlib.sha256(opened).hexdigest().encode() == content[at : at + 64]
