"""The command line's view of a folder from its ledger alone: read as data, without the study."""

from __future__ import annotations

import json
import os
from pathlib import Path

from workbench.cli.sentences import printable
from workbench.study.ledger import about
from workbench.study.ledger.about import About, about_of
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import TABLE, chunks, is_chunk


def digests(folder: Path) -> str:
    """The SHA-256 of every whole chunk by its name, as JSON: none where there is no ledger, as before the first one."""
    return json.dumps({chunk.name: chunk.digest.hex() for chunk in chunks(folder) if is_chunk(chunk.name)})


def status(folder: Path) -> list[str]:
    """How much of each sweep is done, and how many of its runs diverged."""
    from workbench.study.ledger.resume import lost, runs_of

    held, said = _read(folder)
    lines = []
    for sweep in said.sweeps:
        there = [held[name] for name in sweep.chunks if name in held]
        of = "of at most" if sweep.at_most else "of"
        lines.append(
            f"{sweep.name}: {sum(map(runs_of, there)):,} {of} {sweep.runs:,} runs in {len(there)} {of} "
            f"{len(sweep.chunks)} chunks, {sum(map(lost, there)):,} failed; {sweep.arithmetic}."
        )
    complete = all(name in held for sweep in said.sweeps for name in sweep.chunks)
    rest = "Nothing is missing." if complete else "Its command goes on with the rest."
    return [printable(line) for line in (*lines, f"The study is '{said.study}' in '{_script(folder, said)}'. {rest}")]


def write(folder: Path, form: str) -> list[str]:
    """Write the runs of each complete sweep, and the single cases, to files; say which, and what is missing."""
    from workbench.study import rows
    from workbench.study.sample import sample_of

    cases = []
    if (folder / rows.CASES).is_file():
        cases = [f"{rows.write_cases(folder, form)}: the single cases, one row a metric and number."]
    try:
        held, said = _read(folder)
    except LookupError:
        if not cases:
            raise
        return [printable(line) for line in cases]
    tables = {sweep.name: held.get(f"{TABLE}/{sweep.name}") for sweep in said.sweeps}
    samples = [sample_of(table) for table in tables.values() if table is not None]
    lines = [f"{rows.write(sample, folder / 'runs', form)}: {sample.note}." for sample in samples]
    left_out = (name for name, table in tables.items() if table is None)
    lines += (f"{name} is not complete: `workbench status {folder}` says how far it is." for name in left_out)
    return [printable(line) for line in (*cases, *lines)]


def study_of(folder: Path, study: Path | None) -> tuple[Path, int | None]:
    """The script that was named for the study whose ledger is in a folder, and the samples it was run with.

    Raises
    ------
    LookupError
        If none was named: a folder may come from anywhere, so what it names itself is shown, and never run.
    """
    said = _read(folder)[1]
    if study is None:
        there = _script(folder, said)
        raise LookupError(
            f"`workbench report {folder}` needs the study, whose code makes a report of the runs. The folder names "
            f"'{there}', which is not run unasked: if you trust it, add `--study {there}`."
        )
    return study, said.samples


def _script(folder: Path, said: About) -> str:
    return os.path.relpath((folder / said.script).absolute())


def _read(folder: Path) -> tuple[dict[str, Chunk], About]:
    """The whole records by name, and what the ledger says of them."""
    if not folder.is_dir():
        raise LookupError(f"There is no folder '{folder}': name the one that `workbench run` has written.")
    held = {chunk.name: chunk for chunk in chunks(folder)}
    said = about_of(held[about.NAME]) if about.NAME in held else None
    if said is None:
        raise LookupError(
            f"There is no ledger in '{folder}', or its head is damaged: a study with sweeps has one as soon as it "
            "runs, and `workbench run STUDY --out DIR` mends it."
        )
    return held, said
