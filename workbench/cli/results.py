"""The verb `results`: the runs of a study as tables, from its folder alone."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import click

from workbench.cli.errors import one_sentence, printable


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--digests", is_flag=True, help="Print the SHA-256 of each chunk as JSON, and write nothing.")
@click.option("--format", "form", type=click.Choice(("csv", "parquet", "mat")), default="csv", show_default=True)
def results(folder: Path, digests: bool, form: str) -> None:
    """Write the runs of each sweep in DIR as a table, one row per run, and its single cases as another, to DIR/runs.

    The answers of its works are written there as JSON; a number that JSON lacks is written as text, such as 'nan'.
    """
    with one_sentence():
        from workbench.study.ledger.store import chunks, is_chunk

        if digests:
            held = {chunk.name: chunk.digest.hex() for chunk in chunks(folder) if is_chunk(chunk.name)}
            click.echo(json.dumps(held))
        else:
            click.echo("\n".join(map(printable, _write(folder, form))))


def _write(folder: Path, form: str) -> Iterator[str]:
    """Write the single cases and the runs of each complete sweep to files; a line names each, or a missing one."""
    from workbench.study import run_tables
    from workbench.study.answer_files import write_answers
    from workbench.study.ledger.store import TABLE, contents
    from workbench.study.ledger.study_record import UNUSED_CHUNKS

    held, about = contents(folder)
    if about.cases is not None:
        table = held.get(f"{TABLE}/{about.cases.name}")
        if table is None:
            yield f"The cases are not complete: `workbench status {folder}` says how far they are."
        else:
            yield f"{run_tables.write_cases(folder, form, table)}: the single cases, one row a metric and number."
    tables = {sweep.name: held.get(f"{TABLE}/{sweep.name}") for sweep in about.sweeps}
    samples = [run_tables.sample_of(table) for table in tables.values() if table is not None]
    for sample in samples:
        yield f"{run_tables.write(sample, folder / 'runs', form)}: {sample.note}."
    for name in (name for name, table in tables.items() if table is None):
        yield f"{name} is not complete: `workbench status {folder}` says how far it is."
    for work in about.works:
        if any(name not in held for name in work.chunks):
            yield f"{work.name} is not complete: `workbench status {folder}` says how far it is."
            continue
        file = write_answers(work.name, [held[name] for name in work.chunks], folder / "runs")
        yield f"{file}: the answers of '{work.name}' to {len(work.chunks):,} items."
    if not (about.runs or about.works):
        yield f"The study '{about.study}' has no sweeps and no works."
    if unused := about.count_unused(held):
        yield UNUSED_CHUNKS.format(count=unused, out=folder)
    if about.has_changed(folder):
        script = about.script_from(folder)
        yield f"'{script}' has changed since it was run: these are earlier runs, and `workbench run` makes new ones."
