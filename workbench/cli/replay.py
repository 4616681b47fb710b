"""The verb `replay`: the law of a loop on all machines that can be had here, compared with the simulation."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from workbench.cli.errors import aside, one_sentence, printable_lines

PATH = click.Path(path_type=Path)


@click.command()
@click.argument("file", type=PATH)
@click.option("--loop", "name", help="The name of the loop in FILE; by default 'loop', or the last loop.")
@click.option("--case", help="A case of the study in FILE, as 'scenario: law', in place of --loop.")
@click.option(
    "--period", type=float, help="The period in s of the computer, if the loop in FILE is in continuous time."
)
@click.option(
    "--delay", is_flag=True, help="Apply each command one period late, if the loop in FILE is in continuous time."
)
@click.option("--periods", type=int, default=10_000, show_default=True, help="The number of periods to run.")
@click.option(
    "--substeps",
    type=int,
    default=1,
    show_default=True,
    help="The number of Runge-Kutta steps of the plant in a period.",
)
@click.option(
    "--precision",
    type=click.Choice(["double", "single"]),
    default="double",
    show_default=True,
    help="The precision of the numbers of the law.",
)
@click.option(
    "--target",
    "targets",
    multiple=True,
    help="A machine, such as gcc-O2, arm64 or cortex-m4f; by default all; may be repeated.",
)
@click.option(
    "--truth",
    "truths",
    multiple=True,
    help="A signal that no instrument gives, as an input of the law; may be repeated.",
)
def replay(
    file: Path,
    name: str | None,
    case: str | None,
    period: float | None,
    delay: bool,
    periods: int,
    substeps: int,
    precision: str,
    targets: tuple[str, ...],
    truths: tuple[str, ...],
) -> None:
    """Run the law of a loop in FILE with this machine's compilers, on processors under QEMU and in a browser's engine.

    Each is handed what the simulated instruments read, and its commands and its memory are compared with the portable
    arithmetic, bit by bit. The exit status is 1 if a bit differs or nothing could be run.
    """
    with one_sentence(file):
        from workbench.cli.loops import sampled_of

        chosen, sampled = sampled_of(file, name, period, delay, case)
        from workbench.handover.replays import replay as replay_of

        result = replay_of(
            sampled,
            periods=periods,
            targets=targets or None,
            substeps=substeps,
            truths=truths,
            precision=precision,
            progress=lambda target: aside(f"{target} ..."),
        )
        click.echo(printable_lines(f"'{chosen}': {result.text()}"))
        if not result.equal:
            sys.exit(1)
