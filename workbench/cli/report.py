"""The verb `report`: the page of a study from the runs that its ledger holds."""

from __future__ import annotations

from pathlib import Path

import click

from workbench.cli.errors import one_sentence
from workbench.cli.run import run_study


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--study", type=click.Path(path_type=Path), help="The file of the study; it is run because you name it.")
def report(folder: Path, study: Path | None) -> None:
    """Write the report in DIR again, from the runs in its ledger.

    A folder may come from anywhere, so the file that it names is never run: give it with --study.
    """
    with one_sentence():
        from workbench.study.ledger.store import contents

        about = contents(folder)[1]
        if study is None:
            there = about.script_from(folder)
            raise LookupError(
                f"`workbench report {folder}` needs the study, whose code makes a report of the runs. The folder names "
                f"'{there}', which is not run unasked: if you trust it, add `--study {there}`."
            )
        run_study(study, folder, {"samples": about.samples, "only_report": True})
