"""The verb `export`: the law of a loop in a file, in the form that another machine takes."""

from __future__ import annotations

import shlex
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

import click

from workbench.cli.errors import aside, one_sentence, printable

if TYPE_CHECKING:
    from workbench.core import SampledSystem
    from workbench.handover.c99.c_files import COptions

PATH = click.Path(path_type=Path)
FORMS = ("c", "cortex-m4", "python", "casadi", "control", "mat", "simulink", "ros2", "fmi2", "fmi3")
WAYS = ("portable", "hardware")
PERIODS = 2000  # of the run that tells whether the loop holds at its period


class ExportOptions(TypedDict):
    """The options of the verb that are no arguments of their own."""

    period: float | None
    delay: bool
    name: str | None
    precision: str
    sqrt: str
    fma: str
    settable: bool
    built_in: bool
    truths: tuple[str, ...]
    overwrite: bool
    safe: tuple[str, ...]


@click.command()
@click.argument("file", type=PATH)
@click.option("--form", type=click.Choice(FORMS), default="c", show_default=True, help="The form; 'c' is C99.")
@click.option("--loop", help="The name of the loop in FILE; by default 'loop', or the last loop.")
@click.option("--case", help="A case of the study in FILE, as 'scenario: law', in place of --loop.")
@click.option(
    "--period", type=float, help="The period in s of the computer, if the loop in FILE is in continuous time."
)
@click.option(
    "--delay", is_flag=True, help="Apply each command one period late, if the loop in FILE is in continuous time."
)
@click.option("--name", help="The prefix of all names, an identifier of C; by default the name of the law.")
@click.option("--out", type=PATH, help="The folder; by default one with the name of the law in the current folder.")
@click.option(
    "--precision",
    type=click.Choice(("double", "single")),
    default="double",
    show_default=True,
    help="The precision of the numbers of the law.",
)
@click.option(
    "--sqrt",
    type=click.Choice(WAYS),
    default=WAYS[0],
    show_default=True,
    help="The square root: own code, or that of C's library, with the same bits.",
)
@click.option(
    "--fma",
    type=click.Choice(WAYS),
    default=WAYS[0],
    show_default=True,
    help="Products and their sums: rounded one by one, or once by C's library.",
)
@click.option("--settable", is_flag=True, help="Let the numbers of the law be changed between two instants.")
@click.option("--built-in", is_flag=True, help="Put the reference into the law; by default it is an input of the law.")
@click.option(
    "--truth",
    "truths",
    multiple=True,
    help="A signal that no instrument gives, as an input of the law; may be repeated.",
)
@click.option("--overwrite", is_flag=True, help="Replace files that were edited, or that no export has written.")
@click.option(
    "--safe",
    multiple=True,
    metavar="NAME=VALUE",
    help="The command if a number is not finite, by its name; may be repeated.",
)
def export(
    file: Path, form: str, loop: str | None, case: str | None, out: Path | None, **verb_options: Unpack[ExportOptions]
) -> None:
    """Write the law of a loop in FILE for another machine: observer, law, limits and delay, without the plant."""
    with one_sentence(file):
        safe = _safe(verb_options["safe"])
        from workbench.cli.loops import sampled_of
        from workbench.handover.law_export import export as written
        from workbench.handover.law_export import loss_in_single_precision

        chosen, sampled = sampled_of(file, loop, verb_options["period"], verb_options["delay"], case)
        law = sampled.law("built in" if verb_options["built_in"] else "input", verb_options["truths"])
        warnings = _warnings(sampled)
        for warning in warnings:
            aside(f"Warning: {warning}.")
        if verb_options["precision"] == "single":
            warnings = (*warnings, loss_in_single_precision(sampled, law))
        options = _options(verb_options, safe, warnings)
        paths = written(law, form, out, name=verb_options["name"], overwrite=verb_options["overwrite"], **options)
        if form.startswith("fmi") and not _has_library(paths[0]):
            aside("The FMU has C sources alone, as no compiler was found here: `apt-get install gcc`.")
        aside(f"'{chosen}', every {law.period:g} s.")
        click.echo(printable(f"Written: {', '.join(map(str, paths))}."))


def _options(asked: ExportOptions, safe: Mapping[str, float], warnings: tuple[str, ...]) -> COptions:
    """The options of the code that differ from its defaults, as not every form takes them."""
    options: COptions = {"warnings": warnings, "command": _command()}
    if safe:
        options["safe"] = safe
    if asked["precision"] == "single":
        options["precision"] = "single"
    if asked["sqrt"] == "hardware":
        options["sqrt"] = "hardware"
    if asked["fma"] == "hardware":
        options["fma"] = "hardware"
    if asked["settable"]:
        options["parameters"] = "settable"
    return options


def _safe(texts: tuple[str, ...]) -> dict[str, float]:
    """Safe commands by name."""
    safe: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            number = float(value)
        except ValueError:
            equals = ""
        if not (name and equals) or name in safe:
            raise ValueError(f"`--safe` must be a command and a number, once each, as `--safe tau=0`; got '{text}'.")
        safe[name] = number
    return safe


def _warnings(sampled: SampledSystem) -> tuple[str, ...]:
    """The sentences that whoever runs the law must know of its period."""
    from workbench.engine import simulate

    step = sampled.step(4)
    until = min(PERIODS * sampled.period, step.flow.horizon)
    run = simulate(step, until=max(int(until / sampled.period), 1) * sampled.period)
    if not run.has_diverged.any():
        return ()
    return (
        f"in a simulation of the loop with this law, every {sampled.period:g} s, a number is not finite "
        f"after {float(run.diverged_at[0]):g} s: the period is too long, or the loop is unstable",
    )


def _has_library(path: Path) -> bool:
    with zipfile.ZipFile(path) as archive:
        return any(name.startswith("binaries/") for name in archive.namelist())


def _command() -> str:
    """The command, with no more of this machine's folders than the user typed."""
    return shlex.join(["workbench", *map(_plain, sys.argv[1:])])


def _plain(word: str) -> str:
    path = Path(word)
    return path.name if path.is_absolute() else word
