"""What the command line says of a folder from its ledger alone, without the study."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from workbench import __version__
from workbench.study.chunk import Chunk
from workbench.study.store import ABOUT, chunks


def digests(folder: Path) -> str:
    """The SHA-256 of every whole chunk by its name, as JSON: none where there is no ledger, as before the first one."""
    return json.dumps({chunk.name: chunk.digest.hex() for chunk in chunks(folder) if chunk.name != ABOUT})


def status(folder: Path) -> list[str]:
    """How much of each sweep is done, and how many of its runs diverged."""
    from workbench.study.resume import lost

    held, about = _read(folder)
    lines = []
    for sweep in about["sweeps"]:
        there = [held[name] for name in sweep["chunks"] if name in held]
        done = sum(_runs(chunk) for chunk in there)
        failed = sum(map(lost, there))
        lines.append(
            f"{sweep['name']}: {done:,} of {sweep['runs']:,} runs in {len(there)} of {len(sweep['chunks'])} chunks, "
            f"{failed:,} failed."
        )
    missing = any(name not in held for sweep in about["sweeps"] for name in sweep["chunks"])
    rest = "Its command goes on with the rest." if missing else "Nothing is missing."
    return [*lines, f"The study is '{about['study']}' in '{_script(folder, about)}'. {rest}"]


def write(folder: Path, form: str) -> list[str]:
    """Write the runs of each complete sweep to a file, and say which, and what is missing."""
    from workbench.study import rows
    from workbench.study.resume import samples_of

    held, about = _read(folder)
    samples = samples_of(about["sweeps"], held)
    lines = [f"{rows.write(sample, folder / 'runs', form)}: {sample.note}." for sample in samples]
    written = {sample.name for sample in samples}
    left_out = (sweep["name"] for sweep in about["sweeps"] if sweep["name"] not in written)
    return [*lines, *(f"{name} is not complete: `workbench status {folder}` says how far it is." for name in left_out)]


def script_of(folder: Path) -> tuple[Path, int | None]:
    """The script of the study whose ledger is in a folder, and the number of samples it was run with."""
    _, about = _read(folder)
    return _script(folder, about), about["samples"]


def _script(folder: Path, about: dict[str, Any]) -> Path:
    return Path(os.path.relpath((folder / about["script"]).resolve()))


def _read(folder: Path) -> tuple[dict[str, Chunk], dict[str, Any]]:
    """The whole records by name, and what the ledger says of them."""
    _check_folder(folder)
    held = {chunk.name: chunk for chunk in chunks(folder)}
    if ABOUT not in held:
        raise LookupError(
            f"There is no ledger in '{folder}', or its head is damaged: a study with sweeps has one as soon as it "
            "runs, and `workbench run STUDY --out DIR` mends it."
        )
    about = held[ABOUT].said
    if (theirs := about["workbench"]) != __version__:
        raise LookupError(
            f"The ledger in '{folder}' was written by workbench {theirs}, and this is {__version__}: ask that version. "
            "Nothing of it is lost."
        )
    return held, about


def _check_folder(folder: Path) -> None:
    if not folder.is_dir():
        raise LookupError(f"There is no folder '{folder}': name the one that `workbench run` has written.")


def _runs(chunk: Chunk) -> int:
    """How many runs a chunk has."""
    return next(int(shape[0]) for name, shape in chunk.said["arrays"] if name == "diverged_at")
