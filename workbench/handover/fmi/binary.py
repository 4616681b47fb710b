"""The shared library of an FMU, compiled where a C compiler is."""

from __future__ import annotations

import platform
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from workbench.core.validation.refusals import describe

COMPILERS = ("cc", "gcc", "clang")
SECONDS = 600  # of one compilation
FLAGS = ("-std=c99", "-O2", "-shared", "-ffp-contract=off", "-fvisibility=hidden")
# The same bytes every time: no number of the build, no table of names.
OF_SYSTEM = {"Linux": ("-fPIC", "-s", "-Wl,--build-id=none"), "Darwin": ("-fPIC",), "Windows": ("-s", "-static-libgcc")}


class Platform(NamedTuple):
    """The folders of a platform in FMI 2.0 and 3.0, and the ending of a library."""

    two: str
    three: str
    ending: str


PLATFORMS = {
    ("Linux", "x86_64"): Platform("linux64", "x86_64-linux", ".so"),
    ("Linux", "aarch64"): Platform("", "aarch64-linux", ".so"),  # FMI 2.0 has no name for it
    ("Darwin", "x86_64"): Platform("darwin64", "x86_64-darwin", ".dylib"),
    ("Darwin", "arm64"): Platform("darwin64", "aarch64-darwin", ".dylib"),
    ("Windows", "AMD64"): Platform("win64", "x86_64-windows", ".dll"),
}


class Library(NamedTuple):
    """The path of a library in the archive and its bytes; or why there is none."""

    path: str
    content: bytes
    reason: str


def library(files: Mapping[str, str], c_files: Sequence[str], identifier: str, version: str, call: str) -> Library:
    """The library of some sources for this platform, or the reason why there is none."""
    here = PLATFORMS.get((platform.system(), platform.machine()), Platform("", "", ""))
    folder = here.two if version == "2.0" else here.three
    if not folder:
        return Library("", b"", f"FMI {version} has no name for this platform")
    if not call:
        return Library("", b"", "no C compiler is here")
    path = f"binaries/{folder}/{identifier}{here.ending}"
    return Library(path, _compiled(files, c_files, call), "")


def compiler_of(compiler: str | None) -> str:
    """The path of a compiler: of the first that is here, or of the one that is named; empty if there is none."""
    if compiler is None:
        return next(filter(None, map(shutil.which, COMPILERS)), "")
    if compiler and shutil.which(compiler) is None:
        raise LookupError(
            f"`fmu(compiler=...)` must be a C compiler on the path, or '' for an FMU of sources alone; got "
            f"{describe(compiler)}."
        )
    return shutil.which(compiler) or ""


def _compiled(files: Mapping[str, str], compiled: Sequence[str], call: str) -> bytes:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in files.items():
            (folder / file).write_text(text, encoding="utf-8")
        command = [call, *FLAGS, *OF_SYSTEM.get(platform.system(), ()), "-o", "library", *compiled]
        try:
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=SECONDS, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise ValueError(f"`fmu(compiler=...)`: the compiler '{call}' did not come to an end: {error}.") from error
        if done.returncode:
            told = next(iter(done.stderr.strip().splitlines()), "nothing").replace(name, ".")
            raise ValueError(f"`fmu(compiler=...)`: '{call}' refuses the sources of the FMU; it says: {told}")
        return (folder / "library").read_bytes()
