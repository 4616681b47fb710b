"""`python -m tests.exams DIR [-v]`: one line an exam; exit 1 if a bar is missed, 2 if there is no exam."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .graders import find
from .sitter import sit


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.exams", description="Sit every exam found below a folder.")
    parser.add_argument("folder", type=Path, metavar="DIR", help="the folder of the exams")
    parser.add_argument("-v", "--verbose", action="store_true", help="show the graders' own lines too")
    asked = parser.parse_args(words)
    if not asked.folder.is_dir():
        there = f"'{asked.folder}' is a file" if asked.folder.exists() else f"There is no folder '{asked.folder}'"
        sys.stderr.write(f"{there}: name the folder that holds the exams.\n")
        return 2
    missed = 0
    for verdict in sit(asked.folder):
        if asked.verbose:
            sys.stdout.write(verdict.printed)
        sys.stdout.write(f"{verdict.line}\n")
        sys.stdout.flush()
        missed += verdict.passed is False
    if not find(asked.folder):
        sys.stderr.write(f"There is no exam below '{asked.folder}'.\n")
        return 2
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
