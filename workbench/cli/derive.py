"""The verb `derive`: M, C and G of an arm, to be read or to be computed with."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from workbench.cli.errors import one_sentence, printable_lines

if TYPE_CHECKING:
    from workbench.arms.dynamics import AbstractArm, Dynamics

READABLE, PROGRAMS = ("text", "latex", "typst", "mathml"), ("python", "casadi", "c")
FORMS = (*READABLE, *PROGRAMS)


@click.command()
@click.argument("robot")
@click.option("--format", "form", type=click.Choice(FORMS), default="text", show_default=True)
@click.option("--numbers", is_flag=True, help="Put the nominal numbers of ROBOT in place of its letters.")
def derive(robot: str, form: str, numbers: bool) -> None:
    """Print M, C and G of ROBOT, an arm of the catalogue or a URDF file.

    Text, LaTeX, Typst and MathML are for reading; Python, CasADi and C compute the same numbers, and inverse
    and forward dynamics too.
    """
    with one_sentence():
        from workbench.arms.code import in_numbers
        from workbench.arms.dynamics import Dynamics

        arm = arm_of(robot)
        click.echo(printable_lines(text_of(in_numbers(*arm) if numbers else Dynamics.of(*arm), form)))


def text_of(dynamics: Dynamics, form: str) -> str:
    """M, C and G of an arm in a form for reading, or as functions of another machine."""
    from workbench.arms import code

    if form in READABLE:
        return code.READABLE[form](dynamics)
    from workbench.handover.array_functions import array_functions

    laws, about, parameters, sizes = code.functions_of(dynamics)
    return array_functions(laws, form, about, parameters, sizes)


def arm_of(name: str) -> tuple[AbstractArm, str]:
    """An arm of the catalogue, or of a URDF file, and its name."""
    from workbench.arms.mechanics import CATALOGUE, robot, urdf

    file = Path(name)
    if file.suffix.lower() == ".urdf" or (name not in CATALOGUE and file.is_file()):
        return urdf.read_urdf(file), file.stem
    if len(file.parts) > 1 or file.suffix:
        raise LookupError(f"There is no file '{name}'; a robot is an arm of the catalogue or a URDF file.")
    return robot(name), name
