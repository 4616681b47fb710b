"""Sizes of a compiled law: the stack of its longest chain of calls, and the bytes of code and of data."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from workbench.handover.c99.c_files import CCode
from workbench.handover.targets.external_programs import TargetError, run, there

SECONDS = 60.0  # of one call of the compiler
NODE = re.compile(r'node: \{ title: "([^"]*)" label: "([^"]*)"')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]*)" targetname: "([^"]*)"')
BYTES = re.compile(r"(\d+) bytes \(([\w,]+)\)")


def deepest(file: Path, function: str) -> int | None:
    """The bytes of stack of a function and of those that it calls, along the deepest chain; None if not known.

    The file is that of GCC's `-fcallgraph-info=su`. Routines of the compiler's own library, as those of doubles on a
    processor that has none, are no part of it, and count nothing. A recursion or a frame of no fixed size has no bound.
    """
    text = file.read_text(encoding="utf-8", errors="replace")
    frames, calls = dict[str, int | None](), dict[str, list[str]]()
    for title, label in NODE.findall(text):
        size = BYTES.search(label)
        frames[title] = (int(size[1]) if size[2] != "dynamic" else None) if size else 0
    for source, target in EDGE.findall(text):
        calls.setdefault(source, []).append(target)
    start = next((title for title in frames if title.rpartition(":")[2] == function), None)
    return None if start is None else _chain(start, frames, calls, ())


def _chain(
    title: str, frames: Mapping[str, int | None], calls: Mapping[str, list[str]], above: tuple[str, ...]
) -> int | None:
    frame = frames.get(title, 0)
    if frame is None or title in above:
        return None
    below = [_chain(name, frames, calls, (*above, title)) for name in calls.get(title, [])]
    depths = [depth for depth in below if depth is not None]
    return frame + max(depths, default=0) if len(depths) == len(below) else None


def measured_stack(code: CCode, option: str = "-O2") -> str:
    """The stack of a call in words, as GCC here lays it out; empty where there is no GCC, or no bound."""
    if not there("gcc"):
        return ""
    try:
        with TemporaryDirectory(prefix="workbench-") as place:
            folder = Path(place)
            for name, text in code.files.items():
                (folder / name).write_text(text, encoding="utf-8")
            run(["gcc", "-std=c99", option, "-fcallgraph-info=su", "-c", f"{code.name}.c"], folder, SECONDS)
            depth = deepest(folder / f"{code.name}.ci", f"{code.name}_step")
            machine = run(["gcc", "-dumpmachine"], folder, SECONDS).strip()
            version = run(["gcc", "-dumpfullversion"], folder, SECONDS).strip()
    except (TargetError, OSError):  # of an old GCC, or a folder that is full
        return ""
    return "" if depth is None else f"{depth} bytes, measured: as gcc {version} {option} lays it out for {machine}"


def code_and_data(listing: str) -> tuple[int, int]:
    """The bytes of code with constants, and of data that changes, from what `size` lists of an object."""
    text, data, bss = (int(word) for word in listing.splitlines()[1].split()[:3])
    return text, data + bss
