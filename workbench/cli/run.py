"""The verb `run`: run the study in a file, and write its report."""

from __future__ import annotations

import gc
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

import click

from workbench.cli.errors import aside, of_the_study, one_sentence, printable

if TYPE_CHECKING:
    from workbench.study.ledger.chunk import Chunk

PATH = click.Path(path_type=Path)


class RunOptions(TypedDict, total=False):
    """The options of a run that are no arguments of their own, by the names of `StudyOptions`."""

    samples: int | None
    workers: int | None
    cluster: str | None
    arithmetic: str | None
    fresh: bool
    yes: bool
    only_report: bool
    acknowledge: Callable[[Chunk], None]


@click.command()
@click.argument("study", type=PATH)
@click.option("--out", type=PATH, help="The folder of the report; by default reports/NAME.")
@click.option("--samples", type=int, help="The number of samples of each sweep, in place of that in STUDY.")
@click.option(
    "--workers", type=int, help="The number of threads, or of workers of a local cluster; by default one per processor."
)
@click.option("--cluster", metavar="ADDRESS", help="The scheduler of a Dask cluster; 'local' starts one here.")
@click.option(
    "--arithmetic",
    type=click.Choice(("fused", "portable")),
    help="The arithmetic of the sweeps; by default that of the ledger.",
)
@click.option("--fresh", is_flag=True, help="Compute everything again, also what the ledger holds.")
@click.option("--ack", is_flag=True, help="Print each chunk and its SHA-256 once it is on the disk.")
@click.option("--yes", is_flag=True, help="Start, even if much time, memory and disk are needed.")
@click.option("--traceback", is_flag=True, help="Print Python's traceback after the sentence of an error.")
def run(study: Path, out: Path | None, ack: bool, traceback: bool, **options: Unpack[RunOptions]) -> None:
    """Run STUDY, a Python file or a folder with a `study.py`, and write its report.

    No run of a sweep or work is computed twice: after a stop, the same command continues.
    """
    del traceback  # `leave` looks it up
    if ack:
        options["acknowledge"] = lambda chunk: click.echo(f"ACK {chunk.name} {chunk.digest.hex()}")
    run_study(study, out, options)


def run_study(place: Path, out: Path | None, options: RunOptions) -> None:
    """Run the parts of a study that its ledger lacks, and write its report."""
    from workbench.cli import script

    file = script.file_of(place)
    with one_sentence(file):
        script.check_file(file)
        # What a report needs comes before the study, whose folder goes first on the path: a file beside the study may
        # have the name of a module that is used here. Matplotlib comes behind it, when that folder is the last.
        from importlib import import_module

        with suppress(ImportError):  # llvmlite has no wheel here, and the other engine serves
            import_module("workbench.engine.kernel.native")
        from concurrent.futures import ThreadPoolExecutor
        from functools import partial

        from workbench.cli.progress import runs_shown
        from workbench.report import folder
        from workbench.report.live.live_data import live_data
        from workbench.report.verdict_lines import verdict_lines
        from workbench.study import run_tables, writeup
        from workbench.study.execution import execute
        from workbench.study.run_options import StudyOptions

        study = script.load(file)
        target = out or Path("reports") / study.name
        folder.check_place(target)
        source = partial(script.Script.of, file, options["samples"])
        named, command = script.short_path(place), script.command(place, out, options["samples"])
        of_headlines, of_sections = (of_the_study(file, part) for part in (study.headlines, study.sections))

        # what was imported stays, and little is made that only the collector can free: 0.25 s of looking
        gc.freeze()
        gc.set_threshold(50_000)
        order = StudyOptions(file, say=aside, source=source, bar=partial(runs_shown, say=aside), **options)
        with execute(study, target, order) as (study, results), ThreadPoolExecutor(1) as beside:
            beside.submit(import_module, "workbench.report.figures.figure_sheet")  # 0.3 s, for the end
            with of_headlines:
                findings = writeup.headlines(study, results)
            with of_sections:
                page = writeup.document(study, results, command)
                tables = run_tables.tables(results)
                folder.write(page, target, tables, live_data(study, results, page, named))
            findings = findings or verdict_lines(page)
        places = f"The report is {target / 'index.html'}, and {target / 'report.pdf'}."
        click.echo("\n".join(map(printable, [*findings, places])))
        gc.freeze()  # nothing more is freed before the process ends, which frees all
