"""The programs that targets need, with the Debian packages that hold them, and their runs."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

PACKAGES: Mapping[str, tuple[str, ...]] = {
    "gcc": ("gcc", "libc6-dev"),
    "clang": ("clang",),
    "aarch64-linux-gnu-gcc": ("gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross"),
    "qemu-aarch64": ("qemu-user",),
    "arm-none-eabi-gcc": ("gcc-arm-none-eabi", "libnewlib-arm-none-eabi"),
    "qemu-system-arm": ("qemu-system-arm",),
    "valgrind": ("valgrind",),
    "node": ("nodejs",),
    "cppcheck": ("cppcheck",),
}


class TargetError(Exception):
    """A target did not run, with the reason in one sentence."""


def there(program: str) -> bool:
    """True if this machine has the program."""
    return shutil.which(program) is not None


def missing_programs(programs: Sequence[str]) -> str:
    """The programs that this machine lacks, with the command that installs them; empty if it has all."""
    absent = [program for program in programs if not there(program)]
    packages = [package for program in absent for package in PACKAGES[program]]
    return f"install {' and '.join(absent)} with `apt-get install {' '.join(packages)}`" if absent else ""


def run(command: Sequence[str], folder: Path, seconds: float) -> str:
    """The output of a program that runs in a folder, and is ended after so many seconds.

    Raises
    ------
    TargetError
        If it cannot be started, fails, or takes longer.
    """
    words = {**os.environ, "LC_ALL": "C"}
    try:
        end = subprocess.run(
            command, cwd=folder, env=words, capture_output=True, timeout=seconds, check=False, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired:
        raise TargetError(f"{command[0]} took longer than {seconds:g} s") from None
    except OSError as error:
        raise TargetError(f"{command[0]} cannot be started: {error.strerror}") from error
    if end.returncode:
        lines = (end.stderr + end.stdout).decode(errors="replace").strip().splitlines()
        last = lines[-1] if lines else "no message"
        told = next((line for line in lines if "error" in line or "fatal" in line), last)
        raise TargetError(f"{command[0]} ended with status {end.returncode}: {told}")
    return end.stdout.decode(errors="replace")
