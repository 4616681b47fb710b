"""The verb `status`: the progress of a study, from its ledger alone."""

from __future__ import annotations

from pathlib import Path

import click

from workbench.cli.errors import one_sentence, printable


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def status(folder: Path) -> None:
    """Say how much of the study in DIR is done, and what has failed."""
    with one_sentence():
        from workbench.study.ledger.store import contents, diverged_count, runs_of
        from workbench.study.ledger.study_record import UNUSED_CHUNKS

        held, about = contents(folder)
        for sweep in about.runs:
            there = [held[name] for name in sweep.chunks if name in held]
            of = "of at most" if sweep.at_most else "of"
            line = (
                f"{sweep.name}: {sum(map(runs_of, there)):,} {of} {sweep.runs:,} runs in {len(there)} {of} "
                f"{len(sweep.chunks)} chunks, {sum(map(diverged_count, there)):,} failed; {sweep.arithmetic}."
            )
            click.echo(printable(line))
        if unused := about.count_unused(held):
            click.echo(printable(UNUSED_CHUNKS.format(count=unused, out=folder)))
        for work in about.works:
            done = sum(name in held for name in work.chunks)
            click.echo(printable(f"{work.name}: {done:,} of {len(work.chunks):,} items of work."))
        if about.more:
            click.echo("Its works follow from results that are not there yet.")
        complete = not about.more and all(name in held for name in about.chunks)
        rest = "Nothing is missing." if complete else "Its command goes on with the rest."
        if about.has_changed(folder):
            rest = "It has changed since it was run: only its command can say what is missing."
        elif not (about.runs or about.works or about.more):
            rest = "It has no sweeps and no works."
        click.echo(printable(f"The study is '{about.study}' in '{about.script_from(folder)}'. {rest}"))
